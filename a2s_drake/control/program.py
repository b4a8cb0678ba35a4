"""The MPC's MathematicalProgram: one definition of variables, cost and bounds, with linear or nonlinear dynamics.

A program is built once; each sample updates numbers in its bindings. Inputs are scaled by `INPUT_SCALE` before they
reach a solver, so that all decision variables are of order one. Variables are created in the order of time, because
some solvers work stage by stage.
"""

from typing import Any

import numpy as np
from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff
from pydrake.solvers import MathematicalProgram, MathematicalProgramResult, QuadraticCost
from scipy.sparse import csc_matrix

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.signals import NUM_INPUTS, NUM_STATES, by_part
from a2s_drake.control.horizon import Plan, Reference, state_weights
from a2s_drake.scenario.parts import Airframe, Mpc
from a2s_drake.vehicle.rigid_body import STEP_SPARSITY, RigidBodyModel

INPUT_SCALE = 1.0e4  # Hz^2 per unit of the scaled input.

# Penalty on each bound's violation in a softened program, per unit of the state and per its square, over the 12 states.
# Each linear term lies above the multipliers of the hard bounds; the largest over all named scenarios and laws is 34.
# So the penalty is exact: where the hard program has a solution, the softened one has the same. The penalties rank the
# bounds: no speed, and above all no attitude, is given up for a metre of position.
SOFT_LINEAR = by_part(position=1.0e2, attitude=1.0e5, velocity=1.0e3, angular_velocity=1.0e4)
SOFT_QUADRATIC = by_part(position=1.0e1, attitude=1.0e5, velocity=1.0e3, angular_velocity=1.0e4)

_OVERFLOWED = 1.0e10


def state_bounds(mpc: Mpc) -> tuple[FloatArray, FloatArray]:
    """Lower and upper bounds of the state, each shape (12,), SI units."""
    limits = np.repeat([mpc.attitude_limit, mpc.velocity_limit, mpc.angular_velocity_limit], 3)
    return np.concatenate([mpc.position_lower, -limits]), np.concatenate([mpc.position_upper, limits])


def input_bounds(airframe: Airframe) -> tuple[float, float]:
    """Lower and upper bound of each squared rotor speed, Hz^2."""
    return airframe.rotor_speed_min**2, airframe.rotor_speed_max**2


class TrackingProgram:
    """The optimal control problem (eq. 15 of the paper) without its dynamics.

    It has hard bounds on u_0..u_{N-1}, and bounds on x_1..x_N, which are hard or, with `soft`, exact penalties.
    Subclasses add x_{r+1} = h_d(x_r, u_r) and fix x_0 at the measured state.
    """

    def __init__(self, model: RigidBodyModel, airframe: Airframe, mpc: Mpc, *, soft: bool = False) -> None:
        self._model, self._mpc, self._weights = model, mpc, state_weights(mpc)
        self.prog = MathematicalProgram()
        states, inputs, slacks = [], [], []
        for r in range(mpc.horizon + 1):
            states.append(self.prog.NewContinuousVariables(NUM_STATES, f"x{r}_"))
            if soft and r > 0:
                slacks.append(self.prog.NewContinuousVariables(NUM_STATES, f"slack{r}_"))
            if r < mpc.horizon:
                inputs.append(self.prog.NewContinuousVariables(NUM_INPUTS, f"u{r}_"))
        self._x, self._u = np.array(states), np.array(inputs)
        self._x_indices, self._u_indices = (
            np.reshape(self.prog.FindDecisionVariableIndices(variables.ravel()), variables.shape)
            for variables in (self._x, self._u)
        )
        self._add_costs()
        low, high = input_bounds(airframe)
        self.prog.AddBoundingBoxConstraint(low / INPUT_SCALE, high / INPUT_SCALE, self._u.ravel())
        lower, upper = (np.tile(bound, mpc.horizon) for bound in state_bounds(mpc))
        if soft:
            self._add_soft_bounds(lower, upper, np.array(slacks))
        else:
            self.prog.AddBoundingBoxConstraint(lower, upper, self._x[1:].ravel())

    def _add_costs(self) -> None:
        input_weights = np.full(NUM_INPUTS, self._mpc.input_weight * INPUT_SCALE**2)
        horizon = self._mpc.horizon
        self._pull_weights = np.concatenate([np.tile(self._weights, horizon + 1), np.tile(input_weights, horizon)])
        # All stages share one evaluator, so it is read once and not N times.
        stage = _diagonal_cost(np.concatenate([self._weights, input_weights]))
        for state, scaled_input in zip(self._x[:-1], self._u, strict=True):
            self.prog.AddCost(stage, np.concatenate([state, scaled_input]))
        self.prog.AddCost(_diagonal_cost(self._weights), self._x[-1])
        followers = np.concatenate([self._x.ravel(), self._u.ravel()])
        self._pull = self.prog.AddLinearCost(np.zeros(followers.size), 0.0, followers).evaluator()

    def _add_soft_bounds(self, lower: FloatArray, upper: FloatArray, slacks: Any) -> None:
        self.prog.AddBoundingBoxConstraint(0.0, np.inf, slacks.ravel())
        penalty = _diagonal_cost(SOFT_QUADRATIC, SOFT_LINEAR)
        for excess in slacks:
            self.prog.AddCost(penalty, excess)
        identity, free = np.eye(lower.size), np.full(lower.size, np.inf)
        bounded = np.concatenate([self._x[1:].ravel(), slacks.ravel()])
        self.prog.AddLinearConstraint(csc_matrix(np.hstack([identity, identity])), lower, free, bounded)
        self.prog.AddLinearConstraint(csc_matrix(np.hstack([identity, -identity])), -free, upper, bounded)

    def aim(self, reference: Reference) -> None:
        """Sets the targets of this sample."""
        target = np.concatenate([reference.state.ravel(), reference.input.ravel() / INPUT_SCALE])
        weighted = self._pull_weights * target
        self._pull.UpdateCoefficients(-2.0 * weighted, float(weighted @ target))

    def guess(self, plan: Plan) -> FloatArray:
        """A plan as an initial guess of all decision variables; slacks start at zero."""
        guess = np.zeros(self.prog.num_vars())
        guess[self._x_indices] = plan.state
        guess[self._u_indices] = plan.input / INPUT_SCALE
        return guess

    def read(self, result: MathematicalProgramResult) -> Plan:
        """The plan in a solver's result."""
        values = result.get_x_val()
        return Plan(values[self._x_indices], INPUT_SCALE * values[self._u_indices])


def _diagonal_cost(weights: FloatArray, slopes: FloatArray | None = None) -> QuadraticCost:
    """The cost sum of w_i x_i^2 + s_i x_i."""
    slopes = np.zeros(weights.size) if slopes is None else slopes
    return QuadraticCost(np.diag(2.0 * weights), slopes, 0.0, is_convex=True)


class LinearizedProgram(TrackingProgram):
    """The Gauss-Newton QP: dynamics linearised along a given plan.

    All stages stand in one sparse constraint, because each binding costs a call to update and another to read. Its
    first rows are -x_0 = -x. Then follow [A_r B_r] [x_r, u_r] - x_{r+1} = [A_r B_r] [x, u] - h_d(x, u), with the plan's
    x and u on the right.

    The first state is set by these rows and not by two equal bounds on x_0. Such bounds would leave interior-point
    methods no interior, and cost them half as many iterations again.
    """

    def __init__(self, model: RigidBodyModel, airframe: Airframe, mpc: Mpc, *, soft: bool = False) -> None:
        super().__init__(model, airframe, mpc, soft=soft)
        height = NUM_STATES * (mpc.horizon + 1)
        i, j = np.nonzero(STEP_SPARSITY)
        stages = np.arange(mpc.horizon)[:, np.newaxis]
        before = np.hstack([self._x_indices[:-1], self._u_indices])
        rows = np.concatenate([(NUM_STATES * (stages + 1) + i).ravel(), np.arange(height)])
        columns = np.concatenate([before[:, j].ravel(), self._x_indices.ravel()])
        order = np.lexsort((rows, columns))  # that of CSC
        starts = np.searchsorted(columns[order], np.arange(self.prog.num_vars() + 1))
        self._matrix = csc_matrix((np.full(order.size, -1.0), rows[order], starts), (height, self.prog.num_vars()))
        # Entry `_places[k]` of the CSC data is entry `_sources[k]` of the flattened slopes; all others stay -1.
        sources = (STEP_SPARSITY.size * stages + STEP_SPARSITY.shape[1] * i + j).ravel()
        self._places = np.flatnonzero(order < sources.size)
        self._sources = sources[order[self._places]]
        variables = self.prog.decision_variables()
        self._dynamics = self.prog.AddLinearEqualityConstraint(self._matrix, np.zeros(height), variables).evaluator()

    def linearize(self, plan: Plan) -> None:
        """Pins x_0 to a plan's, and replaces the dynamics by their first-order expansion about its (x_r, u_r).

        Raises:
          FloatingPointError: when the expansion overflows; Drake would end the process on such coefficients.
        """
        x, u = plan.state[:-1], plan.input
        following, slope = self._model.linearized_step(x, u, self._mpc.period)
        constant = (slope @ np.concatenate([x, u], axis=-1)[..., np.newaxis])[..., 0] - following
        slope[..., NUM_STATES:] *= INPUT_SCALE
        if not (np.isfinite(slope).all() and np.isfinite(constant).all()):
            raise FloatingPointError("the dynamics cannot be linearised about this plan")
        self._matrix.data[self._places] = slope.ravel()[self._sources]
        self._dynamics.UpdateCoefficients(self._matrix, np.concatenate([-x[0], constant.ravel()]))


class NonlinearProgram(TrackingProgram):
    """The whole nonlinear program: each stage's RK4 step as a constraint with analytic derivatives."""

    def __init__(self, model: RigidBodyModel, airframe: Airframe, mpc: Mpc, *, soft: bool = False) -> None:
        super().__init__(model, airframe, mpc, soft=soft)
        self._taped_calls = 0
        pinned = np.zeros(NUM_STATES)
        self._start = self.prog.AddBoundingBoxConstraint(pinned, pinned, self._x[0]).evaluator()
        still = np.zeros(NUM_STATES)
        for r in range(mpc.horizon):
            variables = np.concatenate([self._x[r], self._u[r], self._x[r + 1]])
            self.prog.AddConstraint(self._defect, still, still, variables)

    def start_at(self, x0: FloatArray) -> None:
        """Pins x_0 to a measured state (12,)."""
        self._start.set_bounds(x0, x0)

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
