"""Sequential quadratic programming: the fringes chosen, a smooth plan within all limits in a few dozen convex QPs.

IPOPT by itself also finds it, but in Drake it knows no second derivatives: after 60 iterations it is still on its way,
where this has converged, the Hessian being known interval by interval.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.solvers import MathematicalProgram, QuadraticCost, SolverOptions
from scipy.sparse import csc_matrix

from a2s_drake.common.arrays import FloatArray
from a2s_drake.guidance.plan.limits import NUM_USES
from a2s_drake.guidance.plan.segment import SHAPE, Segment
from a2s_drake.guidance.plan.spline import SUPPORT, SplineGrid
from a2s_drake.solvers.piqp import PiqpSolver

# Price of each interval's largest excess over a limit, bit/Hz per unit of the limit. A limit's multiplier is what one
# interval's throughput can win by it; where this is ever too little, it is raised.
_FIRST_PRICE, _PRICE_RISE, _HIGHEST_PRICE = 2.0, 5.0, 1e5
# Trust region: largest change of a control point, rad.
_FIRST_RADIUS, _LARGEST_RADIUS, _SMALLEST_RADIUS = 0.05, 0.5, 1e-6
# Converged when the model promises less than this share of the throughput, and limits are kept to this share of them.
_GAIN_TOLERANCE, EXCESS_TOLERANCE = 1e-6, 1e-4


class StepProgram:
    """The convex QP of one step from given control points, its constraints elastic so that it always has a solution.

    Variables in the order of time, which the QP solver's factorisation lives on: after the control point that completes
    an interval's shape stands that interval's slack.
    """

    def __init__(self, grid: SplineGrid, segment: Segment) -> None:
        self._segment, self._solver = segment, PiqpSolver()
        self.prog = MathematicalProgram()
        steps, slacks = [], []
        for point in range(grid.controls):
            steps.append(self.prog.NewContinuousVariables(3, f"step{point}_"))
            if point >= SUPPORT - 1:
                slacks.append(self.prog.NewContinuousVariables(1, f"slack{point}_"))
        step, slack = np.array(steps), np.array(slacks).ravel()
        self._step_indices = np.reshape(self.prog.FindDecisionVariableIndices(step.ravel()), step.shape)
        self._slack_indices = np.asarray(self.prog.FindDecisionVariableIndices(slack))
        self._models = [QuadraticCost(np.eye(SHAPE), np.zeros(SHAPE), 0.0, is_convex=True) for _ in slack]
        for model, shape in zip(self._models, step[segment.shape_of_interval], strict=True):
            self.prog.AddCost(model, shape.ravel())
        self._price = self.prog.AddLinearCost(np.zeros(slack.size), 0.0, slack).evaluator()
        self.prog.AddBoundingBoxConstraint(0.0, np.inf, slack)
        self._region = self.prog.AddBoundingBoxConstraint(-1.0, 1.0, step.ravel()).evaluator()
        for points, weights in zip(*grid.rest(), strict=True):
            for axis in range(3):
                self.prog.AddLinearEqualityConstraint(weights[np.newaxis], np.zeros(1), step[points, axis])
        self._limits = self._add_limits()
        self._options = SolverOptions()
        for name in ("eps_abs", "eps_rel"):
            self._options.SetOption(PiqpSolver.id(), name, 1e-6)

    def _add_limits(self) -> Any:
        """Every limit twice: from above less the slack of its interval, from below plus the slack."""
        segment = self._segment
        count = len(segment.interval_of_limit)
        shapes = self._step_indices[segment.shape_of_limit].reshape(count, SHAPE)
        columns = np.hstack([shapes, self._slack_indices[segment.interval_of_limit, np.newaxis]])
        columns = np.broadcast_to(columns[:, np.newaxis], (count, NUM_USES, SHAPE + 1)).ravel()
        rows = np.repeat(np.arange(count * NUM_USES), SHAPE + 1)
        self._height = 2 * count * NUM_USES
        self._rows, self._columns = np.concatenate([rows, rows + count * NUM_USES]), np.tile(columns, 2)
        free = np.full(self._height, np.inf)
        ones = self._limit_matrix(np.ones((count, NUM_USES, SHAPE)))
        return self.prog.AddLinearConstraint(ones, -free, free, self.prog.decision_variables()).evaluator()

    def _limit_matrix(self, slopes: FloatArray) -> csc_matrix:
        one = np.ones((*slopes.shape[:-1], 1))
        values = np.concatenate([np.concatenate([slopes, sign * one], axis=-1).ravel() for sign in (-1.0, 1.0)])
        return csc_matrix((values, (self._rows, self._columns)), (self._height, self.prog.num_vars()))

    def expand(self, control: FloatArray) -> None:
        """Takes over the models of cost and limits about these control points."""
        _, self._gradient, self._hessian = self._segment.cost_model(control)
        for model, gradient, hessian in zip(self._models, self._gradient, self._hessian, strict=True):
            model.UpdateCoefficients(hessian, gradient, 0.0, True)
        self._slopes = self._segment.use_slopes(control)
        self._matrix = self._limit_matrix(self._slopes)
        self._set_limits(self._segment.use(control))

    def correct(self, control: FloatArray, step: FloatArray) -> None:
        """Makes the model of the limits exact at the end of a step, where their curvature had spoilt it."""
        shape = step[self._segment.shape_of_limit].reshape(-1, SHAPE, 1)
        self._set_limits(self._segment.use(control + step) - (self._slopes @ shape)[..., 0])

    def _set_limits(self, use: FloatArray) -> None:
        use, free = use.ravel(), np.full(self._height // 2, np.inf)
        low, high = np.concatenate([-free, -1.0 - use]), np.concatenate([1.0 - use, free])
        self._limits.UpdateCoefficients(self._matrix, low, high)

    def solve(self, radius: float, price: float) -> tuple[FloatArray, float, float] | None:
        """The best step within a trust region.

        Returns:
          the step, rad, (controls, 3), what the model says it adds to the cost, and the sum of the excesses that it
          says remain; None when the solver fails.
        """
        bound = np.full(self._step_indices.size, radius)
        self._region.set_bounds(-bound, bound)
        self._price.UpdateCoefficients(np.full(self._slack_indices.size, price), 0.0)
        result = self._solver.Solve(self.prog, None, self._options)
        if not result.is_success():
            return None
        values = result.get_x_val()
        step = values[self._step_indices]
        shape = step[self._segment.shape_of_interval].reshape(-1, SHAPE)
        added = (self._gradient * shape).sum() + 0.5 * np.einsum("ki,kij,kj->", shape, self._hessian, shape)
        return step, float(added), float(values[self._slack_indices].sum())


def improve(
    grid: SplineGrid, segment: Segment, control: FloatArray, iterations: int, visit: Callable[[FloatArray, int], None]
) -> FloatArray:
    """Control points of a local optimum near the given ones.

    A trust-region method on the exact penalty function cost + price * sum of the intervals' excesses, with second-order
    corrections (R. Fletcher, Practical Methods of Optimization, 1987, section 14.4). What it ends with may break limits
    where it was cut short.

    Args:
      visit: is shown the control points after every accepted step, and told how many QPs have been solved; may raise
        to end the search.
    """
    program = StepProgram(grid, segment)
    price, radius, solved = _FIRST_PRICE, _FIRST_RADIUS, 0
    cost, excess = segment.cost(control), segment.excess(control).sum()

    def won(step: FloatArray) -> float:
        left = cost - segment.cost(control + step) + price * (excess - segment.excess(control + step).sum())
        return float(left)

    stale = True
    while solved < iterations and radius > _SMALLEST_RADIUS:
        if stale:
            program.expand(control)
        found, stale = program.solve(radius, price), False
        solved += 1
        if found is None:
            radius *= 0.25
            continue
        step, added, remaining = found
        promised = price * (excess - remaining) - added
        if promised < _GAIN_TOLERANCE * abs(cost):
            if excess < EXCESS_TOLERANCE or price >= _HIGHEST_PRICE:
                break
            price *= _PRICE_RISE
            continue
        gained = won(step)
        if gained < 0.25 * promised:
            program.correct(control, step)
            corrected, stale = program.solve(radius, price), True
            solved += 1
            if corrected is not None and won(corrected[0]) > gained:
                step, gained = corrected[0], won(corrected[0])
        size = float(np.abs(step).max())
        if gained < 0.1 * promised:
            radius = 0.4 * min(radius, size)
        elif gained > 0.7 * promised:
            radius = min(max(radius, 2.0 * size), _LARGEST_RADIUS)
        if gained > 0.0:
            control, stale = control + step, True
            cost, excess = segment.cost(control), segment.excess(control).sum()
            visit(control, solved)
    return control
