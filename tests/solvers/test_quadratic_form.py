import numpy as np
import pytest
from pydrake.solvers import LinearCost, MathematicalProgram, QuadraticCost

from a2s_drake import Scenario
from a2s_drake.control.program import LinearizedProgram
from a2s_drake.solvers.quadratic_form import QuadraticForm
from tests.support.tracking import hover_from, model_of, reference_at


def costs(prog: MathematicalProgram, x: np.ndarray) -> float:
    return sum(prog.EvalBinding(binding, x)[0] for binding in prog.GetAllCosts())


def quadratic(dut: QuadraticForm, x: np.ndarray) -> float:
    full = dut.P + dut.P.T
    full.setdiag(dut.P.diagonal())
    return float(0.5 * x @ (full @ x) + dut.c @ x)


def assert_same_program(dut: QuadraticForm, prog: MathematicalProgram, rng: np.random.Generator) -> None:
    """Costs up to a constant, and constraint values with their bounds, evaluated by Drake at random points."""
    x, y = rng.normal(size=(2, prog.num_vars()))
    assert quadratic(dut, x) - quadratic(dut, y) == pytest.approx(costs(prog, x) - costs(prog, y), rel=1e-12)
    for matrix, lower, upper, bindings in (
        (dut.A, dut.b, dut.b, prog.linear_equality_constraints()),
        (dut.G, dut.h_l, dut.h_u, prog.linear_constraints()),
    ):
        values = [prog.EvalBinding(binding, x) for binding in bindings]
        bounds = [(binding.evaluator().lower_bound(), binding.evaluator().upper_bound()) for binding in bindings]
        np.testing.assert_allclose(matrix @ x, np.concatenate([[], *values]), atol=1e-12)
        np.testing.assert_array_equal(lower, np.concatenate([[], *(low for low, _ in bounds)]))
        np.testing.assert_array_equal(upper, np.concatenate([[], *(high for _, high in bounds)]))


def program(rng: np.random.Generator) -> tuple[MathematicalProgram, np.ndarray]:
    prog = MathematicalProgram()
    x = prog.NewContinuousVariables(6)
    root = rng.normal(size=(3, 3))
    shared = QuadraticCost(root @ root.T, rng.normal(size=3), 1.0, is_convex=True)
    for variables in (x[[0, 1, 2]], x[[5, 2, 1]], x[[3, 4, 5]]):  # overlapping, and out of order
        prog.AddCost(shared, variables)
    slope = LinearCost(rng.normal(size=2), 0.0)
    prog.AddCost(slope, x[[1, 1]])  # the same variable twice
    prog.AddCost(slope, x[[0, 4]])
    prog.AddLinearEqualityConstraint(rng.normal(size=(2, 3)), rng.normal(size=2), x[[4, 0, 2]])
    prog.AddLinearEqualityConstraint(rng.normal(size=(1, 2)), rng.normal(size=1), x[[3, 3]])
    prog.AddLinearConstraint(rng.normal(size=(2, 6)), [-np.inf, -1.0], [2.0, np.inf], x)
    return prog, x


def test_form_says_what_the_program_says(rng: np.random.Generator) -> None:
    prog, _ = program(rng)
    assert_same_program(QuadraticForm(prog), prog, rng)


def test_boxes_on_one_variable_intersect(rng: np.random.Generator) -> None:
    prog, x = program(rng)
    prog.AddBoundingBoxConstraint(-1.0, 2.0, x[:3])
    prog.AddBoundingBoxConstraint(0.0, 5.0, x[2:4])
    prog.AddBoundingBoxConstraint([-2.0, -3.0], [9.0, 9.0], x[[4, 4]])
    dut = QuadraticForm(prog)
    np.testing.assert_array_equal(dut.x_l, [-1.0, -1.0, 0.0, 0.0, -2.0, -np.inf])
    np.testing.assert_array_equal(dut.x_u, [2.0, 2.0, 2.0, 5.0, 9.0, np.inf])


def test_new_numbers_are_taken_over(rng: np.random.Generator) -> None:
    prog, x = program(rng)
    box = prog.AddBoundingBoxConstraint(-1.0, 1.0, x).evaluator()
    dut = QuadraticForm(prog)
    prog.linear_costs()[0].evaluator().UpdateCoefficients([3.0, -4.0])
    prog.linear_equality_constraints()[0].evaluator().UpdateCoefficients(rng.normal(size=(2, 3)), [5.0, 6.0])
    prog.linear_constraints()[0].evaluator().set_bounds([-3.0, -3.0], [3.0, 3.0])
    box.set_bounds(np.full(6, -2.0), np.full(6, 3.0))
    assert dut.refresh(prog)
    assert_same_program(dut, prog, rng)
    assert (dut.x_l == -2.0).all()
    assert (dut.x_u == 3.0).all()


def change_hessian(prog: MathematicalProgram, _x: np.ndarray) -> None:
    prog.quadratic_costs()[0].evaluator().UpdateCoefficients(np.eye(3), np.zeros(3), 0.0)


def leave_the_sparsity(prog: MathematicalProgram, _x: np.ndarray) -> None:
    prog.linear_equality_constraints()[0].evaluator().UpdateCoefficients(np.eye(2, 3), np.zeros(2))


@pytest.mark.parametrize(
    "change",
    [
        lambda prog, x: prog.AddBoundingBoxConstraint(0.0, 1.0, x[0]),
        lambda prog, x: prog.AddLinearConstraint(np.ones((1, 6)), [0.0], [1.0], x),
        lambda prog, x: prog.AddLinearCost([1.0], 0.0, x[:1]),
        lambda prog, x: prog.RemoveCost(prog.linear_costs()[1]),  # noqa: ARG005
        lambda prog, x: prog.NewContinuousVariables(1),  # noqa: ARG005
        change_hessian,
        leave_the_sparsity,
    ],
)
def test_any_other_change_is_noticed(change, rng: np.random.Generator) -> None:
    prog, x = program(rng)
    dut = QuadraticForm(prog)
    assert dut.refresh(prog)
    change(prog, x)
    assert not dut.refresh(prog)


@pytest.mark.parametrize("soft", [False, True])
def test_form_of_the_mpcs_own_program(soft: bool, scenario: Scenario, rng: np.random.Generator) -> None:
    tracking = LinearizedProgram(model_of(scenario), scenario.airframe, scenario.mpc, soft=soft)
    dut = QuadraticForm(tracking.prog)
    tracking.linearize(hover_from(scenario, np.full(12, 0.01)))
    tracking.aim(reference_at(scenario, 300))
    assert dut.refresh(tracking.prog)
    assert_same_program(dut, tracking.prog, rng)
