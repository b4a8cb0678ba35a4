import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RollPitchYaw

from a2s_drake.common.rotations import rotation_matrix, skew

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
