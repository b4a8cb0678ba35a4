"""The same QP the way one would first write it in Drake: a baseline that does not move with the MPC."""

import numpy as np
from pydrake.solvers import MathematicalProgram, OsqpSolver, SolverOptions

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.signals import NUM_INPUTS, NUM_STATES
from a2s_drake.control.horizon import Plan, Reference, state_weights
from a2s_drake.control.program import input_bounds, state_bounds
from a2s_drake.control.solve import Solution
from a2s_drake.scenario.parts import Airframe, Mpc
from a2s_drake.vehicle.rigid_body import RigidBodyModel

# The constants are separate from the MPC's, so that tuning the MPC does not change the baseline.
_SCALE = 1.0e4  # Hz^2 per unit of an input; without it OSQP takes far longer.
_TOLERANCE = 1.0e-5
_MAX_ITERATIONS = 4000
_SOLVED = 1


class PlainOsqp:
    """Drake's OSQP on one dense dynamics constraint a stage, and a quadratic cost per state and per input.

    This is a fair comparison, not a naive one. The program is built once and its numbers are updated. OSQP starts from
    the guess, and inputs are scaled. Linearisation is batched over the horizon, and Drake is told that the costs are
    convex.
    """

    def __init__(self, model: RigidBodyModel, airframe: Airframe, mpc: Mpc) -> None:
        self._model, self._mpc = model, mpc
        self._osqp, self._options = OsqpSolver(), SolverOptions()
        settings = {"eps_abs": _TOLERANCE, "eps_rel": _TOLERANCE, "max_iter": _MAX_ITERATIONS}
        for name, value in (settings | {"check_termination": 10, "polishing": 0}).items():
            self._options.SetOption(OsqpSolver.id(), name, value)
        self._prog = MathematicalProgram()
        self._x = self._prog.NewContinuousVariables(mpc.horizon + 1, NUM_STATES, "x")
        self._u = self._prog.NewContinuousVariables(mpc.horizon, NUM_INPUTS, "u")
        start, (low, high), (lower, upper) = np.zeros(NUM_STATES), input_bounds(airframe), state_bounds(mpc)
        self._start = self._prog.AddBoundingBoxConstraint(start, start, self._x[0]).evaluator()
        self._dynamics = []
        blank = np.ones((NUM_STATES, 2 * NUM_STATES + NUM_INPUTS))
        for x, u, following in zip(self._x[:-1], self._u, self._x[1:], strict=True):
            self._prog.AddBoundingBoxConstraint(low / _SCALE, high / _SCALE, u)
            self._prog.AddBoundingBoxConstraint(lower, upper, following)
            variables = np.concatenate([x, u, following])
            self._dynamics.append(self._prog.AddLinearEqualityConstraint(blank, start, variables).evaluator())
        weights, input_weights = np.diag(state_weights(mpc)), np.eye(NUM_INPUTS) * mpc.input_weight * _SCALE**2
        blank_input = np.zeros(NUM_INPUTS)
        self._costs = [
            *((self._prog.AddQuadraticErrorCost(weights, start, x).evaluator(), weights) for x in self._x),
            *(
                (self._prog.AddQuadraticErrorCost(input_weights, blank_input, u).evaluator(), input_weights)
                for u in self._u
            ),
        ]

    def pose(self, x0: FloatArray, reference: Reference, guess: Plan) -> None:
        """Linearises about a guess that starts at a measured state (12,), and takes over state and targets."""
        x, u = np.vstack([x0, guess.state[1:-1]]), guess.input
        following, by_state, by_input = _linearized_rk4(self._model, x, u, self._mpc.period)
        self._start.set_bounds(x0, x0)
        for r, dynamics in enumerate(self._dynamics):
            coefficients = np.hstack([by_state[r], _SCALE * by_input[r], -np.eye(NUM_STATES)])
            dynamics.UpdateCoefficients(coefficients, by_state[r] @ x[r] + by_input[r] @ u[r] - following[r])
        targets = (*reference.state, *(reference.input / _SCALE))
        for (cost, weights), target in zip(self._costs, targets, strict=True):
            pull = weights @ target
            cost.UpdateCoefficients(2.0 * weights, -2.0 * pull, target @ pull, True)

    def answer(self, guess: Plan) -> Solution:
        """Solves the problem posed, starting from a guess."""
        start = np.zeros(self._prog.num_vars())
        self._prog.SetDecisionVariableValueInVector(self._x, guess.state, start)
        self._prog.SetDecisionVariableValueInVector(self._u, guess.input / _SCALE, start)
        result = self._osqp.Solve(self._prog, start, self._options)
        details = result.get_solver_details()
        if not result.is_success() or details.status_val != _SOLVED:
            return Solution(None, details.iter)
        return Solution(Plan(result.GetSolution(self._x), _SCALE * result.GetSolution(self._u)), details.iter)

    def solve(self, x0: FloatArray, reference: Reference, guess: Plan) -> Solution:
        """Poses a problem and solves it."""
        self.pose(x0, reference, guess)
        return self.answer(guess)


def _linearized_rk4(
    model: RigidBodyModel, x: FloatArray, u: FloatArray, period: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A Runge-Kutta step and its derivatives by x and u, by the chain rule stage after stage, batched over the horizon.

    Args:
      x: (N, 12); u: (N, 6); period: s.
    Returns:
      shapes (N, 12), (N, 12, 12) and (N, 12, 6).
    """
    slope, by_state = np.zeros_like(x), np.zeros((len(x), NUM_STATES, NUM_STATES))
    by_input = np.zeros((len(x), NUM_STATES, NUM_INPUTS))
    totals = [np.zeros_like(part) for part in (slope, by_state, by_input)]
    for offset, weight in ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
        stage = x + offset * period * slope
        a, b = model.jacobians(stage, u)
        slope = model.derivative(stage, u)
        by_state = a @ (np.eye(NUM_STATES) + offset * period * by_state)
        by_input = a @ (offset * period * by_input) + b
        for total, part in zip(totals, (slope, by_state, by_input), strict=True):
            total += weight * part
    moved, turned, pushed = (period / 6.0 * total for total in totals)
    return x + moved, np.eye(NUM_STATES) + turned, pushed
