"""The prediction model of the MPC: a rigid body under rotor wrenches, its Jacobians, and their RK4 discretisation.

State x = [p (m, W), eta = roll pitch yaw (rad), v (m/s, W), omega (rad/s, B)], input u = squared rotor speeds (Hz^2).
Everything is batched over leading axes in NumPy, so one call serves a whole horizon.
"""

from dataclasses import dataclass

import numpy as np

from a2s_drake.airframe import wrench_map
from a2s_drake.arrays import FloatArray
from a2s_drake.parameters import GRAVITY, Airframe
from a2s_drake.rotations import rotation_matrix, skew

NUM_STATES = 12
NUM_INPUTS = 6
POSITION, ATTITUDE, VELOCITY, RATE = slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12)


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

    def derivative(self, x: FloatArray, u: FloatArray) -> FloatArray:
        """Time derivative of the state, shape (..., 12), for x (..., 12) and u (..., 6)."""
        omega = x[..., RATE]
        wrench = u @ self.wrench_map.T
        xdot = np.empty_like(x)
        xdot[..., POSITION] = x[..., VELOCITY]
        xdot[..., ATTITUDE] = (_euler_rates(x[..., ATTITUDE]) @ omega[..., np.newaxis])[..., 0]
        force = rotation_matrix(x[..., ATTITUDE]) @ wrench[..., :3, np.newaxis]
        xdot[..., VELOCITY] = force[..., 0] / self.mass
        xdot[..., 8] -= GRAVITY
        gyroscopic = np.cross(omega, self.inertia * omega)
        xdot[..., RATE] = (wrench[..., 3:] - gyroscopic) / self.inertia
        return xdot

    def jacobians(self, x: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Derivatives of `derivative`: by the state, shape (..., 12, 12), and by the input, shape (..., 12, 6)."""
        eta, omega = x[..., ATTITUDE], x[..., RATE]
        R_WB = rotation_matrix(eta)
        force_B = u @ self.wrench_map[:3].T

        by_state = np.zeros((*x.shape[:-1], NUM_STATES, NUM_STATES))
        by_state[..., POSITION, VELOCITY] = np.eye(3)
        by_state[..., ATTITUDE, ATTITUDE] = _euler_rate_slope(eta, omega)
        by_state[..., ATTITUDE, RATE] = _euler_rates(eta)
        # d(R f)/d eta_i = R (e_i x f), e_i the body axis about which eta_i turns.
        by_state[..., VELOCITY, ATTITUDE] = -R_WB @ skew(force_B) @ _euler_axes(eta) / self.mass
        gyroscopic_slope = skew(self.inertia * omega) - skew(omega) * self.inertia
        by_state[..., RATE, RATE] = gyroscopic_slope / self.inertia[:, np.newaxis]

        by_input = np.zeros((*x.shape[:-1], NUM_STATES, NUM_INPUTS))
        by_input[..., VELOCITY, :] = R_WB @ (self.wrench_map[:3] / self.mass)
        by_input[..., RATE, :] = self.wrench_map[3:] / self.inertia[:, np.newaxis]
        return by_state, by_input

    def step(self, x: FloatArray, u: FloatArray, period: float) -> FloatArray:
        """The state one period (s) later under a held input, by one step of the classical Runge-Kutta method."""
        k1 = self.derivative(x, u)
        k2 = self.derivative(x + 0.5 * period * k1, u)
        k3 = self.derivative(x + 0.5 * period * k2, u)
        k4 = self.derivative(x + period * k3, u)
        return x + period / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    def linearized_step(self, x: FloatArray, u: FloatArray, period: float) -> tuple[FloatArray, FloatArray]:
        """`step` and its exact derivative by [x, u]: shapes (..., 12) and (..., 12, 18)."""
        identity = np.zeros((*x.shape[:-1], NUM_STATES, NUM_STATES + NUM_INPUTS))
        identity[..., :, :NUM_STATES] = np.eye(NUM_STATES)

        slope, slope_sum = np.zeros_like(x), np.zeros_like(x)
        sensitivity, sensitivity_sum = np.zeros_like(identity), np.zeros_like(identity)
        for offset, weight in ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
            stage = x + offset * period * slope
            by_state, by_input = self.jacobians(stage, u)
            slope = self.derivative(stage, u)
            sensitivity = by_state @ (identity + offset * period * sensitivity)
            sensitivity[..., :, NUM_STATES:] += by_input
            slope_sum += weight * slope
            sensitivity_sum += weight * sensitivity
        return x + period / 6.0 * slope_sum, identity + period / 6.0 * sensitivity_sum

    def rollout(self, x: FloatArray, inputs: FloatArray, period: float) -> FloatArray:
        """States under a sequence of held inputs: x (12,), inputs (N, 6) to (N+1, 12)."""
        states = [x]
        for u in inputs:
            states.append(self.step(states[-1], u, period))
        return np.stack(states)


def _euler_rates(eta: FloatArray) -> FloatArray:
    """The matrix from body angular velocity to d(eta)/dt, shape (..., 3, 3); singular at pitch +-90 deg."""
    sr, cr = np.sin(eta[..., 0]), np.cos(eta[..., 0])
    cp, tp = np.cos(eta[..., 1]), np.tan(eta[..., 1])
    matrix = np.zeros((*eta.shape, 3))
    matrix[..., 0, 0] = 1.0
    matrix[..., 0, 1], matrix[..., 0, 2] = sr * tp, cr * tp
    matrix[..., 1, 1], matrix[..., 1, 2] = cr, -sr
    matrix[..., 2, 1], matrix[..., 2, 2] = sr / cp, cr / cp
    return matrix


def _euler_rate_slope(eta: FloatArray, omega: FloatArray) -> FloatArray:
    """Derivative of `_euler_rates(eta) omega` by eta, shape (..., 3, 3); the yaw column is zero."""
    sr, cr = np.sin(eta[..., 0]), np.cos(eta[..., 0])
    cp, tp = np.cos(eta[..., 1]), np.tan(eta[..., 1])
    along = sr * omega[..., 1] + cr * omega[..., 2]
    across = cr * omega[..., 1] - sr * omega[..., 2]
    slope = np.zeros((*eta.shape, 3))
    slope[..., 0, 0], slope[..., 0, 1] = across * tp, along / cp**2
    slope[..., 1, 0] = -along
    slope[..., 2, 0], slope[..., 2, 1] = across / cp, along * tp / cp
    return slope


def _euler_axes(eta: FloatArray) -> FloatArray:
    """The body axes about which roll, pitch and yaw turn, as columns; the inverse of `_euler_rates`."""
    sr, cr = np.sin(eta[..., 0]), np.cos(eta[..., 0])
    sp, cp = np.sin(eta[..., 1]), np.cos(eta[..., 1])
    axes = np.zeros((*eta.shape, 3))
    axes[..., 0, 0], axes[..., 0, 2] = 1.0, -sp
    axes[..., 1, 1], axes[..., 1, 2] = cr, sr * cp
    axes[..., 2, 1], axes[..., 2, 2] = -sr, cr * cp
    return axes
