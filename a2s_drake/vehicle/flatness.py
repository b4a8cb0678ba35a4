"""Computes the rotor speeds that a path and an attitude over time need: the hexarotor is flat in position and attitude.

Six rotors make any small force and torque, so p(t) and eta(t) fix everything else without integration. Body rates
follow from eta and its rate, force and torque from the accelerations, and the squared rotor speeds from force and
torque. This is called differential flatness (M. Fliess et al., Int. J. Control 61(6), 1995). The functions are pure and
vectorised over samples, and give derivatives too.

An attitude trajectory enters as `motion` (..., 9): [eta (rad), its rate (rad/s), its acceleration (rad/s^2)].
"""

from dataclasses import dataclass

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.rotations import (
    apply,
    euler_axes,
    euler_axes_curvature,
    euler_axes_rate,
    euler_axes_slope,
    rotation_matrix,
)
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
        axes, turning = euler_axes(eta), euler_axes_slope(eta, rate)
        omega = apply(axes, rate)
        omega_slope = apply(axes, motion[..., _ACCELERATION]) + apply(turning, rate)
        torque = self.inertia * omega_slope + np.cross(omega, self.inertia * omega)
        force = self.mass * apply(np.swapaxes(rotation_matrix(eta), -1, -2), _lift(acceleration))
        return omega, np.concatenate([force, torque], axis=-1) @ self.inputs_of_wrench.T

    def slopes(self, motion: FloatArray, acceleration: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Derivatives of both results of `needs` by the motion, shapes (..., 3, 9) and (..., 6, 9)."""
        eta, rate = motion[..., _ETA], motion[..., _RATE]
        axes, turning = euler_axes(eta), euler_axes_slope(eta, rate)
        omega = apply(axes, rate)

        omega_by = np.zeros((*eta.shape[:-1], 3, 9))
        omega_by[..., _ETA], omega_by[..., _RATE] = turning, axes

        # d(omega)/dt = axes acceleration + turning rate, where turning is itself linear in the rate.
        slope_by = np.zeros_like(omega_by)
        slope_by[..., _ETA] = euler_axes_slope(eta, motion[..., _ACCELERATION]) + euler_axes_curvature(eta, rate)
        slope_by[..., _RATE] = turning + euler_axes_rate(eta, rate)
        slope_by[..., _ACCELERATION] = axes
        # d(omega x J omega) = ([omega]_x J - [J omega]_x) d(omega), written as cross products of columns.
        columns = np.swapaxes(omega_by, -1, -2)
        gyroscopic = np.cross(omega[..., np.newaxis, :], self.inertia * columns)
        gyroscopic -= np.cross((self.inertia * omega)[..., np.newaxis, :], columns)

        wrench_by = np.zeros((*eta.shape[:-1], 6, 9))
        wrench_by[..., 3:, :] = self.inertia[:, np.newaxis] * slope_by + np.swapaxes(gyroscopic, -1, -2)
        force = self.mass * apply(np.swapaxes(rotation_matrix(eta), -1, -2), _lift(acceleration))
        # Turning the body about e_i turns a fixed vector the other way: d(R^T b)/d eta_i = (R^T b) x e_i.
        wrench_by[..., :3, _ETA] = np.swapaxes(np.cross(force[..., np.newaxis, :], np.swapaxes(axes, -1, -2)), -1, -2)
        return omega_by, self.inputs_of_wrench @ wrench_by


def _lift(acceleration: FloatArray) -> FloatArray:
    return acceleration + np.array([0.0, 0.0, GRAVITY])
