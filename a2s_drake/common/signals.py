"""The signals between blocks: their units and sizes, the vehicle's state by name, and what the controller reports."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from pydrake.common.containers import namedview

from a2s_drake.common.arrays import Array, FloatArray

NUM_STATES = 12
NUM_INPUTS = 6

# The entries of the vehicle's state that each part takes up. To read a state, `State` is easier; these slices index the
# rows of Jacobians and weights as well.
POSITION, ATTITUDE, VELOCITY, ANGULAR_VELOCITY = slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12)


@dataclass(frozen=True, slots=True)
class State:
    """The vehicle's state by name. Each part is a view of the array, not a copy.

    Attributes:
      array: [p (m, W), eta (rad), v (m/s, W), omega (rad/s, B)], shape (..., 12), of floats or of AutoDiffXd.
    """

    array: Array

    @classmethod
    def of(cls, position: Array, attitude: Array, velocity: Array, angular_velocity: Array) -> "State":
        """The state made of its parts, each of shape (..., 3); this copies them."""
        return cls(np.concatenate([position, attitude, velocity, angular_velocity], axis=-1))

    @property
    def position(self) -> Array:
        """Of the centre of mass, m, W, shape (..., 3)."""
        return self.array[..., POSITION]

    @property
    def attitude(self) -> Array:
        """Roll, pitch, yaw, rad, shape (..., 3)."""
        return self.array[..., ATTITUDE]

    @property
    def velocity(self) -> Array:
        """Of the centre of mass, m/s, W, shape (..., 3)."""
        return self.array[..., VELOCITY]

    @property
    def angular_velocity(self) -> Array:
        """Of the body, rad/s, B, shape (..., 3)."""
        return self.array[..., ANGULAR_VELOCITY]

    @property
    def parts(self) -> tuple[Array, Array, Array, Array]:
        """Position, attitude, velocity and angular velocity."""
        return self.position, self.attitude, self.velocity, self.angular_velocity


def by_part(position: float, attitude: float, velocity: float, angular_velocity: float) -> FloatArray:
    """One number for each part of the state, repeated for its three entries, shape (12,)."""
    return np.repeat([position, attitude, velocity, angular_velocity], 3)


class Fallback(IntEnum):
    """Where an input came from: the problem as posed, or one of the stand-ins in the order they are tried."""

    NONE = 0  # the problem as posed was solved
    SOFTENED = 1  # the same problem with the state bounds as penalties, if need be around a fresh guess
    SHIFTED_PLAN = 2  # the previous plan, one period on
    HOVER = 3  # the rotor speeds that carry the level vehicle at rest


# What `solver_status` holds: success (1 when the problem as posed was solved, else 0), solver iterations, tracking cost
# of the plan, and the `Fallback` in force.
SolverStatus = namedview("SolverStatus", ["success", "iterations", "objective", "fallback"])

_STATE = "m, rad, m/s, rad/s"

PORT_UNITS: dict[str, str] = {
    "position_reference": "m",
    "position_preview": "m",
    "ship_position": "m",
    "ship_antenna_position": "m",
    "ship_preview": "m",
    "attitude_reference": "rad",
    "attitude_preview": "rad",
    "velocity_preview": "m/s",
    "angular_velocity_preview": "rad/s",
    "rotor_speed_squared_preview": "Hz^2",
    "vehicle_state": _STATE,
    "measured_state": _STATE,
    "predicted_state": _STATE,
    "rotor_speed_squared": "Hz^2",
    "rotor_speed_command": "Hz^2",
    "solver_status": "1",
    "channel_gain": "1",
    "snr_db": "dB",
    "spectral_efficiency": "bit/s/Hz",
    "phase_difference": "rad",
    "reflection": "1, rad",
    "plant_state": "1, m, rad/s, m/s",
    "spatial_forces": "N m, N",
}
"""Port name to unit, for this library's blocks; the parts of a mixed signal in the order that they stand."""

DRAKE_PORT_UNITS: dict[tuple[str, str], str] = {
    ("MultibodyPlant", "body_poses"): "1, m",
    ("Propeller", "spatial_forces"): "N m, N",
}
"""Class and port name to unit, for blocks of Drake's whose ports are wired to none of ours."""
