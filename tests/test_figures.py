from pathlib import Path

import numpy as np
import pytest

from a2s_drake.figures import LAW_STYLES, attitude_figure, channel_gain_figure
from a2s_drake.parameters import LAWS
from tests.flights import SAMPLES, made_up_flight


def test_channel_gain_draws_each_law_in_its_own_style_in_db() -> None:
    figure = channel_gain_figure([made_up_flight(law) for law in LAWS])
    lines = figure.axes[0].get_lines()
    assert [line.get_color() for line in lines] == [LAW_STYLES[law]["color"] for law in LAWS]
    np.testing.assert_allclose(lines[0].get_ydata(), 10.0 * np.log10(15e-9))
    assert figure.axes[0].get_xlabel() == "time (s)"
    assert figure.axes[0].get_ylabel().endswith("(dB)")


def test_law_styles_differ_in_grey_print() -> None:
    luminance = []
    for style in LAW_STYLES.values():
        red, green, blue = (int(style["color"][i : i + 2], 16) for i in (1, 3, 5))
        luminance.append(0.2126 * red + 0.7152 * green + 0.0722 * blue)
    gaps = np.diff(sorted(luminance))
    dashes = {style["linestyle"] for style in LAW_STYLES.values()}
    assert gaps.min() > 5.0
    assert len(dashes) == len(LAW_STYLES)


def test_attitude_draws_flown_over_reference_in_degrees() -> None:
    flown = np.deg2rad(np.arange(3.0 * SAMPLES)).reshape(SAMPLES, 3)
    figure = attitude_figure(made_up_flight(attitude=flown, attitude_reference=-flown))
    assert [axes.get_ylabel() for axes in figure.axes] == ["roll (deg)", "pitch (deg)", "yaw (deg)"]
    for axis, axes in enumerate(figure.axes):
        reference, mine, *limits = axes.get_lines()
        np.testing.assert_allclose(mine.get_ydata(), np.rad2deg(flown[:, axis]))
        np.testing.assert_allclose(reference.get_ydata(), -np.rad2deg(flown[:, axis]))
        assert sorted(line.get_ydata()[0] for line in limits) == [-15.0, 15.0]


@pytest.mark.parametrize("figure", [channel_gain_figure([made_up_flight()]), attitude_figure(made_up_flight())])
def test_figures_save_without_pyplot(figure, tmp_path: Path) -> None:
    figure.savefig(tmp_path / "figure.png")
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")
