import numpy as np
import pytest

from a2s_drake import Scenario, UavPath
from a2s_drake.guidance.path import uav_path
from a2s_drake.world.ship import ship_track


def test_circle_begins_and_ends_at_its_start_and_turns_at_half_time(scenario: Scenario) -> None:
    mission = scenario.mission
    mission.start = [1.0, 2.0, 3.0]
    path = uav_path(mission).position(np.array([0.0, 20.0, 40.0]))
    np.testing.assert_allclose(path, [[1.0, 2.0, 3.0], [1.0 - 5.3, 2.0, 3.0], [1.0, 2.0, 3.0]], atol=1e-12)


def test_circle_keeps_its_radius_and_height(scenario: Scenario) -> None:
    path = uav_path(scenario.mission).position(np.linspace(0.0, 40.0, 401))
    np.testing.assert_allclose(np.hypot(path[:, 0] + 2.65, path[:, 1]), 2.65, rtol=1e-14)
    np.testing.assert_array_equal(path[:, 2], 0.0)


def test_velocity_is_the_derivative_of_position(scenario: Scenario) -> None:
    times, step = np.linspace(0.5, 39.5, 79), 1e-5
    ahead, behind = (uav_path(scenario.mission).position(times + sign * step) for sign in (1.0, -1.0))
    expected = (ahead - behind) / (2.0 * step)
    np.testing.assert_allclose(uav_path(scenario.mission).velocity(times), expected, atol=1e-8)


def test_uav_starts_and_stops_at_rest(scenario: Scenario) -> None:
    np.testing.assert_allclose(uav_path(scenario.mission).velocity(np.array([0.0, 40.0, 50.0])), 0.0, atol=1e-15)


def test_acceleration_is_the_slope_of_velocity(scenario: Scenario) -> None:
    times, step = np.linspace(0.5, 39.5, 79), 1e-5
    before, after = (uav_path(scenario.mission).velocity(times + shift) for shift in (-step, step))
    slope = (after - before) / (2.0 * step)
    np.testing.assert_allclose(uav_path(scenario.mission).acceleration(times), slope, atol=1e-9)


def test_acceleration_jumps_where_the_uav_starts_and_stops(scenario: Scenario) -> None:
    jump = 2.65 * np.pi**3 / 40.0**2
    acceleration = uav_path(scenario.mission).acceleration(np.array([-1.0, 0.0, 40.0, 41.0]))
    expected = np.array([[0.0, 0.0, 0.0], [0.0, jump, 0.0], [0.0, -jump, 0.0], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(acceleration, expected, atol=1e-15)


def test_ship_sails_at_constant_speed_at_sea_level(scenario: Scenario) -> None:
    track = ship_track(scenario.mission).position(np.array([0.0, 10.0, 40.0]))
    np.testing.assert_allclose(track, [[90.0, 0.0, -20.0], [92.5, 0.0, -20.0], [100.0, 0.0, -20.0]])


@pytest.mark.parametrize("time", [0.0, 12.34, 39.9, 41.0])
def test_preview_looks_ahead_and_holds_the_last_value(time: float, scenario: Scenario) -> None:
    dut = UavPath(scenario.mission, scenario.mpc)
    context = dut.CreateDefaultContext()
    context.SetTime(time)
    rows = dut.GetOutputPort("position_preview").Eval(context).reshape(31, 3)
    np.testing.assert_array_equal(dut.GetOutputPort("position_reference").Eval(context), rows[0])
    expected = [uav_path(scenario.mission).position(np.array(min(time + 0.02 * i, 40.0))) for i in range(31)]
    np.testing.assert_allclose(rows, expected, atol=1e-12)
