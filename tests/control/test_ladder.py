import numpy as np
import pytest
from pydrake.math import RollPitchYaw

from a2s_drake import Scenario
from a2s_drake.common.signals import Fallback
from a2s_drake.control.horizon import Plan, Reference
from a2s_drake.control.ladder import Decision, Planner
from a2s_drake.control.program import input_bounds, state_bounds
from a2s_drake.control.solve import Solution
from a2s_drake.scenario.parts import SOLVERS
from a2s_drake.vehicle.airframe import hover_input

AT_REST = Reference.of_pose(np.zeros((31, 3)), np.zeros((31, 3)))


class FailingSolver:
    """Answers every call with the next entry of a script: a plan, None for "not found", or an exception to raise."""

    def __init__(self, *script: object) -> None:
        self.script = list(script)
        self.calls: list[bool] = []
        self.asked: list[tuple[np.ndarray, Reference, Plan]] = []

    def solve(self, x0: np.ndarray, reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:
        self.calls.append(soft)
        self.asked.append((x0, reference, guess))
        answer = self.script.pop(0)
        if isinstance(answer, BaseException):
            raise answer
        return Solution(answer, 7)


def planner(scenario: Scenario, *script: object) -> tuple[Planner, FailingSolver]:
    solver = FailingSolver(*script)
    return Planner(scenario.airframe, scenario.mpc, solver), solver


def some_plan(level: float = 4000.0) -> Plan:
    return Plan(np.zeros((31, 12)), level + 10.0 * np.arange(180.0).reshape(30, 6))


def assert_can_be_applied(decision: Decision, scenario: Scenario) -> None:
    low, high = input_bounds(scenario.airframe)
    assert decision.plan.is_finite()
    assert decision.plan.input.min() >= low
    assert decision.plan.input.max() <= high
    assert np.isfinite(decision.objective)


def test_solved_problem_is_no_fallback(scenario: Scenario) -> None:
    answer = some_plan()
    dut, solver = planner(scenario, answer)
    decision = dut.decide(np.zeros(12), AT_REST, some_plan())
    assert (decision.fallback, decision.iterations, solver.calls) == (Fallback.NONE, 7, [False])
    np.testing.assert_array_equal(decision.plan.input, answer.input)
    assert decision.objective == pytest.approx(3.2e-8 * (answer.input**2).sum())


def test_first_the_bounds_are_softened(scenario: Scenario) -> None:
    dut, solver = planner(scenario, None, some_plan())
    decision = dut.decide(np.zeros(12), AT_REST, some_plan())
    assert (decision.fallback, decision.iterations, solver.calls) == (Fallback.SOFTENED, 14, [False, True])


def test_then_they_are_softened_around_a_fresh_guess(scenario: Scenario) -> None:
    dut, solver = planner(scenario, None, None, some_plan())
    x0 = np.full(12, 0.01)
    decision = dut.decide(x0, AT_REST, some_plan())
    assert (decision.fallback, solver.calls) == (Fallback.SOFTENED, [False, True, True])
    np.testing.assert_array_equal(solver.asked[1][2].input, some_plan().shifted().input)
    np.testing.assert_array_equal(solver.asked[2][2].state, dut.hover_plan(x0).state)


@pytest.mark.parametrize(
    "failure", [None, RuntimeError("no"), SystemExit("Drake"), Plan(np.full((31, 12), np.nan), np.ones((30, 6)))]
)
@pytest.mark.filterwarnings("ignore:the solver raised")  # see test_solver_errors.py
def test_then_the_previous_plan_is_shifted(failure: object, scenario: Scenario) -> None:
    dut, _ = planner(scenario, failure, failure, failure)
    previous = some_plan()
    decision = dut.decide(np.zeros(12), AT_REST, previous)
    assert decision.fallback is Fallback.SHIFTED_PLAN
    np.testing.assert_array_equal(decision.plan.input[:-1], previous.input[1:])
    np.testing.assert_array_equal(decision.plan.input[-1], previous.input[-1])
    np.testing.assert_array_equal(decision.plan.state[:-1], previous.state[1:])
    np.testing.assert_array_equal(decision.plan.state[-1], dut.model.step(previous.state[-1], previous.input[-1], 0.02))


def test_then_the_vehicle_hovers(scenario: Scenario) -> None:
    dut, _ = planner(scenario, None, None)
    decision = dut.decide(np.zeros(12), AT_REST, None)
    assert decision.fallback is Fallback.HOVER
    np.testing.assert_allclose(decision.plan.input, np.tile(hover_input(scenario.airframe), (30, 1)))


@pytest.mark.parametrize("broken", ["state", "input"])
def test_a_previous_plan_that_is_no_number_is_neither_flown_nor_built_upon(broken: str, scenario: Scenario) -> None:
    previous = some_plan()
    getattr(previous, broken)[2:] = np.nan
    dut, _ = planner(scenario, None, None, None)
    decision = dut.decide(np.zeros(12), AT_REST, previous)
    assert decision.fallback is Fallback.HOVER
    assert_can_be_applied(decision, scenario)
    real = Planner(scenario.airframe, scenario.mpc).decide(np.zeros(12), AT_REST, previous)
    assert real.fallback is Fallback.SOFTENED
    assert_can_be_applied(real, scenario)


FAR = np.repeat(np.eye(4), 3, axis=1) * np.repeat([1.1, 0.55, 5.5, 11.0], 3)  # m, rad, m/s, rad/s, a group at a time


@pytest.mark.parametrize("before", [None, np.full(12, np.nan), np.zeros(12)], ids=["first", "lost", "elsewhere"])
@pytest.mark.parametrize("surprise", FAR)
def test_a_surprise_out_of_nowhere_does_not_sway_the_plan(surprise, before, scenario: Scenario) -> None:
    dut, solver = planner(scenario)
    decision = dut.decide(surprise, AT_REST, some_plan(), before)
    assert solver.calls == []
    assert decision.fallback is Fallback.SHIFTED_PLAN


@pytest.mark.parametrize("surprise", FAR)
def test_a_surprise_that_follows_from_the_measurement_before_is_believed(surprise, scenario: Scenario) -> None:
    dut, solver = planner(scenario, *10 * [some_plan()])
    x0 = dut.model.step(surprise, some_plan().input[0], scenario.mpc.period)
    assert dut.decide(x0, AT_REST, some_plan(), surprise).fallback is Fallback.NONE
    # A cold start: around hover from where the vehicle is, and again around its own answer.
    np.testing.assert_array_equal(solver.asked[0][2].state, dut.hover_plan(x0).state)
    assert len(solver.calls) > 1


@pytest.mark.parametrize("lie", [FAR[1], FAR[2], FAR[3]], ids=["turned", "moving", "turning"])
def test_a_measurement_that_stands_still_against_the_dynamics_is_not_believed(lie, scenario: Scenario) -> None:
    # Turned, it would fall sideways; moving, it would be elsewhere by now; turning, it would be turned.
    dut, solver = planner(scenario)
    hover = dut.hover_plan(np.zeros(12))
    assert dut.decide(lie, AT_REST, hover, lie).fallback is Fallback.SHIFTED_PLAN
    assert solver.calls == []


def test_a_state_near_the_foreseen_one_is_no_surprise(scenario: Scenario) -> None:
    dut, solver = planner(scenario, some_plan())
    decision = dut.decide(0.4 * FAR.sum(axis=0), AT_REST, some_plan())
    assert (decision.fallback, solver.calls) == (Fallback.NONE, [False])


def test_a_jump_of_euler_angles_alone_is_no_surprise_but_no_guess_either(scenario: Scenario) -> None:
    dut, solver = planner(scenario, *10 * [some_plan()])
    plan = some_plan()
    plan.state[:, 3:6] = [0.1, 1.5, 0.2]
    # Pitch beyond 90 deg by the same little that it was short of it: 8 deg of rotation, and angles that jump by pi.
    state = np.zeros(12)
    state[3:6] = [0.1 - np.pi, 1.5, 0.2 + np.pi]
    assert dut.decide(state, AT_REST, plan).fallback is Fallback.NONE
    np.testing.assert_array_equal(solver.asked[0][2].state, dut.hover_plan(solver.asked[0][0]).state)


def test_targets_out_of_reach_are_drawn_nearer(scenario: Scenario) -> None:
    dut, solver = planner(scenario, some_plan())
    reference = Reference.of_pose(np.tile([1e9, -1e9, 3.0], (31, 1)), np.tile([1e9, -1e9, 0.3], (31, 1)))
    x0 = np.full(12, 0.1)
    decision = dut.decide(x0, reference, some_plan())
    target = solver.asked[0][1]
    np.testing.assert_allclose(target.position, np.tile([6.1, -5.9, 3.0], (31, 1)))  # ten times 1 m/s for 0.6 s
    np.testing.assert_allclose(target.attitude, np.tile([np.pi, -np.pi, 0.3], (31, 1)))
    assert decision.objective > 1e18  # the cost of missing what was asked


def test_rates_and_inputs_out_of_reach_are_drawn_nearer(scenario: Scenario) -> None:
    dut, solver = planner(scenario, some_plan())
    state = np.zeros((31, 12))
    state[:, 6:9], state[:, 9:12] = [1e9, -1e9, 0.5], [0.7, -1e9, 1e9]
    dut.decide(np.full(12, 0.1), Reference(state, np.tile([1e9, 5.0, 1e4, 0.0, -1e9, 1e3], (30, 1))), some_plan())
    target = solver.asked[0][1]
    np.testing.assert_allclose(target.state[:, 6:], np.tile([10.0, -10.0, 0.5, 0.7, -10.0, 10.0], (31, 1)))
    np.testing.assert_allclose(target.input, np.tile([1e4, 5.0, 1e4, 0.0, -1e4, 1e3], (30, 1)))


@pytest.mark.parametrize("pitch", [0.5 * np.pi, -0.5 * np.pi, 1.53, 0.5 * np.pi + 0.01, -4.7])
def test_solvers_never_see_the_euler_singularity(pitch: float, scenario: Scenario) -> None:
    dut, solver = planner(scenario, *10 * [some_plan()])
    x0 = np.zeros(12)
    x0[4] = pitch
    assert dut.decide(x0, AT_REST, None).fallback is Fallback.NONE
    seen = solver.asked[0][0]
    assert abs(np.cos(seen[4])) > 0.049
    assert abs(np.remainder(seen[4] - pitch + np.pi, 2.0 * np.pi) - np.pi) < 0.11


def test_states_in_the_chart_reach_the_solver_as_they_are(scenario: Scenario, rng: np.random.Generator) -> None:
    for angles in rng.uniform(-1.0, 1.0, (20, 3)) * [np.pi, 1.5, np.pi]:
        dut, solver = planner(scenario, *10 * [some_plan()])
        x0 = np.concatenate([[1.0, 2.0, 3.0], angles, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]])
        dut.decide(x0, AT_REST, None)
        np.testing.assert_array_equal(solver.asked[0][0], x0)


def test_euler_angles_beyond_the_chart_are_named_anew(scenario: Scenario, rng: np.random.Generator) -> None:
    for angles in rng.uniform(-10.0, 10.0, (50, 3)):
        if abs(np.cos(angles[1])) < 0.05:
            continue
        dut, solver = planner(scenario, *10 * [some_plan()])
        dut.decide(np.concatenate([np.zeros(3), angles, np.zeros(6)]), AT_REST, None)
        seen = solver.asked[0][0][3:6]
        assert (np.abs(seen) <= [np.pi, 0.5 * np.pi, np.pi]).all()
        drakes = [RollPitchYaw(eta).ToRotationMatrix().matrix() for eta in (seen, angles)]
        np.testing.assert_allclose(drakes[0], drakes[1], atol=1e-12)


@pytest.mark.parametrize("previous", [None, some_plan()])
@pytest.mark.parametrize("broken", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("entry", [0, 4, 8, 11])
def test_a_state_that_is_not_finite_never_reaches_the_solver(entry, broken, previous, scenario) -> None:
    dut, solver = planner(scenario)
    state = np.zeros(12)
    state[entry] = broken
    decision = dut.decide(state, AT_REST, previous)
    assert solver.calls == []
    assert decision.fallback is (Fallback.HOVER if previous is None else Fallback.SHIFTED_PLAN)
    assert_can_be_applied(decision, scenario)


def test_a_reference_that_is_not_finite_never_reaches_the_solver(scenario: Scenario) -> None:
    dut, solver = planner(scenario)
    decision = dut.decide(np.zeros(12), Reference.of_pose(np.full((31, 3), np.nan), np.zeros((31, 3))), None)
    assert solver.calls == []
    assert_can_be_applied(decision, scenario)


def test_inputs_are_clipped_to_the_rotor_bounds(scenario: Scenario) -> None:
    dut, _ = planner(scenario, Plan(np.zeros((31, 12)), np.linspace(-1e4, 2e4, 180).reshape(30, 6)))
    assert_can_be_applied(dut.decide(np.zeros(12), AT_REST, some_plan()), scenario)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("size", [1.01e3, 1e10, 1e80, 1e160, 1e300])
@pytest.mark.parametrize("entries", [slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12), slice(0, 12)])
def test_finite_but_absurd_states_get_an_answer(entries: slice, size: float, solver: str, scenario: Scenario) -> None:
    scenario.mpc.solver = solver
    dut = Planner(scenario.airframe, scenario.mpc)
    state = np.zeros(12)
    state[entries] = size
    for previous in (None, dut.hover_plan(np.zeros(12))):
        decision = dut.decide(state, AT_REST, previous)
        assert decision.fallback is not Fallback.NONE
        assert_can_be_applied(decision, scenario)


@pytest.mark.parametrize("solver", ["piqp", "osqp"])
def test_softening_finds_an_answer_where_many_bounds_are_broken(
    solver: str, scenario: Scenario, rng: np.random.Generator
) -> None:
    scenario.mpc.solver = solver
    dut = Planner(scenario.airframe, scenario.mpc)
    _, upper = state_bounds(scenario.mpc)
    fallbacks = [dut.decide(rng.uniform(-1.5, 1.5, 12) * upper, AT_REST, None).fallback for _ in range(10)]
    assert set(fallbacks) <= {Fallback.NONE, Fallback.SOFTENED}
    assert Fallback.SOFTENED in fallbacks


@pytest.mark.parametrize("solver", SOLVERS)
def test_real_solvers_answer_far_outside_the_bounds(solver: str, scenario: Scenario) -> None:
    scenario.mpc.solver = solver
    dut = Planner(scenario.airframe, scenario.mpc)
    state = np.zeros(12)
    state[6:9] = [1.4, -1.2, 0.0]
    decision = dut.decide(state, AT_REST, None)
    assert decision.fallback is Fallback.SOFTENED
    assert_can_be_applied(decision, scenario)
    assert np.abs(decision.plan.state[-1, 6:9]).max() < 1.0 + 1e-4


def test_cold_start_is_already_settled(scenario: Scenario) -> None:
    dut = Planner(scenario.airframe, scenario.mpc)
    reference = Reference.of_pose(np.full((31, 3), 0.2), np.full((31, 3), 0.1))
    first = dut.decide(np.zeros(12), reference, None)
    model, period = dut.model, scenario.mpc.period
    assert first.fallback is Fallback.NONE
    np.testing.assert_allclose(first.plan.state, model.rollout(np.zeros(12), first.plan.input, period), atol=1e-4)
