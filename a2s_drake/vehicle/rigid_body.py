"""The prediction model of the MPC: a rigid body under rotor wrenches, its Jacobians, and their RK4 discretisation.

State x = [p (m, W), eta = roll pitch yaw (rad), v (m/s, W), omega (rad/s, B)], input u = squared rotor speeds (Hz^2).
Everything is batched over leading axes in NumPy, so one call serves a whole horizon.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.rotations import (
    apply,
    euler_axes,
    inverse_euler_axes,
    inverse_euler_axes_slope,
    rotation_matrix,
    skew,
)
from a2s_drake.common.signals import ANGULAR_VELOCITY, ATTITUDE, NUM_INPUTS, NUM_STATES, POSITION, VELOCITY, State
from a2s_drake.scenario.parts import GRAVITY, Airframe
from a2s_drake.vehicle.airframe import wrench_map

_TURNED = np.r_[ATTITUDE, ANGULAR_VELOCITY]
_FIRST, _SECOND = [1, 2, 0], [2, 0, 1]  # The two other axes of x, y and z, in cyclic order.
_IDENTITY = np.eye(3)

# The classical Runge-Kutta method: how far into the period each stage looks, and its weight in sixths.
_RK4_STAGES = ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0))


def _step_sparsity() -> NDArray[np.bool_]:
    """Which entries of a Runge-Kutta step's derivative by [x, u] can differ from zero, shape (12, 18)."""
    by_state = np.zeros((NUM_STATES, NUM_STATES), dtype=bool)
    by_state[POSITION, VELOCITY] = np.eye(3)
    by_state[ATTITUDE, ATTITUDE] = by_state[VELOCITY, ATTITUDE] = True
    by_state[ATTITUDE, ANGULAR_VELOCITY] = by_state[ANGULAR_VELOCITY, ANGULAR_VELOCITY] = True
    by_input = np.zeros((NUM_STATES, NUM_INPUTS), dtype=bool)
    by_input[VELOCITY] = by_input[ANGULAR_VELOCITY] = True
    # Four stages hand influence on up to four times.
    reach = np.linalg.matrix_power(np.eye(NUM_STATES) + by_state, len(_RK4_STAGES)) > 0.0
    return np.hstack([reach, reach @ by_input])


STEP_SPARSITY = _step_sparsity()


@dataclass(frozen=True)
class RigidBodyModel:
    """Newton-Euler dynamics with ZYX Euler kinematics (section IV of the paper).

    Attributes:
      mass: kg.
      inertia: principal moments, kg m^2, shape (3,).
      wrench_map: force (N) over torque (N m) in B per Hz^2, shape (6, 6).
    """

    mass: float
    inertia: FloatArray
    wrench_map: FloatArray

    @classmethod
    def of(cls, airframe: Airframe) -> "RigidBodyModel":
        """The model of an airframe, from the same rotor table as Drake's propellers."""
        return cls(airframe.mass, np.asarray(airframe.inertia, dtype=float), wrench_map(airframe))

    def accelerations(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What the rotors do to a body at rest: linear (m/s^2, B) and angular (rad/s^2, B), each (..., 3)."""
        both = u @ self._accelerations_by_input.T
        return both[..., :3], both[..., 3:]

    @cached_property
    def _gyroscopic_factors(self) -> FloatArray:
        return (self.inertia[_SECOND] - self.inertia[_FIRST]) / self.inertia

    @cached_property
    def _accelerations_by_input(self) -> FloatArray:
        return self.wrench_map / np.concatenate([np.full(3, self.mass), self.inertia])[:, np.newaxis]

    def derivative(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """Time derivative of the state, shape (..., 12), for x (..., 12) and u (..., 6)."""
        thrust_B, turn_B = self.accelerations(u)
        state = State(x)
        acceleration = apply(rotation_matrix(state.attitude), thrust_B)
        acceleration[..., 2] -= GRAVITY
        attitude_rate, angular_acceleration = self._turning(state.attitude, state.angular_velocity, turn_B)
        return State.of(state.velocity, attitude_rate, acceleration, angular_acceleration).array

    def _turning(self, eta: FloatArray, omega: FloatArray, turn_B: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Time derivatives of attitude and angular velocity, each (..., 3)."""
        # For principal moments omega x (J omega) is (J_z - J_y) omega_y omega_z, and so on in turn.
        gyroscopic = self._gyroscopic_factors * (omega[..., _FIRST] * omega[..., _SECOND])
        return apply(inverse_euler_axes(eta), omega), turn_B - gyroscopic

    def jacobians(self, x: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Derivatives of `derivative`: by the state, shape (..., 12, 12), and by the input, shape (..., 12, 6)."""
        state = State(x)
        turning, falling, R_WB = self._jacobian_blocks(state.attitude, state.angular_velocity, self.accelerations(u)[0])
        by_state = np.zeros((*x.shape[:-1], NUM_STATES, NUM_STATES))
        by_state[..., POSITION, VELOCITY] = np.eye(3)
        by_state[..., ATTITUDE, ATTITUDE] = turning[..., :3, :3]
        by_state[..., ATTITUDE, ANGULAR_VELOCITY] = turning[..., :3, 3:]
        by_state[..., VELOCITY, ATTITUDE] = falling
        by_state[..., ANGULAR_VELOCITY, ANGULAR_VELOCITY] = turning[..., 3:, 3:]
        by_input = np.zeros((*x.shape[:-1], NUM_STATES, NUM_INPUTS))
        by_input[..., VELOCITY, :] = R_WB @ self._accelerations_by_input[:3]
        by_input[..., ANGULAR_VELOCITY, :] = self._accelerations_by_input[3:]
        return by_state, by_input

    def _jacobian_blocks(
        self, eta: FloatArray, omega: FloatArray, thrust_B: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Derivatives that vary along a path.

        Returns:
          of `_turning` by [eta, omega], (..., 6, 6); of the acceleration by eta, (..., 3, 3); and R_WB, (..., 3, 3).
        """
        R_WB = rotation_matrix(eta)
        turning = np.zeros((*eta.shape[:-1], 6, 6))
        turning[..., :3, :3] = inverse_euler_axes_slope(eta, omega)
        turning[..., :3, 3:] = inverse_euler_axes(eta)
        turning[..., 3:, 3:] = (skew(self.inertia * omega) - skew(omega) * self.inertia) / self.inertia[:, np.newaxis]
        # d(R f)/d eta_i = R (e_i x f), e_i the body axis about which eta_i turns.
        falling = -R_WB @ (skew(thrust_B) @ euler_axes(eta))
        return turning, falling, R_WB

    def step(self, x: FloatArray, u: FloatArray, period: float) -> FloatArray:
        """The state one period (s) later under a held input, by one step of the classical Runge-Kutta method."""
        slope, slope_sum = np.zeros_like(x), np.zeros_like(x)
        for offset, weight in _RK4_STAGES:
            slope = self.derivative(x + offset * period * slope, u)
            slope_sum += weight * slope
        return x + period / 6.0 * slope_sum

    def linearized_step(self, x: FloatArray, u: FloatArray, period: float) -> tuple[FloatArray, FloatArray]:
        """`step` and its exact derivative by [x, u]: shapes (..., 12) and (..., 12, 18).

        The dynamics are a cascade: rotors turn the body, attitude directs the thrust, thrust moves the body. So only
        attitude and rates, [eta, omega], go through the stages one by one. Only their derivatives by [eta, omega,
        turn_B] are chained. The motion that follows from them is summed up over all stages at once.
        """
        thrust_B, turn_B = self.accelerations(u)
        turned = x[..., _TURNED]
        turning_rate, turned_by = np.zeros_like(turned), np.zeros_like(turned)
        stages = []
        for offset, weight in _RK4_STAGES:
            stages.append(turned + offset * period * turning_rate)
            turning_rate = np.concatenate(self._turning(stages[-1][..., :3], stages[-1][..., 3:], turn_B), axis=-1)
            turned_by += weight * turning_rate
        stage = np.stack(stages)
        turning, falling, R_WB = self._jacobian_blocks(stage[..., :3], stage[..., 3:], thrust_B)
        acceleration = apply(R_WB, thrust_B)

        # Derivatives by [eta, omega, turn_B]: of each stage, of its slope, and of the step.
        reached = np.zeros((*turning.shape[:-1], 9))
        reached[..., range(6), range(6)] = 1.0
        chained, chained_sum = np.zeros_like(reached[0]), np.zeros_like(reached[0])
        for k, (offset, weight) in enumerate(_RK4_STAGES):
            reached[k] += offset * period * chained
            chained = turning[k] @ reached[k]
            chained[..., 3:, 6:] += _IDENTITY
            chained_sum += weight * chained
        accelerated = falling @ reached[..., :3, :]

        following = x.copy()
        following[..., _TURNED] += period / 6.0 * turned_by
        acceleration[..., 2] -= GRAVITY
        fallen, moved = _stage_sums(acceleration, period)
        following[..., POSITION] += period * State(x).velocity + moved
        following[..., VELOCITY] += fallen

        by_turned = np.zeros((*x.shape[:-1], NUM_STATES, 9))
        by_turned[..., _TURNED, :] = period / 6.0 * chained_sum
        by_turned[..., VELOCITY, :], by_turned[..., POSITION, :] = _stage_sums(accelerated, period)
        by_thrust = np.zeros((*x.shape[:-1], NUM_STATES, 3))
        by_thrust[..., VELOCITY, :], by_thrust[..., POSITION, :] = _stage_sums(R_WB, period)

        slope = np.zeros((*x.shape[:-1], NUM_STATES, NUM_STATES + NUM_INPUTS))
        slope[..., _TURNED] = by_turned[..., :6]
        slope[..., range(NUM_STATES), range(NUM_STATES)] += 1.0
        slope[..., POSITION, VELOCITY] += period * _IDENTITY
        by_accelerations = np.concatenate([by_thrust, by_turned[..., 6:]], axis=-1)
        slope[..., NUM_STATES:] = by_accelerations @ self._accelerations_by_input
        return following, slope

    def rollout(self, x: FloatArray, inputs: FloatArray, period: float) -> FloatArray:
        """States under a sequence of held inputs: x (12,), inputs (N, 6) to (N+1, 12)."""
        states = [x]
        for u in inputs:
            states.append(self.step(states[-1], u, period))
        return np.stack(states)


def _stage_sums(slopes: FloatArray, period: float) -> tuple[FloatArray, FloatArray]:
    """What the four stages' accelerations (4, ...) add to the velocity and, by way of it, to the position."""
    first, second, third, fourth = slopes
    inner = second + third
    return period / 6.0 * (first + 2.0 * inner + fourth), period**2 / 6.0 * (first + inner)
