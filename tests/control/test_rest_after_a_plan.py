"""After its end a plan is rest: the spline, and all that is previewed of it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from a2s_drake import Scenario
from a2s_drake.guidance.plan.block import PlannedReference
from a2s_drake.guidance.plan.spline import AttitudeSpline
from tests.support.geometry import resting_input

END, PERIOD = 2.0, 0.02


def restless(seed: int = 0, duration: float = END) -> AttitudeSpline:
    """A spline that is still moving, and gathering speed, where it ends and where it begins."""
    return AttitudeSpline(duration, np.random.default_rng(seed).uniform(-0.25, 0.25, (13, 3)))


@settings(max_examples=30)
@given(st.integers(0, 99), st.floats(0.5, 100.0), st.floats(1e-6, 1e6))
def test_a_spline_stands_still_beyond_both_ends(seed: int, duration: float, past: float) -> None:
    dut = restless(seed, duration)
    assert np.abs(dut.rate(np.array([0.0, duration]))).min(axis=1).all()  # in motion at the ends themselves
    for end, time in ((0.0, -past), (duration, duration + past)):
        np.testing.assert_array_equal(dut.eta(np.array(time)), dut.eta(np.array(end)))
        for derivative in (dut.rate, dut.acceleration, dut.angular_velocity):
            assert derivative(np.array(end)).any()
            np.testing.assert_array_equal(derivative(np.array(time)), 0.0)
            np.testing.assert_array_equal(derivative(np.array([end, time]))[1], 0.0)


def previews(time: float, spline: AttitudeSpline) -> dict[str, np.ndarray]:
    scenario = Scenario()
    mission = replace(scenario.mission, duration=END, radius=0.05)
    dut = PlannedReference(spline, scenario.airframe, mission, scenario.mpc)
    context = dut.CreateDefaultContext()
    context.SetTime(time)
    names = ("attitude_preview", "velocity_preview", "angular_velocity_preview", "rotor_speed_squared_preview")
    return {name: dut.GetOutputPort(name).Eval(context) for name in names}


@pytest.mark.parametrize("time", [END - 0.31, END + 1e-3, END + 100.0])
def test_what_is_previewed_of_instants_after_the_end_is_rest(time: float) -> None:
    spline, airframe = restless(), Scenario().airframe
    served, last = previews(time, spline), spline.eta(np.array(END))
    after = time + PERIOD * np.arange(31) > END
    assert after.sum() >= 15
    np.testing.assert_array_equal(served["attitude_preview"].reshape(-1, 3)[after], np.tile(last, (after.sum(), 1)))
    np.testing.assert_allclose(served["velocity_preview"].reshape(-1, 3)[after], 0.0, atol=1e-12)
    np.testing.assert_array_equal(served["angular_velocity_preview"].reshape(-1, 3)[after], 0.0)
    inputs = served["rotor_speed_squared_preview"].reshape(-1, 6)[time + PERIOD * (np.arange(30) + 0.5) > END]
    np.testing.assert_allclose(inputs, np.tile(resting_input(airframe, *last[:2]), (len(inputs), 1)), atol=1e-6)


def test_what_is_previewed_of_instants_before_the_end_is_not() -> None:
    time, spline = END - 0.31, restless()
    served = previews(time, spline)
    before = time + PERIOD * np.arange(31) < END
    assert before.sum() == 16
    for name in ("velocity_preview", "angular_velocity_preview"):
        assert np.abs(served[name].reshape(-1, 3)[before][:, :2]).max(axis=1).min() > 1e-4
    inputs = served["rotor_speed_squared_preview"].reshape(-1, 6)[time + PERIOD * (np.arange(30) + 0.5) < END]
    resting = resting_input(Scenario().airframe, *spline.eta(np.array(END))[:2])
    assert np.abs(inputs - resting).max(axis=1).min() > 1.0
