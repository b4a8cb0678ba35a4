"""Throughput: gains in percent, and the spectral efficiency with its derivatives by the attitude, in closed form."""

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.rotations import rotation_matrix, world_euler_axes
from a2s_drake.link.two_ray import gain_model, ship_antenna_and_image, unit_gain
from a2s_drake.scenario.parts import Link


def gain_percent(throughput: float, baseline: float) -> float:
    """How much larger a throughput is than a baseline of the same unit, %."""
    return 100.0 * (throughput / baseline - 1.0)


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

    d_los, d_ref = lengths
    model = gain_model(d_los, d_ref, link)
    gradient = _scaled(model.by_los, slopes[0]) + _scaled(model.by_ref, slopes[1])
    mixed = slopes[0][:, :, np.newaxis] * slopes[1][:, np.newaxis]
    hessian = _scaled(model.by_los, curvatures[0]) + _scaled(model.by_ref, curvatures[1])
    hessian += _scaled(model.by_los_ref, mixed + np.swapaxes(mixed, 1, 2))
    for by, slope in ((model.by_los_los, slopes[0]), (model.by_ref_ref, slopes[1])):
        hessian += _scaled(by, slope[:, :, np.newaxis] * slope[:, np.newaxis])

    snr_per_q = link.transmit_to_noise * unit_gain(link)
    gain = snr_per_q / (1.0 + snr_per_q * model.q)
    squared = gradient[:, :, np.newaxis] * gradient[:, np.newaxis]
    hessian = _scaled(gain, hessian) - _scaled(gain**2, squared)
    return np.log2(1.0 + snr_per_q * model.q), _scaled(gain, gradient) / np.log(2.0), hessian / np.log(2.0)


def _scaled(factor: FloatArray, array: FloatArray) -> FloatArray:
    return factor.reshape(-1, *[1] * (array.ndim - 1)) * array
