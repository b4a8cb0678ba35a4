"""The replay of a path and a track from files."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Meshcat

from a2s_drake import Scenario
from a2s_drake.guidance.courses import Courses
from a2s_drake.views.replay.gauge import gauge_scale
from a2s_drake.views.replay.scene import Scene, view_frame
from a2s_drake.views.replay.stage import start_meshcat
from tests.support.tracks import circle, write_track

TIME = np.linspace(0.0, 40.0, 401)


def sailing(tmp_path: Path, x: np.ndarray, y: np.ndarray) -> Scenario:
    file = write_track(tmp_path / "ship.csv", TIME, np.stack([x, y], axis=-1), "time,x,y")
    return Scenario().with_value("mission.ship_track_file", file)


def heading_deg(scene: Scene, time: float) -> float:
    """Where the ship's bow points on the page, deg."""
    R_WS = scene._heading(time).matrix()
    return float(np.rad2deg(np.arctan2(R_WS[1, 0], R_WS[0, 0])))


@pytest.fixture
def meshcat() -> Meshcat:
    return start_meshcat(port=0)


def test_a_turning_ship_points_where_it_sails(tmp_path: Path, meshcat: Meshcat) -> None:
    turn = np.pi * TIME / 40.0  # half around a circle of 30 m, anticlockwise: it heads from north to south
    scenario = sailing(tmp_path, 60.0 + 30.0 * np.cos(turn), 30.0 * np.sin(turn))
    dut = Scene(meshcat, scenario)
    for time, expected in ((0.0, 90.0), (10.0, 135.0), (20.0, 180.0)):
        assert abs(heading_deg(dut, time)) == pytest.approx(expected, abs=0.01)
    assert heading_deg(dut, 40.0) == pytest.approx(-90.0, abs=0.01)
    assert heading_deg(dut, 60.0) == pytest.approx(-90.0, abs=0.01)  # It has arrived and keeps its heading.
    assert heading_deg(Scene(meshcat, scenario), 60.0) == pytest.approx(-90.0, abs=0.01)  # seen late


def test_on_its_line_the_ship_points_along_it(meshcat: Meshcat) -> None:
    ends = ["mission.ship_start=[90, 0]", "mission.ship_end=[80, 10]"]
    dut = Scene(meshcat, Scenario().with_overrides(ends))
    for time in (0.0, 20.0, 40.0, 41.0):
        assert heading_deg(dut, time) == pytest.approx(135.0, abs=1e-12)


def test_the_gauge_and_the_view_read_the_file(tmp_path: Path) -> None:
    near = sailing(tmp_path, 20.0 + 0.1 * TIME, 0.0 * TIME)
    as_line = Scenario().with_overrides(["mission.ship_start=[20, 0]", "mission.ship_end=[24, 0]"])
    assert gauge_scale(near) == gauge_scale(as_line) != gauge_scale(Scenario())
    np.testing.assert_allclose(view_frame(near).matrix(), view_frame(as_line).matrix(), atol=1e-9)
    path = write_track(tmp_path / "path.csv", TIME, circle(TIME) + np.array([0.0, 5.0, 0.0]))
    aside = view_frame(Scenario().with_value("mission.path_file", path)).matrix()
    assert not np.allclose(aside, view_frame(Scenario()).matrix(), atol=1e-3)


def test_given_courses_win_over_the_scenarios(tmp_path: Path) -> None:
    near = sailing(tmp_path, 20.0 + 0.1 * TIME, 0.0 * TIME)
    courses = Courses.of(near)
    before = gauge_scale(near)
    (tmp_path / "ship.csv").unlink()
    assert gauge_scale(near, courses) == before


def test_the_view_aims_at_the_mast_as_it_truly_is() -> None:
    believed = Scenario().with_overrides(["link.ship_antenna_height=8", "knowledge.ship_antenna_height_error=5"])
    truly = Scenario().with_value("link.ship_antenna_height", 13.0)
    np.testing.assert_allclose(view_frame(believed).matrix(), view_frame(truly).matrix(), atol=1e-12)
    assert not np.allclose(view_frame(believed).matrix(), view_frame(Scenario()).matrix(), atol=1e-3)
