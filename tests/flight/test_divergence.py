"""Bodies that turn faster than the integration can follow: how their flights end, and that no other flight does."""

import numpy as np
import pytest
from pydrake.systems.framework import EventStatus

from a2s_drake import Flight, FlightEnded, Scenario, run_flight
from a2s_drake.flight.log import array_names, optional_names
from a2s_drake.flight.metrics import compute_metrics
from diagrams import build_closed_loop

# The body is so much lighter to turn than the controller believes that it is spun up.
SPUN_UP = ["disturbance.inertia_factor=0.0866", "mpc.horizon=10"]


def ended(scenario: Scenario, *overrides: str) -> tuple[str, Flight]:
    """How the flight of a scenario ends, and what is left of it."""
    scenario = scenario.with_overrides(overrides).validate()
    with pytest.raises(FlightEnded) as caught:
        run_flight(build_closed_loop(scenario), scenario)
    return str(caught.value), caught.value.flight


def test_a_body_that_turns_too_fast_for_a_step_ends_the_flight_by_name(scenario: Scenario) -> None:
    message, flight = ended(scenario, *SPUN_UP)
    what, remedy = message.split("; ")
    assert what.endswith(" rad/s, more than half a turn in an integration step of 0.01 s")
    assert remedy.startswith("lower simulation.max_step_size = 0.01, or slow the body down by airframe.inertia, ")
    time, speed = float(message.split()[6]), float(message.split(" turns at ")[1].split()[0])
    assert 314.0 < speed < 1000.0
    assert flight.time[-1] <= time <= flight.time[-1] + 0.021


def test_what_is_left_of_such_a_flight_is_finite_and_was_followed(scenario: Scenario) -> None:
    _, flight = ended(scenario, *SPUN_UP)
    assert all(np.isfinite(getattr(flight, name)).all() for name in {*array_names()} - optional_names())
    assert np.linalg.norm(flight.angular_velocity, axis=1).max() <= np.pi / 0.01


def test_metrics_say_that_a_flight_did_not_reach_its_end(scenario: Scenario) -> None:
    _, flight = ended(scenario, *SPUN_UP)
    assert not compute_metrics(flight)["complete"]


def test_a_smaller_step_follows_the_same_body(scenario: Scenario) -> None:
    scenario = scenario.with_overrides([*SPUN_UP, "simulation.max_step_size=0.001", "simulation.duration=2"])
    flight = run_flight(build_closed_loop(scenario), scenario)
    assert np.linalg.norm(flight.angular_velocity, axis=1).max() > 100.0
    assert compute_metrics(flight)["complete"]


def test_an_attitude_that_grows_without_limit_ends_the_flight_by_name(scenario: Scenario) -> None:
    # Under Euler's scheme the quaternion of a turning body grows by a share in every step, here until it overflows.
    euler = ["simulation.integrator=explicit_euler", "simulation.max_step_size=0.005"]
    message, flight = ended(scenario, *SPUN_UP, *euler, "mpc.period=0.2", "mpc.horizon=3")
    what, remedy = message.split("; ")
    assert what.endswith(" s: the vehicle's state overflowed in integration steps of 0.005 s")
    assert "simulation.max_step_size = 0.005, take another simulation.integrator than explicit_euler, or" in remedy
    assert all(np.isfinite(getattr(flight, name)).all() for name in {*array_names()} - optional_names())


def test_a_flight_that_ends_well_is_the_same_unwatched(scenario: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = scenario.with_overrides(["simulation.duration=0.3", "mpc.horizon=8"])
    watched = run_flight(build_closed_loop(scenario), scenario)
    monkeypatch.setattr("a2s_drake.flight.divergence.DivergenceMonitor.__call__", lambda *_: EventStatus.DidNothing())
    unwatched = run_flight(build_closed_loop(scenario), scenario)
    for name in array_names():
        np.testing.assert_array_equal(getattr(watched, name), getattr(unwatched, name))


@pytest.mark.parametrize("start", ["[0, 0, 0]", "[9000, 0, 0]"])
def test_a_vehicle_far_from_the_origin_flies(start: str, scenario: Scenario) -> None:
    # Far off, the state is large although nothing turns.
    region = ["mpc.position_lower=[-1e4, -10, -10]", "mpc.position_upper=[1e4, 10, 10]", "mpc.horizon=8"]
    law = ["attitude_law.name=level", f"mission.start={start}", "simulation.duration=0.1"]
    scenario = scenario.with_overrides([*region, *law]).validate()
    assert len(run_flight(build_closed_loop(scenario), scenario).time) == 6
