import gc
import sys
import weakref
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.solvers import (
    ClarabelSolver,
    MathematicalProgram,
    MathematicalProgramResult,
    SolutionResult,
    SolverOptions,
)

from a2s_drake import Scenario, run_flight
from a2s_drake.solvers import piqp as piqp_solver
from a2s_drake.solvers.piqp import PiqpSolver
from diagrams import build_closed_loop

TIGHT = SolverOptions()
for name in ("eps_abs", "eps_duality_gap_abs"):
    TIGHT.SetOption(PiqpSolver.id(), name, 1e-9)


def feasible_program(seed: int) -> tuple[MathematicalProgram, np.ndarray]:
    """A strictly convex QP with every kind of linear constraint, one of them fixing a variable."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 12))
    prog = MathematicalProgram()
    x = prog.NewContinuousVariables(n)
    root, inside = rng.normal(size=(n, n)), rng.normal(size=n)
    prog.AddQuadraticCost(root @ root.T + np.eye(n), rng.normal(size=n), x, is_convex=True)
    prog.AddLinearCost(rng.normal(size=2), 0.0, x[:2])
    rows, equal = rng.normal(size=(3, n)), rng.normal(size=(1, n))
    prog.AddLinearConstraint(rows, rows @ inside - [0.1, np.inf, 0.0], rows @ inside + [np.inf, 0.1, 0.2], x)
    prog.AddLinearEqualityConstraint(equal, equal @ inside, x)
    prog.AddBoundingBoxConstraint(inside - 0.3, inside + 0.2, x)
    prog.AddBoundingBoxConstraint(inside[-1], inside[-1], x[-1])
    return prog, x


@given(seed=st.integers(0, 10_000))
def test_answers_are_clarabels(seed: int) -> None:
    prog, x = feasible_program(seed)
    dut = PiqpSolver().Solve(prog, None, TIGHT)
    oracle = ClarabelSolver().Solve(prog, None, None)
    assert oracle.is_success()
    assert dut.is_success()
    np.testing.assert_allclose(dut.GetSolution(x), oracle.GetSolution(x), atol=1e-4)


def test_linear_program() -> None:
    prog = MathematicalProgram()
    x = prog.NewContinuousVariables(2)
    prog.AddLinearCost([-1.0, -2.0], 0.0, x)
    prog.AddLinearConstraint(np.ones((1, 2)), [-np.inf], [3.0], x)
    prog.AddBoundingBoxConstraint(0.0, 2.0, x)
    np.testing.assert_allclose(PiqpSolver().Solve(prog, None, TIGHT).GetSolution(x), [1.0, 2.0], atol=1e-6)


def test_changes_to_a_program_reach_its_workspace() -> None:
    prog, x = feasible_program(3)
    dut = PiqpSolver()
    dut.Solve(prog, None, TIGHT)
    prog.linear_costs()[0].evaluator().UpdateCoefficients([5.0, -5.0])
    moved = dut.Solve(prog, None, TIGHT)
    np.testing.assert_allclose(moved.get_x_val(), ClarabelSolver().Solve(prog).get_x_val(), atol=1e-4)
    prog.AddQuadraticErrorCost(10.0 * np.eye(len(x)), np.ones(len(x)), x)
    reshaped = dut.Solve(prog, None, TIGHT)
    np.testing.assert_allclose(reshaped.get_x_val(), ClarabelSolver().Solve(prog).get_x_val(), atol=1e-4)
    assert np.abs(reshaped.get_x_val() - moved.get_x_val()).max() > 1e-3


@pytest.mark.parametrize("preconditioned", [False, True])
def test_an_answer_does_not_depend_on_what_was_solved_before(preconditioned: bool) -> None:
    options = SolverOptions()
    if not preconditioned:
        options.SetOption(PiqpSolver.id(), "preconditioner_iter", 0)
    prog, _ = feasible_program(5)
    fresh = PiqpSolver().Solve(prog, None, options).get_x_val()
    dut = PiqpSolver()
    cost, rows = prog.linear_costs()[0].evaluator(), prog.linear_constraints()[0].evaluator()
    slope, matrix, lower, upper = cost.a(), rows.GetDenseA(), rows.lower_bound(), rows.upper_bound()
    for other in (100.0, np.nan, -3.0):
        cost.UpdateCoefficients([other, 1.0])
        rows.UpdateCoefficients(7.0 * matrix, 7.0 * lower, 7.0 * upper)
        assert dut.Solve(prog, None, options).is_success() == np.isfinite(other)
    cost.UpdateCoefficients(slope)
    rows.UpdateCoefficients(matrix, lower, upper)
    np.testing.assert_array_equal(dut.Solve(prog, None, options).get_x_val(), fresh)


def test_infeasible_program_has_no_solution() -> None:
    prog, x = feasible_program(1)
    prog.AddLinearConstraint(np.ones((1, len(x))), [1e3], [np.inf], x)
    assert PiqpSolver().Solve(prog).get_solution_result() == SolutionResult.kInfeasibleConstraints


def test_iteration_limit_is_no_solution_and_is_counted() -> None:
    options = SolverOptions()
    options.SetOption(PiqpSolver.id(), "max_iter", 1)
    dut = PiqpSolver()
    prog, _ = feasible_program(2)
    assert dut.Solve(prog, None, options).get_solution_result() == SolutionResult.kIterationLimit
    assert dut.iterations == 1
    assert dut.Solve(prog).is_success()  # without the option, the limit is PIQP's own again
    assert dut.iterations > 1


def test_a_result_passed_in_is_filled() -> None:
    prog, x = feasible_program(7)
    result = PiqpSolver().Solve(prog)
    before = result.GetSolution(x)
    prog.linear_costs()[0].evaluator().UpdateCoefficients([3.0, 3.0])
    assert PiqpSolver().Solve(prog, None, None, result) is result
    assert np.abs(result.GetSolution(x) - before).max() > 1e-3


def test_a_result_may_go_from_program_to_program() -> None:
    (one, x), (other, y) = feasible_program(7), feasible_program(8)
    dut, result = PiqpSolver(), MathematicalProgramResult()
    expected = [PiqpSolver().Solve(prog).get_x_val() for prog in (one, other)]
    for prog, variables, values in ((one, x, expected[0]), (other, y, expected[1]), (one, x, expected[0])):
        dut.Solve(prog, None, None, result)
        np.testing.assert_array_equal(result.GetSolution(variables), values)
    ClarabelSolver().Solve(other, None, None, result)
    dut.Solve(one, None, None, result)
    np.testing.assert_array_equal(result.GetSolution(x), expected[0])


def test_a_program_that_grows_reaches_the_result_passed_in() -> None:
    prog, x = feasible_program(7)
    dut = PiqpSolver()
    result = dut.Solve(prog)
    before = result.GetSolution(x)
    y = prog.NewContinuousVariables(1)
    prog.AddQuadraticErrorCost(np.eye(1), [2.0], y)
    dut.Solve(prog, None, TIGHT, result)
    np.testing.assert_allclose(result.GetSolution(y), [2.0], atol=1e-6)
    np.testing.assert_allclose(result.GetSolution(x), before, atol=1e-4)


class Counter:
    """Passes calls on to what it stands for, and counts them."""

    def __init__(self, genuine: Callable[..., Any]) -> None:
        self.genuine, self.calls = genuine, 0

    def __call__(self, *arguments: Any) -> Any:
        self.calls += 1
        return self.genuine(*arguments)


def test_many_solves_set_a_program_up_once_and_bind_its_result_once(monkeypatch: pytest.MonkeyPatch) -> None:
    setups, bindings = Counter(piqp_solver._Workspace), Counter(piqp_solver._bind)
    monkeypatch.setattr(piqp_solver, "_Workspace", setups)
    monkeypatch.setattr(piqp_solver, "_bind", bindings)
    options = SolverOptions()
    options.SetOption(PiqpSolver.id(), "preconditioner_iter", 0)
    prog, _ = feasible_program(5)
    dut, result = PiqpSolver(), MathematicalProgramResult()
    for slope in range(20):
        prog.linear_costs()[0].evaluator().UpdateCoefficients([float(slope), 1.0])
        assert dut.Solve(prog, None, options, result).is_success()
    assert (setups.calls, bindings.calls) == (1, 1)


def test_a_flight_binds_each_program_once(monkeypatch: pytest.MonkeyPatch, scenario: Scenario) -> None:
    bindings = Counter(piqp_solver._bind)
    monkeypatch.setattr(piqp_solver, "_bind", bindings)
    short = scenario.with_overrides(["simulation.duration=0.4", "mpc.horizon=5"])
    flight = run_flight(build_closed_loop(short), short)
    assert len(flight.time) == 21
    assert (flight.solver_success == 1).all()  # so the softened program never had its turn
    assert bindings.calls == 1


def test_a_later_solve_leaves_earlier_results_alone() -> None:
    options = SolverOptions()
    options.SetOption(PiqpSolver.id(), "preconditioner_iter", 0)
    prog, x = feasible_program(7)
    dut = PiqpSolver()
    results, kept = [], []
    for slope in (0.0, 3.0, -3.0):
        prog.linear_costs()[0].evaluator().UpdateCoefficients([slope, slope])
        results.append(dut.Solve(prog, None, options))
        kept.append(results[-1].GetSolution(x).copy())
    assert np.abs(np.diff(kept, axis=0)).max(axis=1).min() > 1e-3  # three different answers
    for result, values in zip(results, kept, strict=True):
        np.testing.assert_array_equal(result.GetSolution(x), values)


def test_options_of_the_program_count_and_those_of_the_call_count_more() -> None:
    prog, _ = feasible_program(2)
    prog.SetSolverOption(PiqpSolver.id(), "max_iter", 1)
    dut = PiqpSolver()
    assert dut.Solve(prog).get_solution_result() == SolutionResult.kIterationLimit
    options = SolverOptions()
    options.SetOption(PiqpSolver.id(), "max_iter", 100)
    assert dut.Solve(prog, None, options).is_success()


def test_programs_of_other_kinds_are_refused() -> None:
    prog = MathematicalProgram()
    x = prog.NewContinuousVariables(1)
    prog.AddConstraint(lambda z: z**3, [0.0], [1.0], x)
    assert not PiqpSolver().AreProgramAttributesSatisfied(prog)
    with pytest.raises(ValueError, match=r"linear and convex quadratic programs, not one of type kNLP"):
        PiqpSolver().Solve(prog)


def test_unknown_option_is_named() -> None:
    options = SolverOptions()
    options.SetOption(PiqpSolver.id(), "max_itr", 1)
    with pytest.raises(ValueError, match="PIQP has no option 'max_itr'"):
        PiqpSolver().Solve(feasible_program(0)[0], None, options)


def test_option_of_the_wrong_kind_is_named() -> None:
    options = SolverOptions()
    options.SetOption(PiqpSolver.id(), "eps_abs", "tight")
    with pytest.raises(ValueError, match="PIQP's option 'eps_abs' cannot be 'tight'"):
        PiqpSolver().Solve(feasible_program(0)[0], None, options)


def test_missing_package_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "piqp", None)
    assert not PiqpSolver().available()
    with pytest.raises(ModuleNotFoundError, match="pip install piqp"):
        PiqpSolver().Solve(feasible_program(0)[0])


def test_workspaces_end_with_their_programs() -> None:
    dut = PiqpSolver()
    prog, x = feasible_program(0)
    dut.Solve(prog)
    gone = weakref.ref(prog)
    del prog, x
    gc.collect()
    assert gone() is None
