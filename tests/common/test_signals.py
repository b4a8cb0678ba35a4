"""The vehicle's state by name."""

import numpy as np
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff

from a2s_drake.common.signals import State, by_part

# [p, eta, v, omega], as docs/blocks.md writes it down: the numbers say where each entry stands.
STATE = np.arange(12.0)


def test_each_part_is_where_the_ports_have_it() -> None:
    dut = State(STATE)
    np.testing.assert_array_equal(dut.position, [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(dut.attitude, [3.0, 4.0, 5.0])
    np.testing.assert_array_equal(dut.velocity, [6.0, 7.0, 8.0])
    np.testing.assert_array_equal(dut.angular_velocity, [9.0, 10.0, 11.0])
    np.testing.assert_array_equal(np.concatenate(dut.parts), STATE)


def test_parts_are_views_over_leading_axes() -> None:
    array = np.zeros((4, 5, 12))
    dut = State(array)
    dut.velocity[2, 3] = [1.0, 2.0, 3.0]
    assert dut.velocity.shape == (4, 5, 3)
    np.testing.assert_array_equal(array[2, 3, 6:9], [1.0, 2.0, 3.0])
    assert np.count_nonzero(array) == 3


def test_a_state_is_made_of_its_parts() -> None:
    parts = [np.full((2, 3), float(i)) for i in range(4)]
    dut = State.of(position=parts[0], attitude=parts[1], velocity=parts[2], angular_velocity=parts[3])
    np.testing.assert_array_equal(dut.array, np.repeat([[0.0, 1.0, 2.0, 3.0]] * 2, 3, axis=1))


def test_parts_of_taped_numbers_keep_their_derivatives() -> None:
    dut = State(InitializeAutoDiff(STATE).ravel())
    np.testing.assert_array_equal(ExtractGradient(dut.attitude), np.eye(12)[3:6])


def test_a_number_for_each_part_stands_at_its_three_entries() -> None:
    dut = State(by_part(position=1.0, attitude=2.0, velocity=3.0, angular_velocity=4.0))
    assert [set(part.tolist()) for part in dut.parts] == [{1.0}, {2.0}, {3.0}, {4.0}]
