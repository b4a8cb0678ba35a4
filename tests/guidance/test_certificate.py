"""What a certificate lets pass: everything up to the vehicle's limits, in flight and at rest after it, and no more."""

from dataclasses import replace

import numpy as np
import pytest

from a2s_drake import Scenario
from a2s_drake.guidance.path import uav_path
from a2s_drake.guidance.plan.certificate import Certificate, certify
from a2s_drake.guidance.plan.spline import AttitudeSpline, SplineGrid
from a2s_drake.vehicle.flatness import FlatMap
from tests.support.geometry import resting_input

AT_THE_LIMITS = Certificate(
    samples=1,
    rotor_speed_min=16.0,
    rotor_speed_max=100.0,
    rotor_speed_range=(16.0, 100.0),
    attitude_max_deg=15.0,
    attitude_limit_deg=15.0,
    angular_velocity_max=1.0,
    angular_velocity_limit=1.0,
    rest_error=1e-6,
)


def test_a_plan_at_all_limits_holds() -> None:
    assert AT_THE_LIMITS.holds
    assert set(AT_THE_LIMITS.margins.values()) == {0.0}


@pytest.mark.parametrize(
    ("quantity", "direction"),
    [
        ("rotor_speed_min", -np.inf),
        ("rotor_speed_max", np.inf),
        ("attitude_max_deg", np.inf),
        ("angular_velocity_max", np.inf),
        ("rest_error", np.inf),
    ],
)
def test_each_limit_alone_is_broken_by_the_smallest_excess(quantity: str, direction: float) -> None:
    excess = float(np.nextafter(getattr(AT_THE_LIMITS, quantity), direction))
    assert not replace(AT_THE_LIMITS, **{quantity: excess}).holds
    assert not replace(AT_THE_LIMITS, **{quantity: np.nan}).holds


def test_a_rotor_that_may_stand_still_may_not_turn_backwards() -> None:
    standing = replace(AT_THE_LIMITS, rotor_speed_min=0.0, rotor_speed_range=(0.0, 100.0))
    assert standing.holds
    assert not replace(standing, rotor_speed_min=-1e-3).holds


def scenario(*overrides: str) -> Scenario:
    """Eight seconds of a circle on which the vehicle brakes at 0.2 m/s^2 until its end."""
    return Scenario().with_overrides(["mission.duration=8.0", "mission.radius=0.4", *overrides]).validate()


def leaning(roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> AttitudeSpline:
    """A plan that leans over between 5 s and 7 s, and stays as it is."""
    grid, time = SplineGrid.of(8.0, 0.1), np.linspace(0.0, 8.0, 321)
    share = np.clip((time - 5.0) / 2.0, 0.0, 1.0)
    path = np.outer(share**2 * (3.0 - 2.0 * share), [roll, pitch, yaw])
    control = np.linalg.lstsq(grid.matrix(time).toarray(), path, rcond=None)[0]
    return AttitudeSpline(8.0, grid.rested(np.asarray(control)))


def inputs_in_flight(spline: AttitudeSpline, flown: Scenario) -> np.ndarray:
    time = np.linspace(0.0, 8.0, 1601)
    motion = np.hstack([spline.eta(time), spline.rate(time), spline.acceleration(time)])
    return FlatMap.of(flown.airframe).needs(motion, uav_path(flown.mission).acceleration(time))[1]


def test_a_plan_whose_last_attitude_cannot_be_held_fails() -> None:
    # While the vehicle brakes, it may lean further than at rest.
    flown, spline = scenario(), leaning(pitch=-0.2)
    resting = resting_input(flown.airframe, *spline.eta(np.array(8.0))[:2])
    assert np.sqrt(inputs_in_flight(spline, flown).min()) > 18.0
    assert np.sqrt(resting.min()) < 12.0
    dut = certify(spline, flown, 200.0)
    assert dut.rotor_speed_min == pytest.approx(np.sqrt(resting.min()), rel=1e-4)
    assert [name for name, margin in dut.margins.items() if margin < 0.0] == ["rotor_speed_min"]
    assert not dut.holds
    assert certify(spline, scenario("airframe.rotor_speed_min=11"), 200.0).holds


def test_thrust_downwards_is_a_negative_speed_even_where_a_rotor_may_stand_still() -> None:
    flown, spline = scenario("airframe.rotor_speed_min=0"), leaning(pitch=-0.22)
    lowest = inputs_in_flight(spline, flown).min()
    resting = resting_input(flown.airframe, *spline.eta(np.array(8.0))[:2]).min()
    dut = certify(spline, flown, 200.0)
    assert dut.rotor_speed_min == pytest.approx(-np.sqrt(-min(lowest, resting)), rel=1e-3)
    assert not dut.holds


def test_all_thrusts_downwards_count_as_rotors_that_turn_too_fast() -> None:
    u = resting_input(Scenario().airframe, roll=np.pi, pitch=0.0)
    assert u.max() < 0.0
    upside_down = AttitudeSpline(8.0, np.tile([np.pi, 0.0, 0.0], (83, 1)))
    dut = certify(upside_down, scenario("mission.radius=0"), 20.0)
    assert dut.rotor_speed_max == pytest.approx(np.sqrt(-u.min()), rel=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_sign_of_an_angle_or_a_rate_does_not_matter(sign: float) -> None:
    flown = scenario("mission.radius=0", "mpc.attitude_limit_deg=20")
    dut = certify(leaning(yaw=sign * 0.2), flown, 200.0)
    assert dut.attitude_max_deg == pytest.approx(np.degrees(0.2), rel=1e-3)
    assert dut.attitude_limit_deg == 20.0
    assert dut.angular_velocity_max == pytest.approx(0.2 * 1.5 / 2.0, rel=1e-2)  # of the steepest point


@pytest.mark.parametrize("unrest", ["attitude at the start", "rate at the start", "rate at the end"])
def test_a_plan_must_start_level_and_start_and_end_at_rest(unrest: str) -> None:
    grid, still = SplineGrid.of(8.0, 0.1), np.zeros(83)
    first, last = {
        "attitude at the start": ((6e-5, 6e-5, 6e-5), (0.0, 0.0, 0.0)),
        "rate at the start": ((-6e-6, 0.0, 6e-6), (0.0, 0.0, 0.0)),
        "rate at the end": ((0.0, 0.0, 0.0), (-6e-6, 0.0, 6e-6)),
    }[unrest]
    still[:3], still[-3:] = first, last
    # (a, b, c) make an attitude of (a + 4 b + c)/6 and a rate of (c - a)/2 an interval of 0.1 s.
    expected = {"attitude at the start": 6e-5, "rate at the start": 6e-5, "rate at the end": 6e-5}[unrest]
    dut = certify(AttitudeSpline(8.0, np.outer(still, [0.0, 0.0, 1.0])), scenario("mission.radius=0"), 200.0)
    assert grid.controls == still.size
    assert dut.rest_error == pytest.approx(expected, rel=1e-6)
    assert min(dut.margins.values()) > 0.0
    assert not dut.holds


def test_a_short_excess_between_knots_is_seen() -> None:
    # One control point out of line: the vehicle tilts there for some tenths of a second.
    control = np.zeros((83, 3))
    control[40, 2] = 0.03
    spline, flown = AttitudeSpline(8.0, control), scenario("mission.radius=0")
    time = np.linspace(0.0, 8.0, 80_001)
    dut = certify(spline, flown, 200.0)
    assert dut.samples == 1602  # 1601 in flight and one at rest after it
    assert dut.angular_velocity_max == pytest.approx(np.abs(spline.rate(time)).max(), rel=1e-2)
    assert dut.attitude_max_deg == pytest.approx(np.degrees(np.abs(spline.eta(time)).max()), rel=1e-3)
