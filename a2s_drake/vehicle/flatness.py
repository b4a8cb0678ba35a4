"""What a path and an attitude over time ask of the rotors: the hexarotor is flat in position and attitude.

Six rotors make any small force and torque, so that p(t) and eta(t) fix everything else algebraically: body rates from
eta and its rate, force and torque from the accelerations, and the squared rotor speeds from those (differential
flatness, M. Fliess et al., Int. J. Control 61(6), 1995). Pure functions, vectorised over samples, with derivatives.

An attitude trajectory enters as `motion` (..., 9): [eta (rad), its rate (rad/s), its acceleration (rad/s^2)].
"""

from dataclasses import dataclass

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.rotations import rotation_matrix
from a2s_drake.scenario.checks import refuse
from a2s_drake.scenario.parts import GRAVITY, Airframe
from a2s_drake.vehicle.airframe import wrench_map

_ETA, _RATE, _ACCELERATION = slice(0, 3), slice(3, 6), slice(6, 9)


@dataclass(frozen=True)
class FlatMap:
    """The algebraic map from a motion to body rates and squared rotor speeds.

    Attributes:
      mass: kg.
      inertia: principal moments, kg m^2, shape (3,).
      inputs_of_wrench: Hz^2 per force (N) over torque (N m) in B, shape (6, 6).
    """

    mass: float
    inertia: FloatArray
    inputs_of_wrench: FloatArray

    @classmethod
    def of(cls, airframe: Airframe) -> "FlatMap":
        """The map of an airframe.

        Raises:
          ScenarioError: when its rotors cannot make every wrench, so that it is not flat in position and attitude.
        """
        effect = wrench_map(airframe)
        # Newtons and newton metres are of like size here; 1e6 is far beyond any airframe that can turn in place.
        if np.linalg.cond(effect) > 1e6:
            raise refuse("airframe.tilt_deg", airframe.tilt_deg, "these rotors cannot make every wrench")
        return cls(
            airframe.mass,
            np.asarray(airframe.inertia, dtype=float),
            np.asarray(np.linalg.inv(effect), dtype=np.float64),
        )

    def needs(self, motion: FloatArray, acceleration: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Body angular velocity, rad/s, B, shape (..., 3), and squared rotor speeds, Hz^2, shape (..., 6).

        Args:
          motion: attitude trajectory, shape (..., 9).
          acceleration: of the centre of mass, m/s^2, W, shape (..., 3).
        """
        eta, rate = motion[..., _ETA], motion[..., _RATE]
        axes, turning = _euler_axes(eta), _axes_slope(eta, rate)
        omega = _apply(axes, rate)
        omega_slope = _apply(axes, motion[..., _ACCELERATION]) + _apply(turning, rate)
        torque = self.inertia * omega_slope + np.cross(omega, self.inertia * omega)
        force = self.mass * _apply(np.swapaxes(rotation_matrix(eta), -1, -2), _lift(acceleration))
        return omega, np.concatenate([force, torque], axis=-1) @ self.inputs_of_wrench.T

    def slopes(self, motion: FloatArray, acceleration: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Derivatives of both results of `needs` by the motion, shapes (..., 3, 9) and (..., 6, 9)."""
        eta, rate = motion[..., _ETA], motion[..., _RATE]
        axes, turning = _euler_axes(eta), _axes_slope(eta, rate)
        omega = _apply(axes, rate)

        omega_by = np.zeros((*eta.shape[:-1], 3, 9))
        omega_by[..., _ETA], omega_by[..., _RATE] = turning, axes

        # d(omega)/dt = axes acceleration + turning rate, where turning is itself linear in the rate.
        slope_by = np.zeros_like(omega_by)
        slope_by[..., _ETA] = _axes_slope(eta, motion[..., _ACCELERATION]) + _axes_curvature(eta, rate)
        slope_by[..., _RATE] = turning + _axes_rate(eta, rate)
        slope_by[..., _ACCELERATION] = axes
        # d(omega x J omega) = ([omega]_x J - [J omega]_x) d(omega), written as cross products of columns.
        columns = np.swapaxes(omega_by, -1, -2)
        gyroscopic = np.cross(omega[..., np.newaxis, :], self.inertia * columns)
        gyroscopic -= np.cross((self.inertia * omega)[..., np.newaxis, :], columns)

        wrench_by = np.zeros((*eta.shape[:-1], 6, 9))
        wrench_by[..., 3:, :] = self.inertia[:, np.newaxis] * slope_by + np.swapaxes(gyroscopic, -1, -2)
        force = self.mass * _apply(np.swapaxes(rotation_matrix(eta), -1, -2), _lift(acceleration))
        # Turning the body about e_i turns a fixed vector the other way: d(R^T b)/d eta_i = (R^T b) x e_i.
        wrench_by[..., :3, _ETA] = np.swapaxes(np.cross(force[..., np.newaxis, :], np.swapaxes(axes, -1, -2)), -1, -2)
        return omega_by, self.inputs_of_wrench @ wrench_by


def body_rates(eta: FloatArray, rate: FloatArray) -> FloatArray:
    """Body angular velocity omega, rad/s, B, of Euler angles (rad) that change at a rate (rad/s); shapes (..., 3)."""
    return _apply(_euler_axes(eta), rate)


def _lift(acceleration: FloatArray) -> FloatArray:
    return acceleration + np.array([0.0, 0.0, GRAVITY])


def _apply(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    return (matrix @ vector[..., np.newaxis])[..., 0]


def _trigonometry(eta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """cos(roll), sin(roll), cos(pitch), sin(pitch)."""
    cosine, sine = np.cos(eta), np.sin(eta)
    return cosine[..., 0], sine[..., 0], cosine[..., 1], sine[..., 1]


def _euler_axes(eta: FloatArray) -> FloatArray:
    """The matrix from d(eta)/dt to omega: the body axes about which roll, pitch and yaw turn, as columns."""
    cr, sr, cp, sp = _trigonometry(eta)
    axes = np.zeros((*eta.shape, 3))
    axes[..., 0, 0], axes[..., 0, 2] = 1.0, -sp
    axes[..., 1, 1], axes[..., 1, 2] = cr, sr * cp
    axes[..., 2, 1], axes[..., 2, 2] = -sr, cr * cp
    return axes


def _axes_slope(eta: FloatArray, vector: FloatArray) -> FloatArray:
    """Derivative of `_euler_axes(eta) vector` by eta, shape (..., 3, 3); linear in the vector."""
    cr, sr, cp, sp = _trigonometry(eta)
    pitch, yaw = vector[..., 1], vector[..., 2]
    slope = np.zeros((*eta.shape, 3))
    slope[..., 0, 1] = -cp * yaw
    slope[..., 1, 0], slope[..., 1, 1] = cr * cp * yaw - sr * pitch, -sr * sp * yaw
    slope[..., 2, 0], slope[..., 2, 1] = -cr * pitch - sr * cp * yaw, -cr * sp * yaw
    return slope


def _axes_rate(eta: FloatArray, rate: FloatArray) -> FloatArray:
    """Time derivative of `_euler_axes(eta)` while eta moves at a rate, shape (..., 3, 3)."""
    cr, sr, cp, sp = _trigonometry(eta)
    roll, pitch = rate[..., 0], rate[..., 1]
    turning = np.zeros((*eta.shape, 3))
    turning[..., 0, 2] = -cp * pitch
    turning[..., 1, 1], turning[..., 1, 2] = -sr * roll, cr * cp * roll - sr * sp * pitch
    turning[..., 2, 1], turning[..., 2, 2] = -cr * roll, -sr * cp * roll - cr * sp * pitch
    return turning


def _axes_curvature(eta: FloatArray, rate: FloatArray) -> FloatArray:
    """Derivative of `_axes_slope(eta, rate) rate` by eta, shape (..., 3, 3)."""
    cr, sr, cp, sp = _trigonometry(eta)
    roll, pitch, yaw = rate[..., 0], rate[..., 1], rate[..., 2]
    curvature = np.zeros((*eta.shape, 3))
    curvature[..., 0, 1] = sp * pitch * yaw
    curvature[..., 1, 0] = -cr * pitch * roll - (sr * cp * roll + cr * sp * pitch) * yaw
    curvature[..., 1, 1] = -(cr * sp * roll + sr * cp * pitch) * yaw
    curvature[..., 2, 0] = sr * pitch * roll + (sr * sp * pitch - cr * cp * roll) * yaw
    curvature[..., 2, 1] = (sr * sp * roll - cr * cp * pitch) * yaw
    return curvature
