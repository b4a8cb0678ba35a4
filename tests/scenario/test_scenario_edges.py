"""Where a scenario that can be flown ends: just within passes, just beyond is refused."""

import math

import pytest

from a2s_drake import Airframe, Scenario, ScenarioError
from a2s_drake.flight.feasible import check
from a2s_drake.guidance.plan.limits import Limits
from a2s_drake.vehicle.flatness import FlatMap
from tests.support.geometry import resting_input

# The circle of Table I is flown fastest half-way round, along -y: pi^2 R/T.
FASTEST = math.pi**2 * 2.65 / 40.0
HOVER = math.sqrt(resting_input(Airframe(), 0.0, 0.0)[0])


@pytest.mark.parametrize(
    ("field", "within", "outside"),
    [
        ("mpc.velocity_limit", 1.0001 * FASTEST, 0.9999 * FASTEST),
        # The path spans -5.3..0 m in x, -2.65..2.65 m in y, and stays at 0 in z.
        ("mpc.position_upper", [0.001, 2.651, 0.001], [0.001, 2.649, 0.001]),
        ("mpc.position_upper", [0.001, 2.651, 0.001], [-0.001, 2.651, 0.001]),
        ("mpc.position_lower", [-5.301, -2.651, -0.001], [-5.299, -2.651, -0.001]),
        ("mpc.position_lower", [-5.301, -2.651, -0.001], [-5.301, -2.649, -0.001]),
        ("airframe.rotor_speed_min", HOVER - 0.01, HOVER + 0.01),
        ("airframe.rotor_speed_max", HOVER + 0.01, HOVER - 0.01),
        ("attitude_law.index_min", 39, 40),
        ("attitude_law.index_max", 43, 42),
    ],
)
def test_a_limit_is_drawn_where_it_is(field: str, within: object, outside: object) -> None:
    check(Scenario().with_value(field, within))
    with pytest.raises(ScenarioError):
        check(Scenario().with_value(field, outside))


@pytest.mark.parametrize("law", ["three_axis", "pitch_only"])
def test_the_window_must_hold_the_fringe_at_the_very_end(law: str) -> None:
    # The ship makes for 150 m, and there is no sample in the last 9.9 s.
    fast = ["mission.ship_end=[150, 0]", "mpc.period=10", "mission.duration=39.9", f"attitude_law.name={law}"]
    across, above, below = math.hypot(150.0 - 0.39, 0.39), 10.0 - 20.195, 10.0 + 20.195
    phase = 2.0 * math.pi * 3e9 / 299792458.0 * (math.hypot(across, below) - math.hypot(across, above))
    last = round((phase / math.pi - 1.0) / 2.0)
    check(Scenario().with_overrides([*fast, f"attitude_law.index_min={last}"]))
    with pytest.raises(ScenarioError, match=rf"the nearest fringe has index {last}\.\.43 on this mission"):
        check(Scenario().with_overrides([*fast, f"attitude_law.index_min={last + 1}"]))


@pytest.mark.parametrize("margin", ["rotor_speed_min_margin", "rotor_speed_max_margin"])
def test_a_margin_must_leave_the_hover_speed(margin: str) -> None:
    room = HOVER - 16.0 if margin == "rotor_speed_min_margin" else 100.0 - HOVER
    Limits.of(Scenario().with_value(f"planning.{margin}", room - 0.01))
    with pytest.raises(ScenarioError, match=r"must hold the hover speed of 61\.69 Hz"):
        Limits.of(Scenario().with_value(f"planning.{margin}", room + 0.01))


def test_tightened_limits_are_drawn_in_on_all_sides() -> None:
    dut = Limits(angle=0.2, rate=1.0, input_low=100.0, input_high=1100.0).tightened(0.1)
    assert (dut.angle, dut.rate) == pytest.approx((0.18, 0.9))
    assert (dut.input_low, dut.input_high) == pytest.approx((200.0, 1000.0))


@pytest.mark.parametrize(("tilt_deg", "flat"), [(0.01, True), (1e-6, False), (0.0, False)])
def test_rotors_that_hardly_tilt_cannot_make_every_wrench(tilt_deg: float, flat: bool) -> None:
    if flat:
        FlatMap.of(Airframe(tilt_deg=tilt_deg))
        return
    with pytest.raises(ScenarioError, match="these rotors cannot make every wrench"):
        FlatMap.of(Airframe(tilt_deg=tilt_deg))
