import numpy as np
import pytest

from a2s_drake import Scenario
from a2s_drake.airframe import hover_input
from a2s_drake.mpc.plan import Plan, Reference
from a2s_drake.mpc.planner import Decision, Fallback, Planner
from a2s_drake.mpc.program import input_bounds, state_bounds
from a2s_drake.mpc.solve import Solution
from a2s_drake.parameters import SOLVERS

AT_REST = Reference(np.zeros((31, 3)), np.zeros((31, 3)))


class FailingSolver:
    """Answers every call with the next entry of a script: a plan, None for "not found", or an exception to raise."""

    def __init__(self, *script: object) -> None:
        self.script = list(script)
        self.calls: list[bool] = []

    def solve(self, x0: np.ndarray, reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:  # noqa: ARG002
        self.calls.append(soft)
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


@pytest.mark.parametrize(
    "failure", [None, RuntimeError("no"), SystemExit("Drake"), Plan(np.full((31, 12), np.nan), np.ones((30, 6)))]
)
def test_then_the_previous_plan_is_shifted(failure: object, scenario: Scenario) -> None:
    dut, _ = planner(scenario, failure, failure)
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
    decision = dut.decide(np.zeros(12), Reference(np.full((31, 3), np.nan), np.zeros((31, 3))), None)
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
    reference = Reference(np.full((31, 3), 0.2), np.full((31, 3), 0.1))
    first = dut.decide(np.zeros(12), reference, None)
    model, period = dut.model, scenario.mpc.period
    assert first.fallback is Fallback.NONE
    np.testing.assert_allclose(first.plan.state, model.rollout(np.zeros(12), first.plan.input, period), atol=1e-4)
