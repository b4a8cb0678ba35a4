"""The channel gain and its derivatives by the path lengths, which the planner climbs."""

import numpy as np
import pytest
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff

from a2s_drake import Link
from a2s_drake.link.throughput import gain_percent
from a2s_drake.link.two_ray import GainModel, channel_gain, gain_model, unit_gain

# A long wave over a short path, so that every term of the derivatives weighs.
LINK = Link(carrier_hz=30e6)
STEP = 1e-5  # of the finite differences, m


@pytest.fixture
def lengths(rng: np.random.Generator) -> np.ndarray:
    """Path lengths (2, n), m, up to two fringes apart."""
    d_los = rng.uniform(1.0, 10.0, 50)
    return np.array([d_los, d_los + rng.uniform(0.1, 20.0, 50)])


def moved(lengths: np.ndarray, which: int) -> tuple[GainModel, GainModel]:
    step = STEP * np.eye(2)[which][:, np.newaxis]
    return gain_model(*(lengths + step), LINK), gain_model(*(lengths - step), LINK)


def test_value_is_the_channel_gain(lengths: np.ndarray) -> None:
    gain = unit_gain(LINK) * gain_model(*lengths, LINK).q
    np.testing.assert_allclose(gain, channel_gain(*lengths, LINK), rtol=1e-11)


def test_slopes_are_those_of_the_channel_gain(lengths: np.ndarray) -> None:
    dut = gain_model(*lengths, LINK)
    for column in range(lengths.shape[1]):
        d_los, d_ref = InitializeAutoDiff(lengths[:, column]).ravel()
        slopes = ExtractGradient(np.array([channel_gain(d_los, d_ref, LINK)])).ravel() / unit_gain(LINK)
        np.testing.assert_allclose([dut.by_los[column], dut.by_ref[column]], slopes, rtol=1e-9, atol=1e-12)


def test_curvatures_are_the_slopes_of_the_slopes(lengths: np.ndarray) -> None:
    dut = gain_model(*lengths, LINK)
    (after, before), (later, earlier) = moved(lengths, 0), moved(lengths, 1)
    for found, last, first in (
        (dut.by_los_los, after.by_los, before.by_los),
        (dut.by_los_ref, later.by_los, earlier.by_los),
        (dut.by_los_ref, after.by_ref, before.by_ref),
        (dut.by_ref_ref, later.by_ref, earlier.by_ref),
    ):
        np.testing.assert_allclose(found, (last - first) / (2.0 * STEP), rtol=1e-6, atol=1e-8)


def test_a_gain_is_in_percent_of_the_baseline() -> None:
    assert gain_percent(3.0, 2.0) == pytest.approx(50.0)
    assert gain_percent(1.0, 2.0) == pytest.approx(-50.0)
