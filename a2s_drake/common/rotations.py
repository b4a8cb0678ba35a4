"""Roll-pitch-yaw kinematics, vectorised over leading axes and open to Drake's AutoDiffXd.

Convention everywhere: eta = [roll, pitch, yaw] and R_WB(eta) = Rz(yaw) Ry(pitch) Rx(roll).

Matrices are filled entry by entry: on the short batches of a controller, stacking them costs several times as much.
"""

import numpy as np

from a2s_drake.common.arrays import Array


def rotation_matrix(eta: Array) -> Array:
    """R_WB of Euler angles, shape (..., 3, 3).

    Args:
      eta: roll, pitch, yaw in rad, shape (..., 3); float or AutoDiffXd entries.
    """
    cosine, sine = np.cos(eta), np.sin(eta)
    cr, cp, cy = cosine[..., 0], cosine[..., 1], cosine[..., 2]
    sr, sp, sy = sine[..., 0], sine[..., 1], sine[..., 2]
    cy_sp, sy_sp = cy * sp, sy * sp
    R_WB = np.empty((*eta.shape, 3), dtype=cosine.dtype)
    R_WB[..., 0, 0], R_WB[..., 0, 1], R_WB[..., 0, 2] = cy * cp, cy_sp * sr - sy * cr, cy_sp * cr + sy * sr
    R_WB[..., 1, 0], R_WB[..., 1, 1], R_WB[..., 1, 2] = sy * cp, sy_sp * sr + cy * cr, sy_sp * cr - cy * sr
    R_WB[..., 2, 0], R_WB[..., 2, 1], R_WB[..., 2, 2] = -sp, cp * sr, cp * cr
    return R_WB


def skew(vector: Array) -> Array:
    """The cross-product matrix [a]_x with [a]_x b = a x b; shape (..., 3) to (..., 3, 3)."""
    matrix = np.zeros((*vector.shape, 3), dtype=vector.dtype)
    matrix[..., 2, 1], matrix[..., 0, 2], matrix[..., 1, 0] = vector[..., 0], vector[..., 1], vector[..., 2]
    return matrix - np.swapaxes(matrix, -1, -2)
