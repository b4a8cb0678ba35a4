"""What the MPC decides (a plan) and what it is asked to follow (a reference)."""

from dataclasses import dataclass

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.signals import NUM_INPUTS, State, by_part
from a2s_drake.scenario.parts import Mpc
from a2s_drake.vehicle.rigid_body import RigidBodyModel


@dataclass(frozen=True)
class Reference:
    """Previewed targets: states at now, now + T_s, ..., shape (N+1, 12), and inputs, Hz^2, shape (N, 6)."""

    state: FloatArray
    input: FloatArray

    @classmethod
    def of_pose(cls, position: FloatArray, attitude: FloatArray) -> "Reference":
        """The paper's targets: a pose (m, W, and rad; shapes (N+1, 3)), all else zero."""
        rest = np.zeros_like(position)
        return cls(State.of(position, attitude, rest, rest).array, np.zeros((len(position) - 1, NUM_INPUTS)))

    @property
    def position(self) -> FloatArray:
        """m, W, shape (N+1, 3)."""
        return State(self.state).position

    @property
    def attitude(self) -> FloatArray:
        """Roll, pitch, yaw, rad, shape (N+1, 3)."""
        return State(self.state).attitude

    def is_finite(self) -> bool:
        """Whether every number is finite."""
        return bool(np.isfinite(self.state).all() and np.isfinite(self.input).all())

    def within(self, centre: FloatArray, reach: FloatArray, input_reach: float) -> "Reference":
        """The same targets, drawn nearer: states to within `reach` (12,) of a centre (12,), and inputs, Hz^2."""
        state = np.clip(self.state, centre - reach, centre + reach)
        return Reference(state, np.clip(self.input, -input_reach, input_reach))


@dataclass(frozen=True)
class Plan:
    """Predicted states x_0..x_N, shape (N+1, 12), and inputs u_0..u_{N-1}, Hz^2, shape (N, 6)."""

    state: FloatArray
    input: FloatArray

    def is_finite(self) -> bool:
        """Whether every number is finite."""
        return bool(np.isfinite(self.state).all() and np.isfinite(self.input).all())

    def starting_at(self, x0: FloatArray) -> "Plan":
        """The same plan, but from a measured state (12,)."""
        return Plan(np.vstack([x0, self.state[1:]]), self.input)

    def shifted(self, end: FloatArray | None = None) -> "Plan":
        """The same plan one period later, its last input held for one more period.

        Args:
          end: the state (12,) that this leads to; by default the last state again, which is enough of a guess.
        """
        end = self.state[-1] if end is None else end
        return Plan(np.vstack([self.state[1:], end]), np.vstack([self.input[1:], self.input[-1]]))


def hold(x: FloatArray, u: FloatArray, horizon: int, model: RigidBodyModel, period: float) -> Plan:
    """The plan that holds input `u` (6,) from state `x` (12,), with the states that follow."""
    inputs = np.tile(u, (horizon, 1))
    return Plan(model.rollout(x, inputs, period), inputs)


def state_weights(mpc: Mpc) -> FloatArray:
    """Diagonal of the stage weight on the state, shape (12,)."""
    return by_part(
        position=mpc.position_weight,
        attitude=mpc.attitude_weight,
        velocity=mpc.velocity_weight,
        angular_velocity=mpc.angular_velocity_weight,
    )


def cost_terms(plan: Plan, reference: Reference, mpc: Mpc) -> dict[str, FloatArray]:
    """The cost of a plan split by term and stage; all of it together is `tracking_cost` (section IV of the paper).

    Returns:
      `position`, `attitude`, `velocity`, `angular_velocity` and `input`, each of shape (N+1,), dimensionless; the last
      stage is the terminal one, which has no input.
    """
    error = plan.state - reference.state
    weighted = State(error**2 * state_weights(mpc))
    by_input = np.append(mpc.input_weight * ((plan.input - reference.input) ** 2).sum(axis=-1), 0.0)
    names = ("position", "attitude", "velocity", "angular_velocity", "input")
    return dict(zip(names, (*(part.sum(axis=-1) for part in weighted.parts), by_input), strict=True))


def tracking_cost(plan: Plan, reference: Reference, mpc: Mpc) -> float:
    """The cost J of a plan: sum of squared weighted deviations, terminal term included (section IV of the paper)."""
    return float(sum(term.sum() for term in cost_terms(plan, reference, mpc).values()))
