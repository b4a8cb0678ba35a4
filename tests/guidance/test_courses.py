"""The path and the track of a scenario, read by everything that reads the circle and the line."""

from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Scenario, ScenarioError, ShipTrajectory, UavPath, run_flight
from a2s_drake.flight import feasible
from a2s_drake.flight.metrics import throughput
from a2s_drake.guidance.courses import Courses
from a2s_drake.guidance.path import uav_path
from a2s_drake.guidance.plan.cache import kept_plan
from a2s_drake.guidance.plan.plan import plan_attitude
from a2s_drake.study.ideal_tracking import measure_ideal_tracking
from a2s_drake.world.ship import ship_track
from diagrams import build_link_only
from tests.support.tracks import circle, write_track

FINE = np.linspace(0.0, 40.0, 40_001)


@pytest.fixture(scope="module")
def from_files(tmp_path_factory) -> Scenario:
    """Table I, its circle and its line read from files of 1 ms steps; without them it would fly something else."""
    folder = tmp_path_factory.mktemp("tracks")
    track = np.column_stack([90.0 + FINE / 4.0, np.zeros(FINE.size)])
    path = write_track(folder / "path.csv", FINE, circle(FINE))
    ship = write_track(folder / "ship.csv", FINE, track, "time,x,y")
    elsewhere = ["mission.radius=1", "mission.ship_start=[50, 50]", "mission.ship_end=[50, 50]"]
    return Scenario().with_overrides([f"mission.path_file={path}", f"mission.ship_track_file={ship}", *elsewhere])


def test_the_circle_in_a_file_is_the_circle(from_files: Scenario) -> None:
    time = np.linspace(-1.0, 41.0, 1234)
    dut, formula = Courses.of(from_files), Courses.of(Scenario())
    assert dut.end == pytest.approx(formula.end)
    for mine, papers in ((dut.uav, formula.uav), (dut.ship, formula.ship)):
        np.testing.assert_allclose(mine.position(time), papers.position(time), atol=1e-9)
        np.testing.assert_allclose(mine.velocity(time), papers.velocity(time), atol=1e-8)
        # A spline through positions knows the acceleration at its ends only to its step.
        np.testing.assert_allclose(mine.acceleration(time), papers.acceleration(time), atol=2e-5)


def test_laws_and_ceilings_win_the_same_on_the_circle_in_a_file(from_files: Scenario) -> None:
    coarse = ["mpc.period=0.4", "mpc.horizon=2"]  # a twentieth of the samples, for the ceilings' sake
    dut, papers = (measure_ideal_tracking(scenario.with_overrides(coarse)) for scenario in (from_files, Scenario()))
    assert dut.level_throughput_bit_per_hz == pytest.approx(papers.level_throughput_bit_per_hz, rel=1e-6)
    for name in ("three_axis", "pitch_only"):
        assert dut.gain_percent[name] == pytest.approx(papers.gain_percent[name], abs=1e-4)
    for mine, theirs in zip(astuple(dut.ceiling_percent), astuple(papers.ceiling_percent), strict=True):
        assert mine == pytest.approx(theirs, abs=1e-4)


@pytest.mark.parametrize("law", ["three_axis", "level"])
def test_a_diagram_flies_the_circle_in_a_file_alike(law: str, from_files: Scenario) -> None:
    flights = []
    for scenario in (from_files, Scenario()):
        flown = feasible.check(scenario.with_overrides([f"attitude_law.name={law}", "simulation.duration=10"]))
        flights.append(run_flight(build_link_only(flown), flown))
    dut, papers = flights
    np.testing.assert_allclose(dut.position, papers.position, atol=1e-9)
    np.testing.assert_allclose(dut.ship_position, papers.ship_position, atol=1e-9)
    assert throughput(dut) == pytest.approx(throughput(papers), rel=1e-6)


def test_a_block_reads_its_file_once_when_it_is_made(tmp_path: Path, scenario: Scenario) -> None:
    file = tmp_path / "moving.csv"
    for block, field, port in (
        (lambda named: UavPath(named.mission, named.mpc), "path_file", "position_reference"),
        (lambda named: ShipTrajectory(named.mission), "ship_track_file", "ship_position"),
    ):
        z = -20.0 if field == "ship_track_file" else 1.0
        write_track(file, np.array([0.0, 10.0]), np.array([[0.0, 0.0, z], [10.0, 5.0, z]]))
        dut = block(scenario.with_value(f"mission.{field}", str(file)))
        write_track(file, np.array([0.0, 10.0]), np.array([[7.0, 7.0, z], [7.0, 7.0, z]]))
        context = dut.CreateDefaultContext()
        context.SetTime(2.0)
        np.testing.assert_allclose(dut.GetOutputPort(port).Eval(context), [2.0, 1.0, z], atol=1e-12)


def test_the_ship_stays_at_sea_level(tmp_path: Path, scenario: Scenario) -> None:
    time, file = np.array([0.0, 1.0, 2.0]), tmp_path / "ship.csv"
    mission = replace(scenario.mission, ship_track_file=str(file), sea_level=-12.0)
    points = np.array([[90.0, 1.0], [91.0, 2.0], [92.0, 1.0]])
    write_track(file, time, points, "time,x,y")
    np.testing.assert_allclose(ship_track(mission).position(time), np.column_stack([points, [-12.0] * 3]))
    write_track(file, time, np.column_stack([points, [-12.0] * 3]))
    np.testing.assert_allclose(ship_track(mission).position(time), np.column_stack([points, [-12.0] * 3]))
    write_track(file, time, np.column_stack([points, [-12.0, -11.5, -12.0]]))
    with pytest.raises(ScenarioError, match=r"z = -11.5 at t = 1.0 s: .* stays at mission.sea_level = -12.0"):
        ship_track(mission)


def test_courses_end_where_nothing_moves_or_nobody_looks(tmp_path: Path, scenario: Scenario) -> None:
    def end(time: float, **changed: float) -> float:
        file = write_track(tmp_path / "path.csv", np.array([0.0, time]), np.zeros((2, 3)))
        seen = scenario.with_value("mission.path_file", file)
        for name, value in changed.items():
            seen = seen.with_value(name.replace("__", "."), value)
        return Courses.of(seen).end

    assert end(30.0) == 40.0  # the ship's, which sails on
    assert end(40.5) == 40.5
    assert end(50.0) == pytest.approx(40.0 + 30 * 0.02)  # what the last preview sees
    assert end(500.0, simulation__duration=60.0) == pytest.approx(60.6)
    assert end(500.0, simulation__duration=1.0) == pytest.approx(40.6)


def test_the_window_of_fringes_must_hold_those_of_the_file(tmp_path: Path, scenario: Scenario) -> None:
    near = scenario.with_overrides(["attitude_law.index_min=-50", "attitude_law.index_max=45"])
    feasible.check(near)
    # The ship comes close only after the mission's end, which a longer flight sees.
    time, x = np.array([0.0, 40.0, 50.0]), np.array([90.0, 90.0, 30.0])
    file = write_track(tmp_path / "ship.csv", time, np.column_stack([x, 0.0 * x]), "time,x,y")
    dut = near.with_value("mission.ship_track_file", file)
    longer = dut.with_value("simulation.duration", 50.0)
    with pytest.raises(ScenarioError, match=r"attitude_law.index_max = 45: the nearest fringe has index"):
        feasible.check(longer)
    feasible.check(longer.with_value("attitude_law.index_max", 1000))


@pytest.mark.parametrize("field", ["path_file", "ship_track_file"])
def test_the_planner_refuses_a_file_by_name(field: str, tmp_path: Path, scenario: Scenario) -> None:
    points = np.array([[90.0, 0.0, -20.0]] * 2) if field == "ship_track_file" else np.zeros((2, 3))
    file = write_track(tmp_path / "track.csv", np.array([0.0, 40.0]), points)
    dut = scenario.with_overrides([f"mission.{field}={file}", "attitude_law.name=planned"])
    words = rf"^mission.{field} = '.*track.csv': the planner knows .* must be null"
    for refuse in (feasible.check, plan_attitude, lambda some: kept_plan(some, folder=tmp_path)):
        with pytest.raises(ScenarioError, match=words):
            refuse(dut)
    feasible.check(dut.with_value("attitude_law.name", "level"))


def test_a_path_may_begin_and_end_at_speed(tmp_path: Path, scenario: Scenario) -> None:
    points = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]])
    mission = replace(scenario.mission, path_file=write_track(tmp_path / "path.csv", np.array([0.0, 8.0]), points))
    velocity = uav_path(mission).velocity(np.array([-0.1, 0.0, 8.0, 8.1]))
    np.testing.assert_allclose(velocity[:, 0], [0.0, 0.5, 0.5, 0.0])
    feasible.check(replace(scenario, mission=mission))
