import numpy as np
import pytest
from pydrake.solvers import OsqpSolver

from a2s_drake import Scenario
from a2s_drake.control.horizon import Plan, Reference, cost_terms, tracking_cost
from a2s_drake.control.program import INPUT_SCALE, LinearizedProgram, NonlinearProgram, input_bounds, state_bounds
from a2s_drake.control.solve import WholeProgram, make_solver, solve_to_convergence
from a2s_drake.scenario.parts import SOLVERS
from tests.support.tracking import ROTOR_RANGE, hover_from, model_of, reference_at


@pytest.mark.parametrize("program", [LinearizedProgram, NonlinearProgram])
@pytest.mark.parametrize("soft", [False, True])
@pytest.mark.parametrize("whole", [False, True])
def test_program_cost_is_the_tracking_cost(
    program, soft: bool, whole: bool, scenario: Scenario, rng: np.random.Generator
) -> None:
    dut = program(model_of(scenario), scenario.airframe, scenario.mpc, soft=soft)
    plan = Plan(rng.normal(size=(31, 12)), rng.uniform(256.0, 1e4, (30, 6)))
    everything = Reference(rng.normal(size=(31, 12)), rng.uniform(256.0, 1e4, (30, 6)))
    reference = everything if whole else reference_at(scenario, 100)
    dut.aim(reference)
    costs = [dut.prog.EvalBinding(cost, dut.guess(plan))[0] for cost in dut.prog.GetAllCosts()]
    assert sum(costs) == pytest.approx(tracking_cost(plan, reference, scenario.mpc), rel=1e-12)


def test_tracking_cost_is_the_papers_sum(scenario: Scenario, rng: np.random.Generator) -> None:
    plan = Plan(rng.normal(size=(31, 12)), rng.uniform(256.0, 1e4, (30, 6)))
    reference = reference_at(scenario, 100)
    expected = 0.0
    for r in range(31):
        p, eta, v, w = np.split(plan.state[r], 4)
        expected += 100.0 * np.sum((reference.position[r] - p) ** 2) + 50.0 * np.sum((reference.attitude[r] - eta) ** 2)
        expected += np.sum(v**2) + 10.0 * np.sum(w**2)
        expected += 3.2e-8 * np.sum(plan.input[r] ** 2) if r < 30 else 0.0
    assert tracking_cost(plan, reference, scenario.mpc) == pytest.approx(expected, rel=1e-12)


def test_cost_terms_are_the_papers_sum_split_by_term_and_stage(scenario: Scenario, rng: np.random.Generator) -> None:
    plan = Plan(rng.normal(size=(31, 12)), rng.uniform(256.0, 1e4, (30, 6)))
    reference = reference_at(scenario, 100)
    terms = cost_terms(plan, reference, scenario.mpc)
    r = 7
    p, eta, v, w = np.split(plan.state[r], 4)
    expected = {
        "position": 100.0 * np.sum((reference.position[r] - p) ** 2),
        "attitude": 50.0 * np.sum((reference.attitude[r] - eta) ** 2),
        "velocity": np.sum(v**2),
        "angular_velocity": 10.0 * np.sum(w**2),
        "input": 3.2e-8 * np.sum(plan.input[r] ** 2),
    }
    assert {name: term[r] for name, term in terms.items()} == pytest.approx(expected, rel=1e-12)
    assert {term.shape for term in terms.values()} == {(31,)}
    assert terms["input"][30] == 0.0
    assert sum(term.sum() for term in terms.values()) == pytest.approx(tracking_cost(plan, reference, scenario.mpc))


def test_a_plan_that_is_its_reference_costs_nothing(scenario: Scenario, rng: np.random.Generator) -> None:
    plan = Plan(rng.normal(size=(31, 12)), rng.uniform(256.0, 1e4, (30, 6)))
    assert tracking_cost(plan, Reference(plan.state, plan.input), scenario.mpc) == 0.0
    off = Plan(plan.state, plan.input + 100.0)
    assert tracking_cost(off, Reference(plan.state, plan.input), scenario.mpc) == pytest.approx(180 * 3.2e-8 * 1e4)


def test_linearized_dynamics_hold_on_the_plan_they_were_taken_from(scenario: Scenario) -> None:
    dut = LinearizedProgram(model_of(scenario), scenario.airframe, scenario.mpc)
    model, rng = model_of(scenario), np.random.default_rng(0)
    inputs = rng.uniform(3000.0, 4500.0, (30, 6))
    rolled = Plan(model.rollout(np.zeros(12), inputs, 0.02), inputs)
    dut.linearize(rolled)
    dut.aim(reference_at(scenario, 0))
    for binding in dut.prog.linear_equality_constraints():
        residual = dut.prog.EvalBinding(binding, dut.guess(rolled)) - binding.evaluator().lower_bound()
        np.testing.assert_allclose(residual, 0.0, atol=1e-12)


def test_nonlinear_dynamics_hold_on_a_rollout_and_only_there(scenario: Scenario) -> None:
    dut = NonlinearProgram(model_of(scenario), scenario.airframe, scenario.mpc)
    plan = hover_from(scenario, np.full(12, 0.01))
    off = Plan(plan.state + 0.01 * np.arange(31)[:, np.newaxis], plan.input)
    defects, off_defects = (
        np.concatenate([dut.prog.EvalBinding(b, dut.guess(p)) for b in dut.prog.generic_constraints()])
        for p in (plan, off)
    )
    np.testing.assert_allclose(defects, 0.0, atol=1e-14)
    assert np.abs(off_defects).max() > 1e-3


@pytest.fixture(params=["piqp", "osqp"])
def qp_scenario(request: pytest.FixtureRequest, scenario: Scenario) -> Scenario:
    """Table I under each solver of the QP."""
    return scenario.with_overrides([f"mpc.solver={request.param}"])


def test_each_name_is_its_solver(scenario: Scenario) -> None:
    made = {}
    for name in SOLVERS:
        scenario.mpc.solver = name
        made[name] = make_solver(model_of(scenario), scenario.airframe, scenario.mpc)
    assert made["piqp"]._qp._piqp.solver_id().name() == "PIQP"
    assert made["osqp"]._qp._osqp.solver_id().name() == "OSQP"
    assert made["ipopt"]._ipopt.solver_id().name() == "Ipopt"


def test_solvers_of_the_qp_agree(scenario: Scenario, rng: np.random.Generator) -> None:
    scenario.mpc.qp_tolerance = 1e-7
    x0 = rng.uniform(-0.1, 0.1, 12)
    plans = []
    for name in ("piqp", "osqp"):
        scenario.mpc.solver = name
        dut = make_solver(model_of(scenario), scenario.airframe, scenario.mpc)
        plans.append(dut.solve(x0, reference_at(scenario, 194), hover_from(scenario, x0)).plan)
    np.testing.assert_allclose(plans[0].input, plans[1].input, atol=1e-4 * ROTOR_RANGE)
    np.testing.assert_allclose(plans[0].state, plans[1].state, atol=1e-5)


def test_solution_respects_bounds_and_its_own_dynamics(qp_scenario: Scenario) -> None:
    scenario = qp_scenario
    x0 = np.zeros(12)
    x0[4] = np.deg2rad(14.9)
    dut = make_solver(model_of(scenario), scenario.airframe, scenario.mpc)
    plan = solve_to_convergence(dut, x0, reference_at(scenario, 0), hover_from(scenario, x0)).plan
    assert plan is not None
    lower, upper = state_bounds(scenario.mpc)
    low, high = input_bounds(scenario.airframe)
    assert (plan.state[1:] <= upper + 1e-5).all()
    assert (plan.state[1:] >= lower - 1e-5).all()
    assert plan.input.min() >= low - 1e-4 * INPUT_SCALE
    assert plan.input.max() <= high + 1e-4 * INPUT_SCALE
    np.testing.assert_allclose(plan.state, model_of(scenario).rollout(x0, plan.input, 0.02), atol=1e-4)


def test_first_stage_is_predicted_from_the_measured_state(qp_scenario: Scenario) -> None:
    scenario = qp_scenario
    # The guess starts elsewhere; linearised there, the prediction of a turned vehicle would be off by millimetres.
    dut = make_solver(model_of(scenario), scenario.airframe, scenario.mpc)
    x0 = np.array([0.1, 0.0, 0.0, 0.2, -0.2, 0.1, 0.3, 0.0, 0.0, 0.5, -0.5, 0.3])
    plan = dut.solve(x0, reference_at(scenario, 0), hover_from(scenario, np.zeros(12))).plan
    assert plan is not None
    np.testing.assert_allclose(plan.state[1], model_of(scenario).step(x0, plan.input[0], 0.02), atol=1e-3)


def test_an_inaccurate_answer_is_no_answer(scenario: Scenario) -> None:
    # Stopped short, OSQP calls an answer within ten times its tolerance "inaccurate", and Drake calls that a success.
    scenario.mpc.solver = "osqp"
    dut = make_solver(model_of(scenario), scenario.airframe, scenario.mpc)
    x0 = np.zeros(12)
    guess = solve_to_convergence(dut, x0, reference_at(scenario, 0), hover_from(scenario, x0)).plan
    assert guess is not None
    results = []
    inner = dut._qp._osqp

    class Listening:
        def Solve(self, *arguments: object) -> object:  # noqa: N802 - Drake's name
            results.append(inner.Solve(*arguments))
            return results[-1]

    dut._qp._osqp = Listening()
    for iterations in range(10, 200, 10):
        dut._qp._options[False].SetOption(OsqpSolver.id(), "max_iter", iterations)
        solution = dut.solve(x0, reference_at(scenario, 0), guess)
        if results[-1].is_success() and results[-1].get_solver_details().status_val == 2:
            assert solution.plan is None
            return
    raise AssertionError("no inaccurate answer came up")


def test_state_bounds_stand_in_their_places(scenario: Scenario) -> None:
    scenario.mpc.velocity_limit, scenario.mpc.angular_velocity_limit = 2.0, 3.0
    lower, upper = state_bounds(scenario.mpc)
    np.testing.assert_allclose(upper, np.repeat([10.0, np.deg2rad(15.0), 2.0, 3.0], 3))
    np.testing.assert_allclose(lower, -upper)


def test_ipopt_reports_iterations(scenario: Scenario) -> None:
    dut = WholeProgram(model_of(scenario), scenario.airframe, scenario.mpc)
    solution = dut.solve(np.zeros(12), reference_at(scenario, 0), hover_from(scenario, np.zeros(12)))
    assert 5 <= solution.iterations <= 300


def test_softened_program_has_the_hard_solution_where_there_is_one(qp_scenario: Scenario) -> None:
    scenario = qp_scenario
    dut = make_solver(model_of(scenario), scenario.airframe, scenario.mpc)
    x0 = np.zeros(12)
    hard, soft = (
        dut.solve(x0, reference_at(scenario, 0), hover_from(scenario, x0), soft=soft).plan for soft in (False, True)
    )
    assert hard is not None
    assert soft is not None
    assert np.abs(hard.input[0] - soft.input[0]).max() <= 1e-3 * ROTOR_RANGE


def test_softened_program_answers_outside_the_bounds(qp_scenario: Scenario) -> None:
    scenario = qp_scenario
    dut = make_solver(model_of(scenario), scenario.airframe, scenario.mpc)
    x0 = np.zeros(12)
    x0[6] = 1.5  # faster than the velocity bound allows
    reference, guess = reference_at(scenario, 0), hover_from(scenario, x0)
    assert dut.solve(x0, reference, guess).plan is None
    plan = dut.solve(x0, reference, guess, soft=True).plan
    assert plan is not None
    assert abs(plan.state[-1, 6]) < 1.0


def test_softened_bounds_give_up_no_attitude_and_no_speed_for_position(qp_scenario: Scenario) -> None:
    dut = make_solver(model_of(qp_scenario), qp_scenario.airframe, qp_scenario.mpc)
    x0 = np.zeros(12)
    x0[0] = 15.0  # five metres outside the operating region, and fifteen from the target
    plan = dut.solve(x0, reference_at(qp_scenario, 0), hover_from(qp_scenario, x0), soft=True).plan
    assert plan is not None
    _, upper = state_bounds(qp_scenario.mpc)
    assert (np.abs(plan.state[1:, 3:]) <= upper[3:] + 1e-3).all()
    assert plan.state[-1, 0] < 14.9


def test_overflowing_dynamics_are_refused_before_they_reach_drake(scenario: Scenario) -> None:
    dut = LinearizedProgram(model_of(scenario), scenario.airframe, scenario.mpc)
    with np.errstate(all="ignore"), pytest.raises(FloatingPointError, match="cannot be linearised about this plan"):
        dut.linearize(Plan(np.full((31, 12), 1e200), np.full((30, 6), 4e3)))
