"""How many intervals a spline's grid has."""

import pytest

from a2s_drake.guidance.plan.spline import SplineGrid


@pytest.mark.parametrize(
    ("duration", "spacing", "intervals"),
    [
        (7.0, 0.3, 24),
        (2.1, 0.3, 7),  # 2.1/0.3 is 7.000000000000001
        (0.7, 0.1, 7),  # and 0.7/0.1 is 6.999999999999999
        (2.1001, 0.3, 8),
        (0.1, 0.1, 4),
        (0.35, 0.1, 4),
        (0.45, 0.1, 5),
    ],
)
def test_intervals_are_as_long_as_they_may_be_and_four_at_least(
    duration: float, spacing: float, intervals: int
) -> None:
    dut = SplineGrid.of(duration, spacing)
    assert dut.intervals == intervals
    assert dut.spacing == pytest.approx(duration / intervals)
    assert dut.controls == intervals + 3
