from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff
from pydrake.math import RollPitchYaw

from a2s_drake.common.rotations import (
    body_rates,
    euler_axes,
    euler_axes_curvature,
    euler_axes_rate,
    euler_axes_slope,
    inverse_euler_axes,
    inverse_euler_axes_slope,
    rotation_matrix,
    skew,
    world_euler_axes,
)

STEP = 1e-6  # of the finite differences, rad

angles = st.lists(st.floats(-np.pi, np.pi), min_size=3, max_size=3)
vectors = st.lists(st.floats(-10.0, 10.0), min_size=3, max_size=3)


@given(angles)
def test_rotation_matrix_is_drakes_roll_pitch_yaw(eta: list[float]) -> None:
    expected = RollPitchYaw(eta).ToRotationMatrix().matrix()
    np.testing.assert_allclose(rotation_matrix(np.array(eta)), expected, atol=1e-14)


def test_rotation_matrix_is_vectorised(rng: np.random.Generator) -> None:
    eta = rng.uniform(-1.0, 1.0, (4, 5, 3))
    dut = rotation_matrix(eta)
    assert dut.shape == (4, 5, 3, 3)
    np.testing.assert_array_equal(dut[2, 3], rotation_matrix(eta[2, 3]))


@given(vectors, vectors)
def test_skew_is_the_cross_product(a: list[float], b: list[float]) -> None:
    np.testing.assert_allclose(skew(np.array(a)) @ b, np.cross(a, b), atol=1e-12)


def changed_by(function: Callable[[np.ndarray], np.ndarray], eta: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Central difference of a function of eta along a direction."""
    return (function(eta + STEP * direction) - function(eta - STEP * direction)) / (2.0 * STEP)


def jacobian(function: Callable[[np.ndarray], np.ndarray], eta: np.ndarray) -> np.ndarray:
    """Central differences of a vector by each entry of eta, as columns."""
    return np.stack([changed_by(function, eta, direction) for direction in np.eye(3)], axis=-1)


@pytest.fixture
def eta(rng: np.random.Generator) -> np.ndarray:
    """Attitudes off the singularity, with leading axes as in the MPC's stages."""
    return rng.uniform(-1.2, 1.2, (2, 4, 3))


def test_euler_axes_are_drakes(eta: np.ndarray, rng: np.random.Generator) -> None:
    rates = rng.normal(size=eta.shape)
    axes, in_world, back = euler_axes(eta), world_euler_axes(eta, rotation_matrix(eta)), inverse_euler_axes(eta)
    for place in np.ndindex(eta.shape[:-1]):
        rpy, rate = RollPitchYaw(eta[place]), rates[place]
        omega_B = rpy.CalcAngularVelocityInChildFromRpyDt(rate)
        np.testing.assert_allclose(axes[place] @ rate, omega_B, atol=1e-14)
        np.testing.assert_allclose(body_rates(eta, rates)[place], omega_B, atol=1e-14)
        np.testing.assert_allclose(in_world[place] @ rate, rpy.CalcAngularVelocityInParentFromRpyDt(rate), atol=1e-14)
        np.testing.assert_allclose(back[place] @ omega_B, rate, atol=1e-13)


def test_slopes_of_the_euler_axes_are_the_differences(eta: np.ndarray, rng: np.random.Generator) -> None:
    vectors = rng.normal(size=eta.shape)
    for place in np.ndindex(eta.shape[:-1]):
        here, vector = eta[place], vectors[place]
        for found, expected in (
            (euler_axes_slope(eta, vectors), jacobian(lambda e, v=vector: euler_axes(e) @ v, here)),
            (inverse_euler_axes_slope(eta, vectors), jacobian(lambda e, v=vector: inverse_euler_axes(e) @ v, here)),
            (euler_axes_rate(eta, vectors), changed_by(euler_axes, here, vector)),
            (euler_axes_curvature(eta, vectors), jacobian(lambda e, v=vector: euler_axes_slope(e, v) @ v, here)),
        ):
            np.testing.assert_allclose(found[place], expected, atol=1e-7)


def test_euler_axes_differentiate() -> None:
    eta = np.array([0.3, -0.4, 0.5])
    taped = InitializeAutoDiff(eta).ravel()
    for function, slope in ((euler_axes, euler_axes_slope), (inverse_euler_axes, inverse_euler_axes_slope)):
        vector = np.array([0.2, -0.7, 0.4])
        np.testing.assert_allclose(ExtractGradient(function(taped) @ vector), slope(eta, vector), atol=1e-14)
