import numpy as np
import pytest

from a2s_drake import Scenario, attitude_reference
from a2s_drake.airframe import hover_input
from a2s_drake.mpc.model import RigidBodyModel
from a2s_drake.mpc.plan import Plan, Reference, hold, tracking_cost
from a2s_drake.mpc.program import INPUT_SCALE, LinearizedProgram, NonlinearProgram, input_bounds, state_bounds
from a2s_drake.mpc.solve import RealTimeIteration, WholeProgram, solve_to_convergence
from a2s_drake.paths import ship_position, uav_position

ROTOR_RANGE = 100.0**2 - 16.0**2  # Hz^2


def reference_at(scenario: Scenario, sample: int) -> Reference:
    times = scenario.mpc.period * (sample + np.arange(scenario.mpc.horizon + 1))
    position, ship = uav_position(times, scenario.mission), ship_position(times, scenario.mission)
    limit = scenario.mpc.attitude_limit
    return Reference(position, attitude_reference(position, ship, scenario.link, scenario.attitude_law, limit))


def model_of(scenario: Scenario) -> RigidBodyModel:
    return RigidBodyModel.of(scenario.airframe)


def hover_from(scenario: Scenario, x0: np.ndarray) -> Plan:
    hover = hover_input(scenario.airframe)
    return hold(x0, hover, scenario.mpc.horizon, model_of(scenario), scenario.mpc.period)


@pytest.mark.parametrize("program", [LinearizedProgram, NonlinearProgram])
@pytest.mark.parametrize("soft", [False, True])
def test_program_cost_is_the_tracking_cost(program, soft: bool, scenario: Scenario, rng: np.random.Generator) -> None:
    dut = program(model_of(scenario), scenario.airframe, scenario.mpc, soft=soft)
    plan = Plan(rng.normal(size=(31, 12)), rng.uniform(256.0, 1e4, (30, 6)))
    reference = reference_at(scenario, 100)
    dut.aim(plan.state[0], reference)
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


def test_linearized_dynamics_hold_on_the_plan_they_were_taken_from(scenario: Scenario) -> None:
    dut = LinearizedProgram(model_of(scenario), scenario.airframe, scenario.mpc)
    model, rng = model_of(scenario), np.random.default_rng(0)
    inputs = rng.uniform(3000.0, 4500.0, (30, 6))
    rolled = Plan(model.rollout(np.zeros(12), inputs, 0.02), inputs)
    dut.linearize(rolled)
    dut.aim(rolled.state[0], reference_at(scenario, 0))
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


def test_only_osqp_and_ipopt_are_ever_called(scenario: Scenario) -> None:
    rti = RealTimeIteration(model_of(scenario), scenario.airframe, scenario.mpc)
    whole = WholeProgram(model_of(scenario), scenario.airframe, scenario.mpc)
    x0 = np.zeros(12)
    assert rti._osqp.solver_id().name() == "OSQP"
    assert whole._ipopt.solver_id().name() == "Ipopt"
    for solver in (rti, whole):
        assert solver.solve(x0, reference_at(scenario, 0), hover_from(scenario, x0)).plan is not None


def test_solution_respects_bounds_and_its_own_dynamics(scenario: Scenario) -> None:
    x0 = np.zeros(12)
    x0[4] = np.deg2rad(14.9)
    dut = RealTimeIteration(model_of(scenario), scenario.airframe, scenario.mpc)
    plan = solve_to_convergence(dut, x0, reference_at(scenario, 0), hover_from(scenario, x0)).plan
    assert plan is not None
    lower, upper = state_bounds(scenario.mpc)
    low, high = input_bounds(scenario.airframe)
    assert (plan.state[1:] <= upper + 1e-5).all()
    assert (plan.state[1:] >= lower - 1e-5).all()
    assert plan.input.min() >= low - 1e-4 * INPUT_SCALE
    assert plan.input.max() <= high + 1e-4 * INPUT_SCALE
    np.testing.assert_allclose(plan.state, model_of(scenario).rollout(x0, plan.input, 0.02), atol=1e-4)


@pytest.mark.parametrize("sample", [0, 100, 194, 300, 478, 650, 805, 1000, 1325, 1879])
def test_settled_rti_is_the_solution_of_the_whole_program(sample: int, fly) -> None:
    # The states come from the flight; jumps of the reference lie just ahead of samples 194, 478, 805, 1325 and 1879.
    flight = fly("paper_calibrated")
    scenario = flight.scenario
    x0 = np.concatenate(
        [a[sample] for a in (flight.position, flight.attitude, flight.velocity, flight.angular_velocity)]
    )
    model, reference, guess = model_of(scenario), reference_at(scenario, sample), hover_from(scenario, x0)
    settled = solve_to_convergence(
        RealTimeIteration(model, scenario.airframe, scenario.mpc), x0, reference, guess, change=1e-6
    )
    whole = WholeProgram(model, scenario.airframe, scenario.mpc).solve(x0, reference, guess)
    assert settled.plan is not None
    assert whole.plan is not None
    assert np.abs(settled.plan.input[0] - whole.plan.input[0]).max() <= 0.01 * ROTOR_RANGE


@pytest.mark.parametrize("sample", [0, 100, 194, 478, 1325])
def test_qp_accuracy(sample: int, fly) -> None:
    # What the README states: the applied input lies within 0.01 % of the rotor range of the QP's solution.
    flight = fly("paper_calibrated")
    scenario = flight.scenario
    x0 = np.concatenate(
        [a[sample] for a in (flight.position, flight.attitude, flight.velocity, flight.angular_velocity)]
    )
    exact = scenario.with_overrides(["mpc.qp_tolerance=1e-9", "mpc.qp_max_iterations=100000"])
    plans = [
        RealTimeIteration(model_of(s), s.airframe, s.mpc).solve(x0, reference_at(s, sample), hover_from(s, x0)).plan
        for s in (scenario, exact)
    ]
    assert plans[0] is not None
    assert plans[1] is not None
    assert np.abs(plans[0].input[0] - plans[1].input[0]).max() <= 1e-4 * ROTOR_RANGE


def test_softened_program_has_the_hard_solution_where_there_is_one(scenario: Scenario) -> None:
    dut = RealTimeIteration(model_of(scenario), scenario.airframe, scenario.mpc)
    x0 = np.zeros(12)
    hard, soft = (
        dut.solve(x0, reference_at(scenario, 0), hover_from(scenario, x0), soft=soft).plan for soft in (False, True)
    )
    assert hard is not None
    assert soft is not None
    assert np.abs(hard.input[0] - soft.input[0]).max() <= 1e-3 * ROTOR_RANGE


def test_softened_program_answers_outside_the_bounds(scenario: Scenario) -> None:
    dut = RealTimeIteration(model_of(scenario), scenario.airframe, scenario.mpc)
    x0 = np.zeros(12)
    x0[6] = 1.5  # faster than the velocity bound allows
    reference, guess = reference_at(scenario, 0), hover_from(scenario, x0)
    assert dut.solve(x0, reference, guess).plan is None
    plan = dut.solve(x0, reference, guess, soft=True).plan
    assert plan is not None
    assert abs(plan.state[-1, 6]) < 1.0
