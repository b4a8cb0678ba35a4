"""IPOPT on the exact nonlinear program, from a plan that is nearly optimal already."""

import contextlib
import logging
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff
from pydrake.solvers import IpoptSolver, MathematicalProgram, SolverOptions

from a2s_drake.common.arrays import FloatArray
from a2s_drake.guidance.plan.limits import NUM_USES
from a2s_drake.guidance.plan.segment import SHAPE, Segment, Task
from a2s_drake.guidance.plan.spline import SUPPORT

# Intervals that share a cost and a constraint. Fewer mean more calls from IPOPT into Python, more mean larger arrays of
# derivatives to hand over: five take two thirds of the time of ten.
_INTERVALS = 5

# Without second derivatives, and without multipliers of the plan that it starts from, IPOPT would first leave it for
# the middle of the limits. A barrier this low, held there, keeps it near them.
_BARRIER = 1e-7
_OPTIONS = {
    "mu_strategy": "monotone",
    "mu_init": _BARRIER,
    "bound_push": 1e-8,
    "bound_frac": 1e-8,
    "slack_bound_push": 1e-8,
    "slack_bound_frac": 1e-8,
    "bound_mult_init_method": "mu-based",
    "tol": 1e-5,
    "acceptable_tol": 1e-5,
}


class PlanProgram:
    """The whole program: control points, exact throughput and limits with analytic, sparse derivatives."""

    def __init__(self, task: Task) -> None:
        self.prog = MathematicalProgram()
        self._control = np.array(
            [self.prog.NewContinuousVariables(3, f"control{point}_") for point in range(task.grid.controls)]
        )
        for points, weights in zip(*task.grid.rest(), strict=True):
            for axis in range(3):
                variables = self._control[points, axis]
                self.prog.AddLinearEqualityConstraint(weights[np.newaxis], np.zeros(1), variables)
        for first in range(0, task.grid.intervals, _INTERVALS):
            self._add_segment(Segment(task, first, min(first + _INTERVALS, task.grid.intervals)))

    def _add_segment(self, segment: Segment) -> None:
        variables = self._control[segment.first : segment.last + SUPPORT - 1].ravel()
        columns = 3 * segment.shape_of_limit[:, :, np.newaxis] + np.arange(3)
        columns = np.repeat(columns.reshape(-1, SHAPE), NUM_USES, axis=0)
        rows = np.arange(len(columns))[:, np.newaxis]

        def cost(taped: Any) -> Any:
            if taped.dtype != object:
                return segment.cost(taped.reshape(-1, 3))
            value, gradient = segment.cost_gradient(ExtractValue(taped).reshape(-1, 3))
            chained = gradient.reshape(1, -1) @ ExtractGradient(taped)
            return InitializeAutoDiff(np.array([[value]]), chained)[0, 0]

        def use(taped: Any) -> Any:
            if taped.dtype != object:
                return segment.use(taped.reshape(-1, 3)).ravel()
            control = ExtractValue(taped).reshape(-1, 3)
            gradient = np.zeros((len(columns), control.size))
            gradient[rows, columns] = segment.use_slopes(control).reshape(-1, SHAPE)
            return InitializeAutoDiff(segment.use(control).ravel(), gradient @ ExtractGradient(taped))

        self.prog.AddCost(cost, variables)
        limit = np.ones(len(columns))
        constraint = self.prog.AddConstraint(use, -limit, limit, variables).evaluator()
        pattern = np.stack([np.broadcast_to(rows, columns.shape), columns], axis=-1).reshape(-1, 2)
        constraint.SetGradientSparsityPattern([(row, column) for row, column in pattern.tolist()])

    def solve(
        self, control: FloatArray, iterations: int, seconds: float | None, visit: Callable[[FloatArray], None]
    ) -> FloatArray:
        """What IPOPT ends with, whether or not it has converged, from given control points (controls, 3).

        Args:
          seconds: most wall-clock time to take, or none.
          visit: is shown all control points that IPOPT evaluates; must not raise.
        """
        options = SolverOptions()
        for name, setting in _OPTIONS.items():
            options.SetOption(IpoptSolver.id(), name, setting)
        options.SetOption(IpoptSolver.id(), "max_iter", iterations)
        if seconds is not None:
            options.SetOption(IpoptSolver.id(), "max_wall_time", max(seconds, 1e-3))
        variables = self._control.ravel()
        watch = self.prog.AddVisualizationCallback(lambda values: visit(values.reshape(-1, 3)), variables)
        self.prog.SetInitialGuess(self._control, control)
        with _without_warnings():
            result = IpoptSolver().Solve(self.prog, self.prog.initial_guess(), options)
        self.prog.RemoveVisualizationCallback(watch)
        return np.asarray(result.GetSolution(self._control))


@contextlib.contextmanager
def _without_warnings() -> Iterator[None]:
    """Drake warns of every iteration limit that is reached, which here is what the limit is for."""
    logger = logging.getLogger("drake")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)
