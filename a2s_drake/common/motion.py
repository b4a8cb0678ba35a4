"""Motion: where a point is over time, how fast it moves and how it accelerates; any Drake trajectory makes one."""

from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np
from pydrake.trajectories import PiecewisePolynomial, Trajectory

from a2s_drake.common.arrays import FloatArray


@runtime_checkable
class Motion(Protocol):
    """A point that moves in W. It stands still before its first instant and after `end`.

    Each method takes times of shape (...), s, and returns shape (..., 3). At the first instant and at `end`, velocity
    and acceleration are those of the moving side.
    """

    @property
    def end(self) -> float:
        """The instant from which on the point stands still, s."""

    def position(self, time: FloatArray) -> FloatArray:
        """Position, m."""

    def velocity(self, time: FloatArray) -> FloatArray:
        """Velocity, m/s."""

    def acceleration(self, time: FloatArray) -> FloatArray:
        """Acceleration, m/s^2."""


def is_moving(time: FloatArray, start: float, end: float) -> FloatArray:
    """1 from the first instant to the last, ends included, and 0 before and after; shape (...) to (..., 1)."""
    time = np.asarray(time)
    return ((time >= start) & (time <= end)).astype(float)[..., np.newaxis]


class TrajectoryMotion:
    """The motion of a Drake `Trajectory` of positions in W, m, with one column of three rows.

    Raises:
      ValueError: for a trajectory of another shape.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        shape = (trajectory.rows(), trajectory.cols())
        if shape != (3, 1):
            raise ValueError(f"a trajectory of positions must have 3 rows and 1 column, has {shape[0]} and {shape[1]}")
        self._positions = trajectory
        self._start, self._end = trajectory.start_time(), trajectory.end_time()

    @property
    def end(self) -> float:
        """The trajectory's last instant, s."""
        return self._end

    @cached_property
    def _velocities(self) -> Trajectory:
        return self._positions.MakeDerivative(1)

    @cached_property
    def _accelerations(self) -> Trajectory:
        return self._positions.MakeDerivative(2)

    def position(self, time: FloatArray) -> FloatArray:
        """Position, m, W; shape (...) to (..., 3)."""
        return self._values(self._positions, time)

    def velocity(self, time: FloatArray) -> FloatArray:
        """Velocity, m/s, W; shape (...) to (..., 3)."""
        return self._values(self._velocities, time) * is_moving(time, self._start, self._end)

    def acceleration(self, time: FloatArray) -> FloatArray:
        """Acceleration, m/s^2, W; shape (...) to (..., 3)."""
        return self._values(self._accelerations, time) * is_moving(time, self._start, self._end)

    def _values(self, trajectory: Trajectory, time: FloatArray) -> FloatArray:
        inside = np.clip(np.asarray(time, dtype=float), self._start, self._end)
        return np.array(trajectory.vector_values(inside.ravel())).T.reshape(*inside.shape, 3)


def as_motion(motion: Motion | Trajectory) -> Motion:
    """A motion as it is, or the motion of a trajectory.

    Raises:
      TypeError: for anything else.
    """
    if isinstance(motion, Trajectory):
        return TrajectoryMotion(motion)
    if not isinstance(motion, Motion):
        kind = type(motion).__name__
        raise TypeError(f"where something goes must be a mission, a Motion or a Drake Trajectory, is a {kind}")
    return motion


def through_points(time: FloatArray, position: FloatArray) -> PiecewisePolynomial:
    """The trajectory through points: a cubic spline whose acceleration has no jumps.

    Two points give a straight line and three a parabola, since a cubic needs four.

    Args:
      time: instants that increase, s, shape (n,), n at least 2.
      position: m, W, shape (n, 3).
    """
    if len(time) == 2:
        return PiecewisePolynomial.FirstOrderHold(time, position.T)
    return PiecewisePolynomial.CubicWithContinuousSecondDerivatives(time, position.T)
