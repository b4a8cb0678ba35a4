"""What `feasible.check` asks of a path and a track from files."""

from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Scenario, ScenarioError
from a2s_drake.flight import feasible
from tests.support.tracks import write_track

TIME = np.linspace(0.0, 40.0, 81)


def on_path(tmp_path: Path, *columns: np.ndarray | float, overrides: tuple[str, ...] = ()) -> Scenario:
    """Table I under level on a path with columns x, y, z over TIME."""
    points = np.stack([np.broadcast_to(column, TIME.shape) for column in columns], axis=-1)
    file = write_track(tmp_path / "path.csv", TIME, points)
    return Scenario().with_overrides([f"mission.path_file={file}", "attitude_law.name=level", *overrides])


# The antenna hangs below the vehicle, which all but touches the sea where the path is lowest.
LOW = ("mission.sea_level=-2.55", "link.antenna_offset=[0.39, 0.39, -0.195]")


def bump(height: float, at: float = 30.0) -> np.ndarray:
    return height * np.exp(-(((TIME - at) / 4.0) ** 2))


def test_a_path_that_can_be_flown_passes(tmp_path: Path) -> None:
    dut = on_path(tmp_path, bump(4.0), -3.0, bump(-1.0), overrides=("mission.start=[0, 0, -300]", "mission.radius=1e4"))
    assert feasible.check(dut) is dut


@pytest.mark.parametrize(
    ("columns", "overrides", "words"),
    [
        ((bump(11.0), 0.0, 0.0), ("mpc.velocity_limit=10",), "mpc.position_upper = [10.0, 10.0, 10.0]: the path runs"),
        ((0.0, bump(-9.0), 0.0), (), "path.csv': reaches 1.93 m/s on an axis at t = 32.83 s; must be at most"),
        ((0.0, 0.0, bump(-2.5)), ("mission.sea_level=-2",), "mission.sea_level = -2.0: must be below -2.5 m, the low"),
        ((0.0, 0.0, bump(-2.5)), LOW, "which comes down to 0.05 m above the sea; must stay ab"),
    ],
    ids=["region", "speed", "in the sea", "antenna in the sea"],
)
def test_a_path_that_cannot_be_flown_is_refused(columns, overrides, words: str, tmp_path: Path) -> None:
    dut = on_path(tmp_path, *columns, overrides=overrides)
    with pytest.raises(ScenarioError) as refused:
        feasible.check(dut)
    assert words in str(refused.value)


def test_a_path_is_looked_at_between_its_samples_and_its_rows(tmp_path: Path) -> None:
    # Between its rows the spline overshoots the region that all of its rows keep.
    points = np.array([[0.0, 0.0, 0.0], [9.9, 0.0, 0.0], [9.9, 0.0, 0.0], [0.0, 0.0, 0.0]])
    file = write_track(tmp_path / "path.csv", np.array([0.0, 13.0, 27.0, 40.0]), points)
    overrides = [f"mission.path_file={file}", "mpc.velocity_limit=5", "mpc.period=10", "attitude_law.name=level"]
    with pytest.raises(ScenarioError, match=r"^mpc\.position_upper"):
        feasible.check(Scenario().with_overrides(overrides))


def test_a_longer_flight_sees_more_of_the_path(tmp_path: Path) -> None:
    time = np.linspace(0.0, 60.0, 121)
    x = np.where(time < 45.0, 0.0, time - 45.0)
    file = write_track(tmp_path / "path.csv", time, np.stack([x, 0.0 * x, 0.0 * x], axis=-1))
    dut = Scenario().with_overrides([f"mission.path_file={file}", "mpc.velocity_limit=2", "attitude_law.name=level"])
    feasible.check(dut)
    feasible.check(dut.with_value("simulation.duration", 50.0))
    with pytest.raises(ScenarioError, match=r"^mpc\.position_upper"):
        feasible.check(dut.with_value("simulation.duration", 60.0))


@pytest.mark.parametrize("height", [10.0, 9.9])
def test_a_ship_may_not_sail_its_antenna_into_the_uavs(height: float, tmp_path: Path) -> None:
    # Its antenna is as high as the UAV and passes it between two instants, faster than anybody looks.
    x = np.array([-50_000.0, 60_000.0])
    file = write_track(tmp_path / "ship.csv", np.array([0.0, 1.0]), np.stack([x, 0.0 * x], axis=-1), "time,x,y")
    overrides = [f"mission.ship_track_file={file}", "mission.sea_level=-10", f"link.ship_antenna_height={height}"]
    dut = Scenario().with_overrides([*overrides, "attitude_law.name=level"])
    with pytest.raises(ScenarioError, match=r"mission.ship_track_file = .*ship.csv': the UAV comes as close as"):
        feasible.check(dut)
    lower = feasible.check(dut.with_value("link.ship_antenna_height", 9.0))
    with pytest.raises(ScenarioError, match=r"the UAV comes as close as 0\.2 m to the ship's antenna"):
        feasible.check(lower.with_value("knowledge.ship_antenna_height_error", 0.8))  # where the antenna truly is


def test_on_the_circle_too_the_antennas_may_not_meet() -> None:
    dut = Scenario().with_overrides(["mission.ship_start=[0.1, 0]", "mission.sea_level=-10"])
    with pytest.raises(ScenarioError, match=r"mission.ship_start = \[0.1, 0.0\]: .*link.antenna_offset, 0.585 m"):
        feasible.check(dut)


@pytest.mark.parametrize("field", ["path_file", "ship_track_file"])
def test_a_missing_file_is_refused_by_name(field: str, tmp_path: Path) -> None:
    file = tmp_path / "missing.csv"
    with pytest.raises(ScenarioError, match=rf"^mission.{field} = '.*missing.csv': No such file or directory$"):
        feasible.check(Scenario().with_value(f"mission.{field}", str(file)))
