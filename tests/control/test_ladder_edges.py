"""Where the planner draws its lines: what it believes, what it gives to a solver, and what it predicts from."""

import numpy as np
import pytest
from pydrake.math import RollPitchYaw

from a2s_drake import Scenario
from a2s_drake.common.signals import Fallback
from a2s_drake.control.horizon import Plan, Reference
from a2s_drake.control.ladder import Planner
from a2s_drake.control.solve import Solution
from a2s_drake.vehicle.airframe import hover_input

AT_REST = Reference.of_pose(np.zeros((31, 3)), np.zeros((31, 3)))


class Obliging:
    """Answers every call with the guess it was given."""

    def __init__(self) -> None:
        self.asked: list[tuple[np.ndarray, Plan]] = []

    def solve(self, x0: np.ndarray, _reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:
        assert not soft
        self.asked.append((x0.copy(), guess))
        return Solution(guess, 1)


@pytest.fixture
def obliging() -> Obliging:
    return Obliging()


@pytest.fixture
def dut(scenario: Scenario, obliging: Obliging) -> Planner:
    return Planner(scenario.airframe, scenario.mpc, obliging)


def still_plan(scenario: Scenario) -> Plan:
    """A plan that foresees the origin at rest, whatever its inputs would do."""
    return Plan(np.zeros((31, 12)), np.tile(hover_input(scenario.airframe), (30, 1)))


SURPRISES = [(0, 1.0), (4, 0.5), (7, 5.0), (11, 10.0)]  # entry of the state; m, rad, m/s, rad/s


@pytest.mark.parametrize(("entry", "limit"), SURPRISES)
def test_a_surprise_begins_at_its_limit(entry: int, limit: float, dut: Planner, scenario: Scenario) -> None:
    for size, believed in ((0.999 * limit, True), (1.001 * limit, False), (-1.001 * limit, False)):
        decision = dut.decide(size * np.eye(12)[entry], AT_REST, still_plan(scenario))
        assert (decision.fallback is Fallback.NONE) == believed


@pytest.mark.parametrize(("entry", "tolerance"), [(0, 0.1), (4, 0.1), (7, 0.1), (11, 0.5)])
def test_a_surprise_must_follow_from_the_measurement_before(
    entry: int, tolerance: float, dut: Planner, scenario: Scenario
) -> None:
    before = np.zeros(12)
    before[0] = 3.0  # two metres beyond belief, if it stood alone
    leads_to = dut.model.step(before, hover_input(scenario.airframe), scenario.mpc.period)
    for size, believed in ((0.99 * tolerance, True), (1.01 * tolerance, False)):
        x0 = leads_to + size * np.eye(12)[entry]
        decision = dut.decide(x0, AT_REST, still_plan(scenario), before)
        assert (decision.fallback is Fallback.NONE) == believed


def test_what_leads_on_is_the_input_that_was_applied(dut: Planner, scenario: Scenario) -> None:
    # The plan's first input is the one in force since the measurement before; the second has yet to come.
    before, plan = 3.0 * np.eye(12)[0], still_plan(scenario)
    plan.input[0], plan.input[1:] = 1e4 * np.array([1.0, 1.0, 1.0, 0.0256, 0.0256, 0.0256]), 256.0
    x0 = dut.model.step(before, plan.input[0], scenario.mpc.period)
    assert np.abs(x0[9:]).max() > 0.5
    assert dut.decide(x0, AT_REST, plan, before).fallback is Fallback.NONE


def test_rotations_add_up_over_the_axes(dut: Planner, scenario: Scenario) -> None:
    # No Euler angle is off by half a radian, but the attitude is.
    x0 = np.zeros(12)
    x0[3:6] = 0.4
    turned = RollPitchYaw(x0[3:6]).ToRotationMatrix().ToAngleAxis().angle()
    assert turned > 0.55
    assert dut.decide(x0, AT_REST, still_plan(scenario)).fallback is Fallback.SHIFTED_PLAN


def test_euler_angles_that_differ_by_much_may_tell_of_nearly_the_same_attitude(dut, scenario: Scenario) -> None:
    plan, x0 = still_plan(scenario), np.zeros(12)
    plan.state[:, 3:6], x0[3:6] = [0.0, 1.5, 0.0], [0.9, 1.5, 0.9]
    seen, foreseen = (RollPitchYaw(eta).ToRotationMatrix() for eta in (x0[3:6], plan.state[1, 3:6]))
    assert abs((seen.inverse() @ foreseen).ToAngleAxis().angle()) < 0.1
    assert dut.decide(x0, AT_REST, plan).fallback is Fallback.NONE


@pytest.mark.parametrize(("difference", "kept"), [(0.95, True), (1.05, False)])
def test_a_guess_in_other_euler_angles_is_dropped(difference: float, kept: bool, dut, obliging, scenario) -> None:
    plan, x0 = still_plan(scenario), np.zeros(12)
    plan.state[:, 3:6], x0[3:6] = [0.0, 1.51, 0.0], [difference, 1.51, difference]
    assert dut.decide(x0, AT_REST, plan).fallback is Fallback.NONE
    guess = obliging.asked[0][1]
    np.testing.assert_array_equal(guess.state, (plan.shifted() if kept else dut.hover_plan(x0)).state)


BOUNDS = [(1, 10.0), (3, np.deg2rad(15.0)), (8, 1.0), (10, 1.0)]


@pytest.mark.parametrize(("entry", "bound"), BOUNDS)
def test_no_solver_sees_a_state_beyond_a_hundred_times_its_bound(entry: int, bound: float, dut, obliging) -> None:
    dut.decide(99.0 * bound * np.eye(12)[entry], AT_REST, None)
    assert obliging.asked
    obliging.asked.clear()
    for size in (101.0, -101.0):
        assert dut.decide(size * bound * np.eye(12)[entry], AT_REST, None).fallback is Fallback.HOVER
    assert not obliging.asked


def test_a_state_that_cannot_be_used_is_hovered_from_as_far_as_it_is_known(dut: Planner) -> None:
    known = np.array([1.0, 2.0, 3.0, 0.1, -0.2, 0.3, 0.5, 0.5, 0.5, 0.5, 0.5, np.nan])
    plan = dut.decide(known, AT_REST, None).plan
    np.testing.assert_array_equal(plan.state[0], [1.0, 2.0, 3.0, 0.1, -0.2, 0.3, *np.zeros(6)])
    for lost, kept in ((slice(0, 3), slice(3, 6)), (slice(3, 6), slice(0, 3))):
        x0 = known.copy()
        x0[lost] = [0.0, np.inf, 0.0]
        start = dut.decide(x0, AT_REST, None).plan.state[0]
        np.testing.assert_array_equal(start[kept], known[kept])
        np.testing.assert_array_equal(np.delete(start, kept), 0.0)


@pytest.mark.parametrize("broken", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("part", ["state", "input"])
def test_a_reference_that_is_not_finite_costs_nothing_and_asks_nothing(part: str, broken: float, dut, obliging) -> None:
    reference = Reference(np.zeros((31, 12)), np.zeros((30, 6)))
    getattr(reference, part)[7, 2] = broken
    decision = dut.decide(np.zeros(12), reference, None)
    assert decision.objective == 0.0
    assert decision.fallback is Fallback.HOVER
    assert not obliging.asked


def test_a_measured_state_is_left_as_it_was(dut: Planner) -> None:
    x0 = np.array([0.0, 0.0, 0.0, 4.0, 2.0, -4.0, *np.zeros(6)])
    before = x0.copy()
    dut.decide(x0, AT_REST, None)
    np.testing.assert_array_equal(x0, before)


def test_a_shifted_plan_ends_where_it_ended() -> None:
    plan = Plan(np.arange(372.0).reshape(31, 12), np.arange(180.0).reshape(30, 6))
    np.testing.assert_array_equal(plan.shifted().state, [*plan.state[1:], plan.state[-1]])
    np.testing.assert_array_equal(plan.shifted().input, [*plan.input[1:], plan.input[-1]])
