import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.trajectories import PiecewisePolynomial

from a2s_drake import Scenario, ShipTrajectory, UavPath
from a2s_drake.common.motion import TrajectoryMotion, as_motion, through_points

TIME = np.array([0.0, 1.0, 2.5, 3.0, 5.0])
# A cubic spline follows one cubic exactly, whatever the spacing of its knots.
CUBIC = np.array([[1.0, -2.0, 0.3], [0.5, 0.0, 1.0], [-0.2, 0.4, 0.0], [0.03, -0.05, 0.01]])


def cubic(time: np.ndarray, derivative: int = 0) -> np.ndarray:
    """The cubic or a derivative of it, by NumPy's polynomials, shape (..., 3)."""
    return np.stack([np.polynomial.Polynomial(row).deriv(derivative)(time) for row in CUBIC.T], axis=-1)


@pytest.fixture
def dut() -> TrajectoryMotion:
    return TrajectoryMotion(through_points(TIME, cubic(TIME)))


def test_position_velocity_and_acceleration_are_those_of_the_points(dut: TrajectoryMotion) -> None:
    time = np.linspace(0.0, 5.0, 41)  # both ends are the moving side's
    np.testing.assert_allclose(dut.position(time), cubic(time), atol=1e-12)
    np.testing.assert_allclose(dut.velocity(time), cubic(time, 1), atol=1e-12)
    np.testing.assert_allclose(dut.acceleration(time), cubic(time, 2), atol=1e-11)
    assert dut.end == 5.0


def test_before_and_after_it_stands_still(dut: TrajectoryMotion) -> None:
    time = np.array([-1.0, -1e-9, 5.0 + 1e-9, 60.0])
    np.testing.assert_allclose(dut.position(time), cubic(np.array([0.0, 0.0, 5.0, 5.0])), atol=1e-12)
    np.testing.assert_array_equal(dut.velocity(time), 0.0)
    np.testing.assert_array_equal(dut.acceleration(time), 0.0)


@pytest.mark.parametrize("shape", [(), (0,), (1,), (7,), (2, 3)])
def test_times_of_any_shape(shape: tuple[int, ...], dut: TrajectoryMotion) -> None:
    time = np.full(shape, 2.0)
    for read, derivative in ((dut.position, 0), (dut.velocity, 1), (dut.acceleration, 2)):
        expected = np.broadcast_to(cubic(np.array(2.0), derivative), (*shape, 3))
        np.testing.assert_allclose(read(time), expected, atol=1e-11)


def test_two_points_make_a_line_and_three_a_parabola() -> None:
    line = TrajectoryMotion(through_points(np.array([0.0, 2.0]), np.array([[0.0, 0.0, 1.0], [2.0, 4.0, 1.0]])))
    np.testing.assert_allclose(line.position(np.array([0.5, 2.0])), [[0.5, 1.0, 1.0], [2.0, 4.0, 1.0]])
    np.testing.assert_allclose(line.velocity(np.array([0.0, 2.0])), [[1.0, 2.0, 0.0]] * 2)
    np.testing.assert_array_equal(line.acceleration(np.array([0.0, 1.0])), 0.0)
    time = np.array([0.0, 1.0, 3.0])
    parabola = TrajectoryMotion(through_points(time, np.outer(time**2, [1.0, -1.0, 0.5])))
    np.testing.assert_allclose(parabola.position(np.array(2.0)), [4.0, -4.0, 2.0], atol=1e-12)
    np.testing.assert_allclose(parabola.acceleration(time), np.outer(np.ones(3), [2.0, -2.0, 1.0]), atol=1e-12)


steps = st.lists(st.floats(0.05, 2.0), min_size=4, max_size=12)


@given(steps, st.randoms(use_true_random=False))
def test_acceleration_has_no_jump_at_a_knot(step: list[float], random) -> None:
    time = np.concatenate([[0.0], np.cumsum(step)])
    points = np.array([[random.uniform(-5.0, 5.0) for _ in range(3)] for _ in time])
    dut = TrajectoryMotion(through_points(time, points))
    np.testing.assert_allclose(dut.position(time), points, atol=1e-9)
    # A cubic's second derivative is a straight line on each side of a knot: what it is there follows from two points.
    near, far = 0.01, 0.02
    for side in (-1.0, 1.0):
        seen = 2.0 * dut.acceleration(time[1:-1] + side * near) - dut.acceleration(time[1:-1] + side * far)
        np.testing.assert_allclose(seen, dut.acceleration(time[1:-1]), rtol=1e-6, atol=1e-6 * np.abs(seen).max())


@given(steps)
def test_velocity_and_acceleration_are_slopes(step: list[float]) -> None:
    time = np.concatenate([[0.0], np.cumsum(step)])
    dut = TrajectoryMotion(through_points(time, np.stack([np.sin(time), np.cos(2.0 * time), time], axis=-1)))
    h, between = 1e-5, (time[1:] + time[:-1]) / 2.0
    slope = (dut.position(between + h) - dut.position(between - h)) / (2.0 * h)
    np.testing.assert_allclose(dut.velocity(between), slope, atol=1e-6)
    slope = (dut.velocity(between + h) - dut.velocity(between - h)) / (2.0 * h)
    np.testing.assert_allclose(dut.acceleration(between), slope, rtol=1e-6, atol=1e-5)


@pytest.mark.parametrize("wrapped", [False, True])
def test_blocks_serve_a_trajectory_of_the_users_own(wrapped: bool, scenario: Scenario) -> None:
    mine = PiecewisePolynomial.FirstOrderHold([2.0, 3.0], np.array([[0.0, 1.0], [2.0, 2.0], [3.0, -3.0]]))
    given_motion = as_motion(mine) if wrapped else mine
    path, ship = UavPath(given_motion, scenario.mpc), ShipTrajectory(given_motion)
    for time in (0.0, 2.25, 2.9, 7.0):
        share = np.clip(time + 0.02 * np.arange(31) - 2.0, 0.0, 1.0)
        expected = np.stack([share, np.full(31, 2.0), 3.0 - 6.0 * share], axis=-1)
        for block, port, rows in (
            (path, "position_preview", expected),
            (path, "position_reference", expected[:1]),
            (ship, "ship_position", expected[:1]),
        ):
            context = block.CreateDefaultContext()
            context.SetTime(time)
            served = block.GetOutputPort(port).Eval(context)
            np.testing.assert_allclose(served.reshape(-1, 3), rows, atol=1e-12, err_msg=port)


@pytest.mark.parametrize(("rows", "columns"), [(2, 1), (3, 2), (1, 3)])
def test_a_trajectory_of_another_shape_is_refused(rows: int, columns: int) -> None:
    mine = PiecewisePolynomial(np.zeros((rows, columns)))
    with pytest.raises(ValueError, match=f"must have 3 rows and 1 column, has {rows} and {columns}"):
        TrajectoryMotion(mine)
