"""Ceilings: how much any attitude could win, found on the exact channel rather than on the affine phase.

Nothing here uses the attitude law, so that the law can be measured against it.
"""

from collections.abc import Callable

import numpy as np

from a2s_drake.common.arrays import BoolArray, FloatArray
from a2s_drake.common.rotations import rotation_matrix
from a2s_drake.link.two_ray import antenna_position, channel_gain, path_lengths, phase_difference, spectral_efficiency
from a2s_drake.scenario.parts import GRAVITY, Airframe, Link
from a2s_drake.vehicle.airframe import wrench_map

# Attitudes on each axis of the first grid, and how often the grid around the best one is refined after it.
_COARSE, _REFINEMENTS = 21, 12


def throughput_of(position: FloatArray, eta: FloatArray, ship: FloatArray, link: Link, period: float) -> float:
    """Throughput per hertz of a pose held exactly at every sample, bit/Hz.

    Args:
      position: centre of mass, m, W, shape (n, 3).
      eta: roll, pitch, yaw, rad, shape (n, 3).
      ship: the ship's reference point at sea level, m, W, shape (n, 3).
      period: time between samples, s.
    """
    return float(period * spectral_efficiency(_gain(position, eta, ship, link), link).sum())


def is_hoverable(eta: FloatArray, airframe: Airframe) -> BoolArray:
    """Whether the vehicle can rest at an attitude, every rotor within its speeds; shape (..., 3) to (...)."""
    weight = np.array([0.0, 0.0, airframe.mass * GRAVITY])
    force_B = np.swapaxes(rotation_matrix(eta), -1, -2) @ weight
    squared_speed = force_B @ np.linalg.inv(wrench_map(airframe))[:, :3].T
    low, high = airframe.rotor_speed_min**2, airframe.rotor_speed_max**2
    return np.asarray(((squared_speed >= low) & (squared_speed <= high)).all(axis=-1))


def best_attitude(
    position: FloatArray,
    ship: FloatArray,
    link: Link,
    attitude_limit: float,
    allowed: Callable[[FloatArray], BoolArray] | None = None,
) -> FloatArray:
    """The attitude of largest |g|^2 in the box, by a grid over the whole box and refinement around its best point.

    Args:
      position: centre of mass, m, W, shape (n, 3).
      ship: the ship's reference point at sea level, m, W, shape (n, 3).
      attitude_limit: half-width of the box, rad.
      allowed: which attitudes (..., 3) may be chosen; all of them without it.
    Returns:
      roll, pitch, yaw, rad, shape (n, 3).
    """
    axis = np.linspace(-attitude_limit, attitude_limit, _COARSE)
    grid = _product(axis)
    if allowed is not None:
        grid = grid[allowed(grid)]
    offsets = rotation_matrix(grid) @ np.asarray(link.antenna_offset)
    best = np.empty_like(position)
    for row, (here, there) in enumerate(zip(position, ship, strict=True)):
        best[row] = grid[np.argmax(channel_gain(*path_lengths(here + offsets, there, link), link))]

    step, star = axis[1] - axis[0], _product(np.array([-1.0, -0.5, 0.0, 0.5, 1.0]))
    for _ in range(_REFINEMENTS):
        around = np.clip(best[:, np.newaxis] + step * star, -attitude_limit, attitude_limit)
        gain = _gain(position[:, np.newaxis], around, ship[:, np.newaxis], link)
        if allowed is not None:
            gain = np.where(allowed(around), gain, -1.0)
        best = np.take_along_axis(around, gain.argmax(axis=1)[:, np.newaxis, np.newaxis], axis=1)[:, 0]
        # Less than half, because along the edge of an odd-shaped region the best point can wander between levels.
        step *= 0.7
    return best


def best_hoverable_attitude(
    position: FloatArray, ship: FloatArray, link: Link, attitude_limit: float, airframe: Airframe
) -> FloatArray:
    """`best_attitude` among those at which the vehicle can rest, rad, shape (n, 3)."""
    return best_attitude(position, ship, link, attitude_limit, lambda eta: is_hoverable(eta, airframe))


def affine_phase_error(
    position: FloatArray,
    ship: FloatArray,
    link: Link,
    attitude_limit: float,
    affine: Callable[[FloatArray], FloatArray],
) -> FloatArray:
    """Exact phase minus an affine model of it, at the corners, edges and faces of the box, rad, shape (n, 26).

    Args:
      affine: the model, from attitudes (n, 26, 3) to phases (n, 26), rad.
    """
    shell = _product(np.array([-1.0, 0.0, 1.0]))
    eta = attitude_limit * shell[np.abs(shell).any(axis=1)]
    eta = np.broadcast_to(eta, (len(position), *eta.shape))
    antenna = antenna_position(position[:, np.newaxis], eta, link)
    exact = phase_difference(*path_lengths(antenna, ship[:, np.newaxis], link), link)
    return np.asarray(exact - affine(eta))


def _gain(position: FloatArray, eta: FloatArray, ship: FloatArray, link: Link) -> FloatArray:
    return np.asarray(channel_gain(*path_lengths(antenna_position(position, eta, link), ship, link), link))


def _product(axis: FloatArray) -> FloatArray:
    """All triples of values on an axis, shape (len(axis)^3, 3)."""
    return np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
