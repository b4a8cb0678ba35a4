"""Attitude over time as a uniform cubic B-spline."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.sparse import csr_matrix

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.rotations import body_rates

# A cubic spline is shaped, on each interval between two knots, by this many control points.
SUPPORT = 4

_BUMP = BSpline.basis_element(np.arange(SUPPORT + 1.0), extrapolate=False)


@dataclass(frozen=True)
class SplineGrid:
    """Equal intervals over [0, duration]; interval i is shaped by control points i..i+3.

    The knots run on beyond both ends at the same spacing, so that every interval has the same four weights and every
    control point weighs the same. (A spline clamped at its ends differs only in its parametrisation.)
    """

    duration: float
    intervals: int

    @classmethod
    def of(cls, duration: float, spacing: float) -> "SplineGrid":
        """Intervals of at most `spacing` (s), at least four of them."""
        return cls(duration, max(SUPPORT, int(np.ceil(duration / spacing - 1e-9))))

    @property
    def spacing(self) -> float:
        """Length of an interval, s."""
        return self.duration / self.intervals

    @property
    def controls(self) -> int:
        """Number of control points."""
        return self.intervals + SUPPORT - 1

    def locate(self, time: FloatArray) -> tuple[NDArray[np.int64], FloatArray]:
        """Interval that each time in [0, duration] falls into, and how far into it, 0..1; both shape (n,)."""
        place = np.asarray(time, dtype=float) / self.spacing
        interval = np.clip(np.floor(place + 1e-9).astype(np.int64), 0, self.intervals - 1)
        return interval, np.clip(place - interval, 0.0, 1.0)

    def weights(self, inside: FloatArray, order: int) -> FloatArray:
        """What the four control points of an interval weigh in a derivative of the spline, shape (n, 4), 1/s^order."""
        # The bump of control point i+j starts j - 3 intervals after interval i does. Approached from the left at 1.
        from_start = inside[:, np.newaxis] + (SUPPORT - 1.0 - np.arange(SUPPORT))
        return np.nan_to_num(_BUMP.derivative(order)(from_start) if order else _BUMP(from_start)) / self.spacing**order

    def matrix(self, time: FloatArray, order: int = 0) -> csr_matrix:
        """The matrix from control points to a derivative of the spline at times (n,), shape (n, controls)."""
        interval, inside = self.locate(time)
        columns = interval[:, np.newaxis] + np.arange(SUPPORT)
        rows = np.repeat(np.arange(interval.size), SUPPORT)
        shape = (interval.size, self.controls)
        return csr_matrix((self.weights(inside, order).ravel(), (rows, columns.ravel())), shape)

    def bending(self) -> FloatArray:
        """The form that integrates the squared second derivative over one interval, shape (4, 4), 1/s^3."""
        # The second derivative is linear there, so that Gauss' rule with two points is exact.
        second = self.weights(0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0), 2)
        return np.asarray(self.spacing / 2.0 * (second.T @ second))

    def rest(self) -> tuple[NDArray[np.int64], FloatArray]:
        """Level and at rest at 0, at rest at the end, as three rows that a trajectory's control points make zero.

        Returns:
          control points of each row, shape (3, 3), and their weights, (3, 3).
        """
        last = self.controls - 1
        points = np.array([[0, 1, 2], [0, 1, 2], [last - 2, last - 1, last]])
        return points, np.array([[1.0, 4.0, 1.0], [-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]])

    def rest_rows(self) -> FloatArray:
        """The rows of `rest` as a matrix, shape (3, controls)."""
        points, weights = self.rest()
        rows = np.zeros((len(points), self.controls))
        np.put_along_axis(rows, points, weights, axis=1)
        return rows

    def rested(self, control: FloatArray) -> FloatArray:
        """The nearest control points (controls, 3) that are level and at rest at 0 and at rest at the end."""
        rows = self.rest_rows()
        return np.asarray(control - np.linalg.pinv(rows) @ (rows @ control))


@dataclass(frozen=True)
class AttitudeSpline:
    """An attitude over time. Before 0 it stands at its first value and after its duration at its last.

    Attributes:
      duration: s.
      control: roll, pitch, yaw of the control points, rad, shape (intervals + 3, 3).
    """

    duration: float
    control: FloatArray

    @property
    def spacing(self) -> float:
        """Time between knots, s."""
        return self.duration / (len(self.control) - SUPPORT + 1)

    def eta(self, time: FloatArray) -> FloatArray:
        """Roll, pitch, yaw, rad; shape (...) to (..., 3)."""
        return self._evaluate(time, 0)

    def rate(self, time: FloatArray) -> FloatArray:
        """Time derivative of roll, pitch, yaw, rad/s; shape (...) to (..., 3)."""
        return self._evaluate(time, 1)

    def acceleration(self, time: FloatArray) -> FloatArray:
        """Second time derivative of roll, pitch, yaw, rad/s^2; shape (...) to (..., 3). It may jump at both ends."""
        return self._evaluate(time, 2)

    def angular_velocity(self, time: FloatArray) -> FloatArray:
        """Body angular velocity, rad/s, B; shape (...) to (..., 3)."""
        return body_rates(self.eta(time), self.rate(time))

    def _evaluate(self, time: FloatArray, order: int) -> FloatArray:
        time = np.asarray(time, dtype=float)
        knots = self.spacing * np.arange(1.0 - SUPPORT, len(self.control) + 1.0)
        values = BSpline(knots, self.control, SUPPORT - 1)(np.clip(time, 0.0, self.duration), order)
        if order:
            values[(time < 0.0) | (time > self.duration)] = 0.0
        return np.asarray(values)
