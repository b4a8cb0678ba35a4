"""The airframe's rotors by plain trigonometry: an oracle that shares no code with the wrench map it checks."""

import numpy as np

from a2s_drake import Airframe


def wrench_by_hand(airframe: Airframe) -> np.ndarray:
    """Force (N) over torque (N m) in B of each rotor per squared speed (Hz^2), shape (6, 6)."""
    tilt, columns = np.deg2rad(airframe.tilt_deg), []
    for i in range(6):
        arm = np.array([np.cos(i * np.pi / 3.0), np.sin(i * np.pi / 3.0), 0.0])
        sideways, turn = np.array([-arm[1], arm[0], 0.0]), (-1.0) ** i
        axis = np.cos(tilt) * np.array([0.0, 0.0, 1.0]) + turn * np.sin(tilt) * sideways
        drag = airframe.drag_sign * turn * airframe.drag_to_thrust * axis
        columns.append(airframe.thrust_coefficient * np.append(axis, airframe.arm_length * np.cross(arm, axis) + drag))
    return np.array(columns).T


def resting_input(airframe: Airframe, roll: float, pitch: float) -> np.ndarray:
    """Squared rotor speeds, Hz^2, shape (6,), that carry the vehicle's weight where it leans without moving."""
    # The third row of the rotation matrix: where up is, as the vehicle sees it. Yaw does not matter.
    up_B = np.array([-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)])
    return np.linalg.solve(wrench_by_hand(airframe), np.append(9.81 * airframe.mass * up_B, np.zeros(3)))
