"""At which attitudes the vehicle can rest: where no rotor turns too slowly, and none too fast."""

import numpy as np
import pytest

from a2s_drake import Airframe
from a2s_drake.study.ceiling import is_hoverable
from tests.support.geometry import resting_input


@pytest.mark.parametrize(("slowest", "fastest", "reason"), [(16.0, 1e4, "slow"), (0.0, 100.0, "fast"), (0.0, 70.0, "")])
def test_an_attitude_is_hoverable_within_the_rotors_speeds(slowest: float, fastest: float, reason: str, rng) -> None:
    airframe = Airframe(rotor_speed_min=slowest, rotor_speed_max=fastest)
    eta = rng.uniform(-0.6, 0.6, (500, 3))
    u = np.array([resting_input(airframe, roll, pitch) for roll, pitch, _ in eta])
    slow, fast = (u < slowest**2).any(axis=1), (u > fastest**2).any(axis=1)
    assert (~slow & ~fast).any()
    assert {"slow": slow, "fast": fast & ~slow, "": fast & ~slow}[reason].any()
    np.testing.assert_array_equal(is_hoverable(eta, airframe), ~slow & ~fast)
