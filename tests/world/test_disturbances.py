import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from a2s_drake import Disturbance, Scenario, run_flight
from a2s_drake.navigation.sensors import NavigationSensor
from a2s_drake.scenario.parts import GRAVITY
from a2s_drake.vehicle.actuators import InputDelay
from a2s_drake.vehicle.airframe import hover_input, wrench_map
from a2s_drake.world.wind import gust_force
from diagrams import build_airframe_only, build_closed_loop

PERIOD = 0.02


def test_gusts_swell_and_die_once_an_interval() -> None:
    dut = Disturbance(gust_force=[1.0, -2.0, 4.0], gust_duration=2.0, gust_interval=5.0)
    for quiet in (0.0, 1.0, 4.99, 5.0, 7.0, 9.9, 12.0):
        np.testing.assert_allclose(gust_force(quiet, dut), 0.0, atol=1e-12)
    for peak in (6.0, 11.0, 36.0):
        np.testing.assert_allclose(gust_force(peak, dut), [1.0, -2.0, 4.0])
    np.testing.assert_allclose(gust_force(5.5, dut), [0.5, -1.0, 2.0])


def acceleration(scenario: Scenario, u: np.ndarray, time: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Angular and linear acceleration, W, of the level vehicle at rest, by Drake's plant."""
    dut = build_airframe_only(scenario)
    context = dut.CreateDefaultContext()
    context.SetTime(time)
    dut.GetInputPort("rotor_speed_squared").FixValue(context, u)
    slope = dut.EvalTimeDerivatives(context).CopyToVector()
    return slope[7:10], slope[10:13]


def test_wind_pushes_the_centre_of_mass(scenario: Scenario) -> None:
    scenario.disturbance = Disturbance(gust_force=[0.0, 3.0, 0.0], gust_duration=1.0, gust_interval=2.0)
    turning, pushed = acceleration(scenario, hover_input(scenario.airframe), time=2.5)
    np.testing.assert_allclose(pushed, [0.0, 3.0 / 2.57, 0.0], atol=1e-9)
    np.testing.assert_allclose(turning, 0.0, atol=1e-9)


def test_true_mass_and_inertia_differ_from_those_known(scenario: Scenario) -> None:
    scenario.disturbance = Disturbance(mass_factor=1.1, inertia_factor=0.5)
    u = hover_input(scenario.airframe) + 100.0 * np.eye(6)[0]
    turning, falling = acceleration(scenario, u)
    wrench = wrench_map(scenario.airframe) @ u
    np.testing.assert_allclose(falling, wrench[:3] / (1.1 * 2.57) - [0.0, 0.0, GRAVITY], atol=1e-9)
    np.testing.assert_allclose(turning, wrench[3:] / (0.5 * np.array([0.11, 0.11, 0.19])), atol=1e-9)


def test_a_weak_rotor_gives_its_share(scenario: Scenario) -> None:
    u = np.array([4e3, 3e3, 5e3, 4e3, 3e3, 5e3])
    weaker = u * [1.0, 1.0, 0.9, 1.0, 1.0, 1.0]
    expected = acceleration(scenario, weaker)
    scenario.disturbance = Disturbance(rotor_efficiency=[1.0, 1.0, 0.9, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(acceleration(scenario, u), expected, atol=1e-9)


def measured(dut: NavigationSensor, times: np.ndarray) -> np.ndarray:
    context = dut.CreateDefaultContext()
    dut.GetInputPort("vehicle_state").FixValue(context, np.arange(12.0))
    rows = []
    for time in times:
        context.SetTime(time)
        rows.append(dut.GetOutputPort("measured_state").Eval(context) - np.arange(12.0))
    return np.array(rows)


def test_noise_has_the_deviations_asked_for() -> None:
    noise = Disturbance(position_noise=0.01, attitude_noise_deg=0.5, velocity_noise=0.05, angular_velocity_noise=0.2)
    drawn = measured(NavigationSensor(PERIOD, noise), PERIOD * np.arange(4000))
    expected = np.repeat([0.01, np.deg2rad(0.5), 0.05, 0.2], 3)
    np.testing.assert_allclose(drawn.std(axis=0), expected, rtol=0.05)
    np.testing.assert_allclose(drawn.mean(axis=0) / expected, 0.0, atol=0.06)
    correlation = np.corrcoef(np.hstack([drawn[1:], drawn[:-1]]).T) - np.eye(24)
    assert np.abs(correlation).max() < 0.08  # white in time, and over the axes


def test_noise_is_held_for_a_period_and_goes_by_its_seed() -> None:
    times = np.array([0.02, 0.0399, 0.04, 0.06])
    first, again, other = (
        measured(NavigationSensor(PERIOD, Disturbance(position_noise=1.0, noise_seed=seed)), times)
        for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(first[0], first[1])
    assert np.abs(first[1] - first[2]).max() > 0.1
    assert np.abs(first - other).max() > 0.1


@pytest.mark.parametrize("periods", [1, 3])
def test_commands_arrive_late(periods: int) -> None:
    dut = InputDelay(periods, PERIOD, np.full(6, 7.0))
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    command = dut.GetInputPort("rotor_speed_command")
    command.FixValue(context, np.zeros(6))
    seen = []
    for k in range(8):
        simulator.AdvanceTo(k * PERIOD)
        simulator.AdvancePendingEvents()
        seen.append(dut.GetOutputPort("rotor_speed_squared").Eval(context)[0])
        command.FixValue(context, np.full(6, k + 1.0))  # decided at t_k, in place of what came before
    # What was decided at t_k - d is in force from t_k on: decision k is the value k + 1.
    assert seen == [7.0] * periods + [float(k + 1) for k in range(8 - periods)]
    simulator.Initialize()
    assert dut.GetOutputPort("rotor_speed_squared").Eval(context)[0] == 7.0  # from rest again


def test_a_late_command_is_the_one_of_the_period_before(scenario: Scenario) -> None:
    scenario = scenario.with_overrides(["simulation.duration=0.4", "disturbance.input_delay_periods=1"])
    diagram = build_closed_loop(scenario)
    flight = run_flight(diagram, scenario)
    np.testing.assert_allclose(flight.rotor_speed[0] ** 2, hover_input(scenario.airframe))
    prompt = run_flight(build_closed_loop(scenario.with_value("disturbance.input_delay_periods", 0)), scenario)
    np.testing.assert_allclose(flight.rotor_speed[1], prompt.rotor_speed[0])


def test_without_disturbances_no_block_stands_in_the_loop(scenario: Scenario) -> None:
    def names(s: Scenario) -> set[str]:
        world = build_closed_loop(s).GetSubsystemByName("world")
        parts = (world, world.GetSubsystemByName("airframe"))
        return {system.get_name() for part in parts for system in part.GetSystems()}

    added = {"wind", "spatial_forces", "rotor_efficiency", "input_delay"}
    assert not added & names(scenario)
    everything = scenario.with_overrides(
        [
            *("disturbance.gust_force=[0,1,0]", "disturbance.rotor_efficiency=[1,1,1,1,1,0.9]"),
            "disturbance.input_delay_periods=2",
        ]
    )
    assert added <= names(everything)


def test_a_gust_longer_than_its_interval_is_refused(scenario: Scenario) -> None:
    with pytest.raises(ValueError, match=r"disturbance.gust_duration = 9.0: must be at most disturbance.gust_interval"):
        scenario.with_overrides(["disturbance.gust_duration=9"]).validate()
