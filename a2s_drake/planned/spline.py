"""Attitude over time as a uniform cubic B-spline."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from a2s_drake.arrays import FloatArray

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

    def locate(self, time: FloatArray) -> tuple[Any, FloatArray]:
        """Interval that each time in [0, duration] falls into, and how far into it, 0..1; both shape (n,)."""
        place = np.asarray(time, dtype=float) / self.spacing
        interval = np.clip(np.floor(place + 1e-9).astype(int), 0, self.intervals - 1)
        return interval, np.clip(place - interval, 0.0, 1.0)

    def weights(self, inside: FloatArray, order: int) -> FloatArray:
        """What the four control points of an interval weigh in a derivative of the spline, shape (n, 4), 1/s^order."""
        # The bump of control point i+j starts j - 3 intervals after interval i does. Approached from the left at 1.
        from_start = inside[:, np.newaxis] + (SUPPORT - 1.0 - np.arange(SUPPORT))
        return np.nan_to_num(_BUMP.derivative(order)(from_start) if order else _BUMP(from_start)) / self.spacing**order
