"""Roll-pitch-yaw kinematics, vectorised over leading axes and open to Drake's AutoDiffXd.

Convention everywhere: eta = [roll, pitch, yaw] and R_WB(eta) = Rz(yaw) Ry(pitch) Rx(roll).
"""

import numpy as np

from a2s_drake.arrays import Array


def rotation_matrix(eta: Array) -> Array:
    """R_WB of Euler angles, shape (..., 3, 3).

    Args:
      eta: roll, pitch, yaw in rad, shape (..., 3); float or AutoDiffXd entries.
    """
    cr, cp, cy = np.moveaxis(np.cos(eta), -1, 0)
    sr, sp, sy = np.moveaxis(np.sin(eta), -1, 0)
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def skew(vector: Array) -> Array:
    """The cross-product matrix [a]_x with [a]_x b = a x b; shape (..., 3) to (..., 3, 3)."""
    a, b, c = np.moveaxis(vector, -1, 0)
    zero = np.zeros_like(a)
    rows = [[zero, -c, b], [c, zero, -a], [-b, a, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
