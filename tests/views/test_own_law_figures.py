"""Figures of flights under a law of the user's own: with its name, and in no other law's colour."""

from collections.abc import Callable
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from a2s_drake.guidance.laws import LAW_LABELS, LAW_STYLES, LAWS, label_of, style_of
from a2s_drake.views import figures
from a2s_drake.views.replay import write_replay
from tests.support.flights import made_up_flight

OWN = made_up_flight("level", own_blocks={"law": "_MyLaw"})
OF_ONE = [figures.trajectory_figure, figures.attitude_figure, figures.rotor_speed_figure]
OF_MANY = [figures.channel_gain_figure, figures.outage_figure]


def test_laws_of_the_registry_keep_their_label_and_style() -> None:
    assert {name: label_of(name) for name in LAWS} == LAW_LABELS
    assert {name: style_of(name) for name in LAWS} == LAW_STYLES


def test_an_own_law_has_its_name_and_a_colour_of_no_other() -> None:
    assert label_of("MyLaw") == "MyLaw"
    assert style_of("MyLaw")["color"] not in {style["color"] for style in LAW_STYLES.values()}


@pytest.mark.parametrize("draw", OF_ONE)
def test_a_figure_of_one_flight_is_in_the_own_laws_colour(draw: Callable[..., Figure]) -> None:
    colours = {line.get_color() for axes in draw(OWN).axes for line in axes.get_lines()}
    assert style_of("_MyLaw")["color"] in colours
    assert LAW_STYLES["level"]["color"] not in colours


@pytest.mark.parametrize("draw", OF_MANY)
def test_a_figure_of_many_names_the_own_law_in_its_legend(draw: Callable[..., Figure]) -> None:
    figure = draw({"level": made_up_flight("level"), OWN.law: OWN})
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["level", "MyLaw"]


def test_a_replay_is_titled_by_the_own_law(tmp_path: Path) -> None:
    write_replay(OWN, tmp_path / "replay.html")
    assert "<title>a2s_drake: _MyLaw, " in (tmp_path / "replay.html").read_text(encoding="utf-8")
