"""Spectral efficiency of the exact two-ray channel and its derivatives by the attitude, in closed form."""

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.rotations import rotation_matrix, world_euler_axes
from a2s_drake.link.two_ray import ship_antenna_and_image
from a2s_drake.scenario.parts import Link


def antenna_derivatives(eta: FloatArray, link: Link) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The antenna's offset R(eta) r_a, m, W, shape (n, 3), and its derivatives, (n, 3 angles, 3) and (n, 3, 3, 3)."""
    R_WB = rotation_matrix(eta)
    offset = R_WB @ np.asarray(link.antenna_offset)
    axes = np.swapaxes(world_euler_axes(eta, R_WB), -1, -2)
    first = np.cross(axes, offset[:, np.newaxis])
    second = np.empty((len(eta), 3, 3, 3))
    for i in range(3):
        for j in range(i + 1):
            second[:, i, j] = second[:, j, i] = np.cross(axes[:, i], first[:, j])
    return offset, first, second


def efficiency_derivatives(
    position: FloatArray, ship: FloatArray, eta: FloatArray, link: Link
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """log2(1 + SNR), bit/s/Hz, (n,), its gradient (n, 3) and Hessian (n, 3, 3) by roll, pitch, yaw (rad).

    Args:
      position: centre of mass, m, W, shape (n, 3).
      ship: the ship's reference point at sea level, m, W, shape (n, 3).
      eta: roll, pitch, yaw, rad, shape (n, 3).
    """
    offset, first, second = antenna_derivatives(eta, link)
    lengths, slopes, curvatures = [], [], []
    for target in ship_antenna_and_image(ship, link):
        ray = target - position - offset
        length = np.sqrt((ray * ray).sum(axis=-1))
        unit = ray / length[:, np.newaxis]
        slope = -np.einsum("nid,nd->ni", first, unit)
        bend = np.einsum("nid,njd->nij", first, first) - slope[:, :, np.newaxis] * slope[:, np.newaxis]
        lengths.append(length)
        slopes.append(slope)
        curvatures.append(bend / length[:, np.newaxis, np.newaxis] - np.einsum("nijd,nd->nij", second, unit))

    (d_los, d_ref), gamma, wave = lengths, link.reflection_magnitude, 2.0 * np.pi / link.wavelength
    phase = wave * (d_ref - d_los)
    cross = 2.0 * gamma / (d_los * d_ref)
    even, odd = cross * np.cos(phase), cross * wave * np.sin(phase)
    # q = 1/d_los^2 + gamma^2/d_ref^2 - 2 gamma cos(phase)/(d_los d_ref), that is |g|^2 (4 pi/lambda)^2.
    q = 1.0 / d_los**2 + (gamma / d_ref) ** 2 - even
    q_by = (-2.0 / d_los**3 + even / d_los - odd, -2.0 * gamma**2 / d_ref**3 + even / d_ref + odd)
    q_by_los_los = 6.0 / d_los**4 - 2.0 * even / d_los**2 + 2.0 * odd / d_los + wave**2 * even
    q_by_ref_ref = 6.0 * gamma**2 / d_ref**4 - 2.0 * even / d_ref**2 - 2.0 * odd / d_ref + wave**2 * even
    q_by_los_ref = -even / (d_los * d_ref) - odd / d_los + odd / d_ref - wave**2 * even

    gradient = _scaled(q_by[0], slopes[0]) + _scaled(q_by[1], slopes[1])
    mixed = slopes[0][:, :, np.newaxis] * slopes[1][:, np.newaxis]
    hessian = _scaled(q_by[0], curvatures[0]) + _scaled(q_by[1], curvatures[1])
    hessian += _scaled(q_by_los_ref, mixed + np.swapaxes(mixed, 1, 2))
    for by, slope in ((q_by_los_los, slopes[0]), (q_by_ref_ref, slopes[1])):
        hessian += _scaled(by, slope[:, :, np.newaxis] * slope[:, np.newaxis])

    snr_per_q = link.transmit_to_noise * (link.wavelength / (4.0 * np.pi)) ** 2
    gain = snr_per_q / (1.0 + snr_per_q * q)
    squared = gradient[:, :, np.newaxis] * gradient[:, np.newaxis]
    hessian = _scaled(gain, hessian) - _scaled(gain**2, squared)
    return np.log2(1.0 + snr_per_q * q), _scaled(gain, gradient) / np.log(2.0), hessian / np.log(2.0)


def _scaled(factor: FloatArray, array: FloatArray) -> FloatArray:
    return factor.reshape(-1, *[1] * (array.ndim - 1)) * array
