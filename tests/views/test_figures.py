import re
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

from a2s_drake.guidance.laws import LAW_STYLES
from a2s_drake.scenario.parts import PAPER_LAWS
from a2s_drake.study.paper.attribution import Step
from a2s_drake.study.paper.results import CeilingRow, PaperGains, ReadingRow
from a2s_drake.views import figures
from tests.support.flights import SAMPLES, made_up_flight

FLIGHTS = {law: made_up_flight(law) for law in PAPER_LAWS}
ROWS = [
    ReadingRow(base, "fallback", answer, False, gain, gain / 2.0, 0.0, 0.2, 0)
    for base in ("paper", "paper_calibrated")
    for answer, gain in (("zero", 20.0), ("nearest", 30.0))
]
CEILINGS = [
    CeilingRow("best", "ceiling", "", gain_percent=45.6, share=1.0),
    CeilingRow("not shown", "other", "level", gain_percent=1.0, share=0.02),
    CeilingRow("flown", "flown", "pitch_only", gain_percent=31.0, share=0.68),
]
STEPS = [
    Step(law, effect, "the best", gain_percent=gain, cost=cost, share=None)
    for law in ("three_axis", "planned")
    for effect, gain, cost in (("", 45.0, 0.0), ("rate", 41.0, 4.0), ("tracking", 41.5, -0.5), ("position", 41.5, 0.04))
]
ALL = {
    "geometry": figures.geometry_figure,
    "trajectory": lambda: figures.trajectory_figure(FLIGHTS["three_axis"]),
    "position": lambda: figures.position_figure(FLIGHTS),
    "channel_gain": lambda: figures.channel_gain_figure(FLIGHTS),
    "outage": lambda: figures.outage_figure(FLIGHTS),
    "reference": lambda: figures.reference_figure(FLIGHTS["three_axis"]),
    "attitude_error": lambda: figures.attitude_error_figure(FLIGHTS["three_axis"]),
    "attitude": lambda: figures.attitude_figure(FLIGHTS["three_axis"]),
    "velocity": lambda: figures.velocity_figure(FLIGHTS["three_axis"]),
    "angular_velocity": lambda: figures.angular_velocity_figure(FLIGHTS["three_axis"]),
    "rotor_speed": lambda: figures.rotor_speed_figure(FLIGHTS["three_axis"]),
    "readings": lambda: figures.readings_figure(ROWS, PaperGains(over_level=22.2, over_pitch_only=11.4)),
    "ceiling": lambda: figures.ceiling_figure({"paper": CEILINGS, "paper_calibrated": CEILINGS}),
    "attribution": lambda: figures.attribution_figure(STEPS),
    "affine_error": lambda: figures.affine_error_figure(np.arange(3.0), np.ones((3, 26))),
}


def plotted(figure: Figure, panel: int = 0) -> dict[str, np.ndarray]:
    return {line.get_label(): np.asarray(line.get_ydata()) for line in figure.axes[panel].get_lines()}


@pytest.mark.parametrize("name", ALL)
def test_figures_are_a_column_wide_and_leave_matplotlib_as_it_was(name: str, tmp_path: Path) -> None:
    before = dict(mpl.rcParams)
    figure = ALL[name]()
    figures.save_figure(figure, tmp_path / name)
    assert dict(mpl.rcParams) == before
    assert figure.get_size_inches()[0] == pytest.approx(8.5 / 2.54)
    assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (tmp_path / f"{name}.svg").read_text()


@pytest.mark.parametrize("name", sorted(set(ALL) - {"geometry"}))
def test_axes_state_their_units(name: str) -> None:
    figure = ALL[name]()
    labels = [axes.get_xlabel() for axes in figure.axes] + [axes.get_ylabel() for axes in figure.axes]
    labels += [figure.get_supxlabel(), figure.get_supylabel()]
    for label in filter(None, labels):
        assert re.search(r"\((s|m|cm|m/s|rad|rad/s|deg|dB|Hz|%)\)", label) or label == "share of time below"


@pytest.mark.parametrize("name", ALL)
def test_text_is_legible_in_print(name: str) -> None:
    sizes = [text.get_fontsize() for text in ALL[name]().findobj(mpl.text.Text) if text.get_text()]
    assert min(sizes) >= 5.0


def test_channel_gain_draws_each_law_in_its_own_style_in_db() -> None:
    lines = figures.channel_gain_figure(FLIGHTS).axes[0].get_lines()
    assert [line.get_color() for line in lines] == [LAW_STYLES[law]["color"] for law in PAPER_LAWS]
    np.testing.assert_allclose(lines[0].get_ydata(), 10.0 * np.log10(15e-9))


def test_law_styles_differ_in_grey_print() -> None:
    luminance = []
    for style in LAW_STYLES.values():
        red, green, blue = (int(style["color"][i : i + 2], 16) for i in (1, 3, 5))
        luminance.append(0.2126 * red + 0.7152 * green + 0.0722 * blue)
    assert np.diff(sorted(luminance)).min() > 30.0
    assert len({style["linestyle"] for style in LAW_STYLES.values()}) == len(LAW_STYLES)


def test_outage_steps_where_the_snr_lies() -> None:
    flight = made_up_flight(snr_db=np.array([1.0, 2.0, 4.0, 5.0, 10.0]))
    lines = figures.outage_figure({"level": flight}).axes[0].get_lines()
    thresholds, share = lines[0].get_data()
    assert share[np.searchsorted(thresholds, 3.0)] == pytest.approx(0.4)
    np.testing.assert_allclose(lines[1].get_ydata(), [0.0, 0.4, 0.8, 0.8, 1.0])


def test_attitude_draws_flown_over_reference_in_degrees_between_bounds() -> None:
    flown = np.deg2rad(np.arange(3.0 * SAMPLES)).reshape(SAMPLES, 3)
    figure = figures.attitude_figure(made_up_flight(attitude=flown, attitude_reference=-flown))
    assert [axes.get_ylabel() for axes in figure.axes] == ["roll (deg)", "pitch (deg)", "yaw (deg)"]
    for axis in range(3):
        reference, mine, *limits = figure.axes[axis].get_lines()
        np.testing.assert_allclose(mine.get_ydata(), np.rad2deg(flown[:, axis]))
        np.testing.assert_allclose(reference.get_ydata(), -np.rad2deg(flown[:, axis]))
        assert sorted(line.get_ydata()[0] for line in limits) == [-15.0, 15.0]


def test_attitude_error_is_flown_minus_reference() -> None:
    flight = made_up_flight(attitude=np.full((SAMPLES, 3), 0.1), attitude_reference=np.full((SAMPLES, 3), 0.3))
    np.testing.assert_allclose(plotted(figures.attitude_error_figure(flight))["pitch"], np.rad2deg(-0.2))


def test_velocity_is_drawn_with_its_bounds() -> None:
    flight = made_up_flight(velocity=np.tile([0.1, 0.2, 0.3], (SAMPLES, 1)))
    lines = figures.velocity_figure(flight).axes[0].get_lines()
    assert [line.get_ydata()[0] for line in lines] == [0.1, 0.2, 0.3, -1.0, 1.0]


def test_rotor_speeds_are_drawn_one_a_panel_with_their_bounds() -> None:
    flight = made_up_flight(rotor_speed=np.tile([51.0, 52.0, 53.0, 54.0, 55.0, 56.0], (SAMPLES, 1)))
    figure = figures.rotor_speed_figure(flight)
    for rotor, axes in enumerate(figure.axes):
        assert [line.get_ydata()[0] for line in axes.get_lines()] == [51.0 + rotor, 16.0, 100.0]


def test_readings_stand_at_their_gains() -> None:
    figure = ALL["readings"]()
    series = {line.get_label(): sorted(line.get_xdata()) for line in figure.axes[0].get_lines()}
    assert series["from paper"] == series["from paper_calibrated"] == [20.0, 30.0]
    assert series["printed in the paper"] == [22.2, 22.2]
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == ["fallback: zero", "fallback: nearest"]


def test_ceiling_states_shares() -> None:
    axes = ALL["ceiling"]().axes[1]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["best", "pitch only flown"]
    texts = [text.get_text() for text in axes.texts]
    assert texts == ["45.6 % (100 %)", "31.0 % (68 %)"]


def test_attribution_states_what_is_left_and_what_it_cost() -> None:
    figure = ALL["attribution"]()
    assert [axes.get_title() for axes in figure.axes] == ["three axes", "planned"]
    axes = figure.axes[1]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["the best", "rate", "tracking", "position"]
    texts = [text.get_text() for text in axes.texts]
    assert texts == ["45.0 %", "41.0 % (-4.0)", "41.5 % (+0.5)", "41.5 % (+0.0)"]
    assert all(text.get_position()[0] < 0.7 * axes.get_xlim()[1] for text in axes.texts)
