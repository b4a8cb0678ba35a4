"""Which fringe when: a dynamic programme over attitudes that the vehicle can rest at, at a limited rate.

The choice of fringe is combinatorial and everything after it local, so it is made globally, on a grid: exact channel,
hover instead of dynamics, no limit on acceleration.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bmat, csc_matrix, identity
from scipy.sparse.linalg import spsolve

from a2s_drake.common.arrays import BoolArray, FloatArray
from a2s_drake.common.rotations import rotation_matrix
from a2s_drake.guidance.path import uav_path
from a2s_drake.guidance.plan.segment import Task
from a2s_drake.guidance.plan.spline import SplineGrid
from a2s_drake.link.two_ray import channel_gain, path_lengths, spectral_efficiency
from a2s_drake.scenario.checks import refuse
from a2s_drake.world.ship import ship_track

# The search's corners are rounded over about this time, s, before a smooth trajectory is asked to follow them.
_ROUNDING = 0.15

# Most grid steps from level to the largest angle. Where the rate is so limited that it would take more, stages are made
# longer instead.
_FARTHEST = 20

# Most places that a search remembers, over all stages, of 4 bytes each.
_MOST_PLACES = 250_000_000

_UNREACHED = -1e30


@dataclass(frozen=True)
class Caution:
    """How far a search stays from the limits: a share of the rates it uses, and of the rotors' range it leaves."""

    rate_share: float = 1.0
    rotor_reserve: float = 0.0
    # Price of turning, bit/Hz per rad^2/s.
    turning_price: float = 0.02


class AttitudeGrid:
    """The attitudes of a search: a cube of Euler angles around level, at steps that a rate limit makes whole.

    Raises:
      ScenarioError: when the search would remember too much.
    """

    def __init__(self, task: Task, caution: Caution) -> None:
        planning, limits = task.planning, task.limits
        rate = caution.rate_share * limits.rate
        self.reach = planning.search_reach
        wanted = max(planning.search_period, limits.angle / _FARTHEST * self.reach / rate)
        self.stages = max(1, int(np.ceil(task.grid.duration / wanted - 1e-9)))
        self.period = task.grid.duration / self.stages
        # The step that the rate allows, or a finer one: no fewer than eight steps from level to the limit.
        self.step = min(rate * self.period / self.reach, limits.angle / 8.0)
        self.side = int(limits.angle / self.step + 1e-9)
        places = self.stages * (2 * self.side + 1) ** 3
        if places > _MOST_PLACES:
            raise refuse(
                "planning.search_period",
                planning.search_period,
                f"must be at least {planning.search_period * places / _MOST_PLACES:.2g} s on a mission this long",
            )
        axis = self.step * np.arange(-self.side, self.side + 1)
        self.eta = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
        self.level = (self.side,) * 3
        R_WB = rotation_matrix(self.eta)
        self.offset = R_WB @ np.asarray(task.scenario.link.antenna_offset)
        self.restful = self._restful(task, caution)

    def _restful(self, task: Task, caution: Caution) -> BoolArray:
        still = np.concatenate([self.eta, np.zeros((*self.eta.shape[:-1], 6))], axis=-1)
        _, u = task.flat.needs(still, np.zeros(3))
        reserve = caution.rotor_reserve * (task.limits.input_high - task.limits.input_low)
        low, high = task.limits.input_low + reserve, task.limits.input_high - reserve
        restful: BoolArray = np.asarray(((u >= low) & (u <= high)).all(axis=-1))
        # Whoever reserves so much that not even level is left, stays level.
        restful[self.level] = True
        return restful


def search(task: Task, caution: Caution, report: Callable[[int], None] | None = None) -> tuple[FloatArray, FloatArray]:
    """The best path through the grid from level at 0 to anywhere at the end.

    Args:
      report: is told every stage; may raise to end the search.
    Returns:
      times, s, shape (stages + 1,), and attitudes, rad, (stages + 1, 3).
    """
    grid, scenario = AttitudeGrid(task, caution), task.scenario
    time: FloatArray = grid.period * np.arange(grid.stages + 1, dtype=np.float64)
    position, ship = uav_path(scenario.mission).position(time), ship_track(scenario.mission).position(time)
    shape = grid.restful.shape
    allowed = np.flatnonzero(grid.restful)
    offset = grid.offset.reshape(-1, 3)[allowed]
    moves = sorted(range(-grid.reach, grid.reach + 1), key=abs)
    prices = [caution.turning_price * (move * grid.step) ** 2 / grid.period for move in moves]

    value = np.full(shape, _UNREACHED)
    value[grid.level] = 0.0
    came_from = np.empty((grid.stages, value.size), dtype=np.int32)
    for stage in range(1, grid.stages + 1):
        value, origin = _advance(value, moves, prices)
        came_from[stage - 1] = origin.ravel()
        earned = np.full(value.size, _UNREACHED)
        lengths = path_lengths(position[stage] + offset, ship[stage], scenario.link)
        earned[allowed] = grid.period * spectral_efficiency(channel_gain(*lengths, scenario.link), scenario.link)
        value = np.maximum(value + earned.reshape(shape), _UNREACHED)
        if report is not None:
            report(stage)

    place = int(value.argmax())
    places = [place]
    for origin in came_from[::-1]:
        place = int(origin[place])
        places.append(place)
    return time, grid.eta.reshape(-1, 3)[places[::-1]]


def _advance(value: FloatArray, moves: list[int], prices: list[float]) -> tuple[FloatArray, NDArray[np.int32]]:
    """The best value to arrive with at each attitude, and where it came from: one axis after the other.

    Moves on the three axes are independent and their prices add up, so three passes over 2r+1 moves look at all
    (2r+1)^3 of them.
    """
    origin = np.arange(value.size, dtype=np.int32).reshape(value.shape)
    for axis in range(3):
        old, old_origin = np.moveaxis(value, axis, 0), np.moveaxis(origin, axis, 0)
        new, new_origin = old.copy(), old_origin.copy()
        for move, price in zip(moves, prices, strict=True):
            if move == 0:
                continue
            to, start = (slice(move, None), slice(None, -move)) if move > 0 else (slice(None, move), slice(-move, None))
            offer = old[start] - price
            better = offer > new[to]
            new[to][better] = offer[better]
            new_origin[to][better] = old_origin[start][better]
        value, origin = np.moveaxis(new, 0, axis), np.moveaxis(new_origin, 0, axis)
    return value, origin


def rounded(grid: SplineGrid, time: FloatArray, path: FloatArray) -> FloatArray:
    """Control points, (controls, 3), that follow a path smoothly in the sense of least squares, from rest to rest."""
    follow = grid.matrix(time)
    second = grid.matrix(grid.spacing * (np.arange(grid.intervals, dtype=np.float64) + 0.5), 2)
    weight = _ROUNDING**4 * grid.spacing * len(time) / grid.duration
    rest = grid.rest_rows()
    normal = follow.T @ follow + weight * (second.T @ second) + 1e-9 * identity(grid.controls)
    system = bmat([[normal, csc_matrix(rest.T)], [csc_matrix(rest), None]], format="csc")
    aim = np.vstack([follow.T @ path, np.zeros((len(rest), 3))])
    return np.asarray(spsolve(system, aim)[: grid.controls])
