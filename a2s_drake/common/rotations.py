"""Roll-pitch-yaw kinematics, vectorised over leading axes and open to Drake's AutoDiffXd.

Convention everywhere: eta = [roll, pitch, yaw] and R_WB(eta) = Rz(yaw) Ry(pitch) Rx(roll). The Euler axes E(eta) are
the axes about which roll, pitch and yaw turn the body, as columns: omega = E(eta) d(eta)/dt, in B.

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


def apply(matrix: Array, vector: Array) -> Array:
    """Matrix times vector, over leading axes: shapes (..., m, n) and (..., n) to (..., m)."""
    return (matrix @ vector[..., np.newaxis])[..., 0]


def euler_axes(eta: Array) -> Array:
    """The Euler axes E(eta) in B, as columns, shape (..., 3, 3): the matrix from d(eta)/dt to omega."""
    cr, sr, cp, sp = _trigonometry(eta)
    axes = _zeros(eta)
    axes[..., 0, 0], axes[..., 0, 2] = 1.0, -sp
    axes[..., 1, 1], axes[..., 1, 2] = cr, sr * cp
    axes[..., 2, 1], axes[..., 2, 2] = -sr, cr * cp
    return axes


def world_euler_axes(eta: Array, R_WB: Array) -> Array:
    """The Euler axes in W, as columns, shape (..., 3, 3); R_WB is `rotation_matrix(eta)`.

    Yaw turns the pitch axis, and both turn the roll axis.
    """
    axes = _zeros(eta)
    axes[..., 0] = R_WB[..., 0]
    axes[..., 0, 1], axes[..., 1, 1] = -np.sin(eta[..., 2]), np.cos(eta[..., 2])
    axes[..., 2, 2] = 1.0
    return axes


def body_rates(eta: Array, rate: Array) -> Array:
    """Body angular velocity omega, rad/s, B, of Euler angles (rad) that change at a rate (rad/s); shapes (..., 3)."""
    return apply(euler_axes(eta), rate)


def euler_axes_slope(eta: Array, vector: Array) -> Array:
    """Derivative of `euler_axes(eta) vector` by eta, shape (..., 3, 3); linear in the vector."""
    cr, sr, cp, sp = _trigonometry(eta)
    pitch, yaw = vector[..., 1], vector[..., 2]
    slope = _zeros(eta)
    slope[..., 0, 1] = -cp * yaw
    slope[..., 1, 0], slope[..., 1, 1] = cr * cp * yaw - sr * pitch, -sr * sp * yaw
    slope[..., 2, 0], slope[..., 2, 1] = -cr * pitch - sr * cp * yaw, -cr * sp * yaw
    return slope


def euler_axes_rate(eta: Array, rate: Array) -> Array:
    """Time derivative of `euler_axes(eta)` while eta moves at a rate, shape (..., 3, 3)."""
    cr, sr, cp, sp = _trigonometry(eta)
    roll, pitch = rate[..., 0], rate[..., 1]
    turning = _zeros(eta)
    turning[..., 0, 2] = -cp * pitch
    turning[..., 1, 1], turning[..., 1, 2] = -sr * roll, cr * cp * roll - sr * sp * pitch
    turning[..., 2, 1], turning[..., 2, 2] = -cr * roll, -sr * cp * roll - cr * sp * pitch
    return turning


def euler_axes_curvature(eta: Array, rate: Array) -> Array:
    """Derivative of `euler_axes_slope(eta, rate) rate` by eta, shape (..., 3, 3)."""
    cr, sr, cp, sp = _trigonometry(eta)
    roll, pitch, yaw = rate[..., 0], rate[..., 1], rate[..., 2]
    curvature = _zeros(eta)
    curvature[..., 0, 1] = sp * pitch * yaw
    curvature[..., 1, 0] = -cr * pitch * roll - (sr * cp * roll + cr * sp * pitch) * yaw
    curvature[..., 1, 1] = -(cr * sp * roll + sr * cp * pitch) * yaw
    curvature[..., 2, 0] = sr * pitch * roll + (sr * sp * pitch - cr * cp * roll) * yaw
    curvature[..., 2, 1] = (sr * sp * roll - cr * cp * pitch) * yaw
    return curvature


def inverse_euler_axes(eta: Array) -> Array:
    """The matrix from omega to d(eta)/dt, shape (..., 3, 3); singular at pitch +-90 deg."""
    sr, cr = np.sin(eta[..., 0]), np.cos(eta[..., 0])
    cp, tp = np.cos(eta[..., 1]), np.tan(eta[..., 1])
    matrix = _zeros(eta)
    matrix[..., 0, 0] = 1.0
    matrix[..., 0, 1], matrix[..., 0, 2] = sr * tp, cr * tp
    matrix[..., 1, 1], matrix[..., 1, 2] = cr, -sr
    matrix[..., 2, 1], matrix[..., 2, 2] = sr / cp, cr / cp
    return matrix


def inverse_euler_axes_slope(eta: Array, omega: Array) -> Array:
    """Derivative of `inverse_euler_axes(eta) omega` by eta, shape (..., 3, 3); the yaw column is zero."""
    sr, cr = np.sin(eta[..., 0]), np.cos(eta[..., 0])
    cp, tp = np.cos(eta[..., 1]), np.tan(eta[..., 1])
    along = sr * omega[..., 1] + cr * omega[..., 2]
    across = cr * omega[..., 1] - sr * omega[..., 2]
    slope = _zeros(eta)
    slope[..., 0, 0], slope[..., 0, 1] = across * tp, along / cp**2
    slope[..., 1, 0] = -along
    slope[..., 2, 0], slope[..., 2, 1] = across / cp, along * tp / cp
    return slope


def _zeros(eta: Array) -> Array:
    """A zero matrix for each attitude, of floats or, for AutoDiffXd, of objects; shape (..., 3, 3)."""
    return np.zeros((*eta.shape, 3), dtype=object if eta.dtype == object else float)


def _trigonometry(eta: Array) -> tuple[Array, Array, Array, Array]:
    """cos(roll), sin(roll), cos(pitch), sin(pitch)."""
    roll, pitch = eta[..., 0], eta[..., 1]
    return np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch)
