"""The MPC's MathematicalProgram: one definition of variables, cost and bounds, with linear or nonlinear dynamics.

A program is built once; each sample updates numbers in its bindings. Inputs are scaled by `INPUT_SCALE` before they
reach a solver, so that all decision variables are of order one.
"""

from typing import Any

import numpy as np
from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff
from pydrake.solvers import MathematicalProgram, MathematicalProgramResult

from a2s_drake.arrays import FloatArray
from a2s_drake.mpc.model import NUM_INPUTS, NUM_STATES, RigidBodyModel
from a2s_drake.mpc.plan import Plan, Reference, state_weights
from a2s_drake.parameters import Airframe, Mpc

INPUT_SCALE = 1.0e4  # Hz^2 per unit of the scaled input.

# Penalty on each bound's violation in a softened program, per unit of the state and per its square. The linear term
# lies well above the multipliers of the hard bounds (the largest over all named scenarios and laws is 34), so the
# penalty is exact: where the hard program has a solution, the softened one has the same.
SOFT_LINEAR, SOFT_QUADRATIC = 1.0e3, 1.0e4

_OVERFLOWED = 1.0e10

# Position and attitude are the states that follow a reference.
_TRACKED = slice(0, 6)


def state_bounds(mpc: Mpc) -> tuple[FloatArray, FloatArray]:
    """Lower and upper bounds of the state, each shape (12,), SI units."""
    limits = np.repeat([mpc.attitude_limit, mpc.velocity_limit, mpc.angular_velocity_limit], 3)
    return np.concatenate([mpc.position_lower, -limits]), np.concatenate([mpc.position_upper, limits])


def input_bounds(airframe: Airframe) -> tuple[float, float]:
    """Lower and upper bound of each squared rotor speed, Hz^2."""
    return airframe.rotor_speed_min**2, airframe.rotor_speed_max**2


class TrackingProgram:
    """The optimal control problem (eq. 15 of the paper) short of its dynamics.

    Hard bounds on u_0..u_{N-1}; bounds on x_1..x_N, hard or, with `soft`, as exact penalties; x_0 pinned to the
    measured state. Subclasses add x_{r+1} = h_d(x_r, u_r).
    """

    def __init__(self, model: RigidBodyModel, airframe: Airframe, mpc: Mpc, *, soft: bool = False) -> None:
        self._model, self._mpc, horizon = model, mpc, mpc.horizon
        self.prog = MathematicalProgram()
        self._num_states, self._num_inputs = NUM_STATES * (horizon + 1), NUM_INPUTS * horizon
        self._x = self.prog.NewContinuousVariables(self._num_states, "x").reshape(horizon + 1, NUM_STATES)
        self._u = self.prog.NewContinuousVariables(self._num_inputs, "u").reshape(horizon, NUM_INPUTS)

        self._weights = state_weights(mpc)
        for state in self._x:
            self.prog.AddQuadraticCost(np.diag(2.0 * self._weights), np.zeros(NUM_STATES), state, is_convex=True)
        input_hessian = 2.0 * mpc.input_weight * INPUT_SCALE**2 * np.eye(NUM_INPUTS)
        for scaled_input in self._u:
            self.prog.AddQuadraticCost(input_hessian, np.zeros(NUM_INPUTS), scaled_input, is_convex=True)
        tracked = self._x[:, _TRACKED].ravel()
        self._pull = self.prog.AddLinearCost(np.zeros(tracked.size), 0.0, tracked).evaluator()

        pinned = np.zeros(NUM_STATES)
        self._start = self.prog.AddBoundingBoxConstraint(pinned, pinned, self._x[0]).evaluator()
        low, high = input_bounds(airframe)
        self.prog.AddBoundingBoxConstraint(low / INPUT_SCALE, high / INPUT_SCALE, self._u.ravel())
        lower, upper = (np.tile(bound, horizon) for bound in state_bounds(mpc))
        if soft:
            self._add_soft_bounds(lower, upper)
        else:
            self.prog.AddBoundingBoxConstraint(lower, upper, self._x[1:].ravel())

    def _add_soft_bounds(self, lower: FloatArray, upper: FloatArray) -> None:
        bounded = self._x[1:].ravel()
        slack = self.prog.NewContinuousVariables(bounded.size, "slack")
        self.prog.AddBoundingBoxConstraint(0.0, np.inf, slack)
        for i, (state, excess) in enumerate(zip(bounded, slack, strict=True)):
            both_sides = np.array([[1.0, -1.0], [1.0, 1.0]])
            free = np.inf
            self.prog.AddLinearConstraint(both_sides, [-free, lower[i]], [upper[i], free], [state, excess])
            self.prog.AddQuadraticCost([[2.0 * SOFT_QUADRATIC]], [SOFT_LINEAR], [excess], is_convex=True)

    def aim(self, x0: FloatArray, reference: Reference) -> None:
        """Sets the measured state (12,) and the targets of this sample."""
        self._start.set_bounds(x0, x0)
        target = np.hstack([reference.position, reference.attitude])
        weighted = target * self._weights[_TRACKED]
        self._pull.UpdateCoefficients(-2.0 * weighted.ravel(), float((weighted * target).sum()))

    def guess(self, plan: Plan) -> FloatArray:
        """A plan as an initial guess of all decision variables; slacks start at zero."""
        guess = np.zeros(self.prog.num_vars())
        guess[: self._num_states] = plan.state.ravel()
        guess[self._num_states : self._num_states + self._num_inputs] = plan.input.ravel() / INPUT_SCALE
        return guess

    def read(self, result: MathematicalProgramResult) -> Plan:
        """The plan in a solver's result."""
        values = result.get_x_val()
        states, inputs = values[: self._num_states], values[self._num_states :][: self._num_inputs]
        return Plan(states.reshape(-1, NUM_STATES), INPUT_SCALE * inputs.reshape(-1, NUM_INPUTS))


class LinearizedProgram(TrackingProgram):
    """The Gauss-Newton QP: dynamics linearised along a given plan."""

    def __init__(self, model: RigidBodyModel, airframe: Airframe, mpc: Mpc, *, soft: bool = False) -> None:
        super().__init__(model, airframe, mpc, soft=soft)
        self._stages = []
        placeholder = np.zeros((NUM_STATES, 2 * NUM_STATES + NUM_INPUTS))
        for r in range(mpc.horizon):
            variables = np.concatenate([self._x[r], self._u[r], self._x[r + 1]])
            stage = self.prog.AddLinearEqualityConstraint(placeholder, np.zeros(NUM_STATES), variables)
            self._stages.append(stage.evaluator())

    def linearize(self, plan: Plan) -> None:
        """Replaces the dynamics by their first-order expansion about each (x_r, u_r) of a plan.

        Raises:
          FloatingPointError: when the expansion overflows; Drake would abort the process on such coefficients.
        """
        x, u = plan.state[:-1], plan.input
        following, slope = self._model.linearized_step(x, u, self._mpc.period)
        offset = (slope @ np.hstack([x, u])[..., np.newaxis])[..., 0] - following
        coefficients = np.empty((len(u), NUM_STATES, 2 * NUM_STATES + NUM_INPUTS))
        coefficients[..., : NUM_STATES + NUM_INPUTS] = slope
        coefficients[..., NUM_STATES : NUM_STATES + NUM_INPUTS] *= INPUT_SCALE
        coefficients[..., NUM_STATES + NUM_INPUTS :] = -np.eye(NUM_STATES)
        if not (np.isfinite(coefficients).all() and np.isfinite(offset).all()):
            raise FloatingPointError("the dynamics cannot be linearised about this plan")
        for stage, matrix, constant in zip(self._stages, coefficients, offset, strict=True):
            stage.UpdateCoefficients(matrix, constant)


class NonlinearProgram(TrackingProgram):
    """The whole nonlinear program: each stage's RK4 step as a constraint with analytic derivatives."""

    def __init__(self, model: RigidBodyModel, airframe: Airframe, mpc: Mpc, *, soft: bool = False) -> None:
        super().__init__(model, airframe, mpc, soft=soft)
        self._taped_calls = 0
        still = np.zeros(NUM_STATES)
        for r in range(mpc.horizon):
            variables = np.concatenate([self._x[r], self._u[r], self._x[r + 1]])
            self.prog.AddConstraint(self._defect, still, still, variables)

    @property
    def gradient_evaluations(self) -> int:
        """How often a solver has asked for the gradients of all stages."""
        return self._taped_calls // self._mpc.horizon

    def _defect(self, variables: Any) -> Any:
        """h_d(x_r, u_r) - x_{r+1}; for AutoDiffXd the analytic Jacobian is chained by hand."""
        taped = variables.dtype == object
        values = ExtractValue(variables).ravel() if taped else variables
        x, u, following = np.split(values, [NUM_STATES, NUM_STATES + NUM_INPUTS])
        u = INPUT_SCALE * u
        if not taped:
            return _finite(self._model.step(x, u, self._mpc.period)) - following
        self._taped_calls += 1
        reached, slope = map(_finite, self._model.linearized_step(x, u, self._mpc.period))
        slope[:, NUM_STATES:] *= INPUT_SCALE
        gradient = np.hstack([slope, -np.eye(NUM_STATES)]) @ ExtractGradient(variables)
        return InitializeAutoDiff(reached - following, gradient)


def _finite(values: FloatArray) -> FloatArray:
    """Overflowed values as very large ones: IPOPT backs away from those, but crashes on infinities."""
    return np.nan_to_num(values, nan=_OVERFLOWED, posinf=_OVERFLOWED, neginf=-_OVERFLOWED)
