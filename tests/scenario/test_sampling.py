"""How many samples a duration holds, however it was rounded, and how many one flight may have."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from a2s_drake import Scenario, ScenarioError
from a2s_drake.scenario.scenario import _MAX_SAMPLES

PERIODS = [0.02, 0.01, 0.005, 0.001, 0.0001, 0.03, 0.025, 0.05, 0.1, 0.3, 0.7, 10.0]


def scenario(**values: float) -> Scenario:
    return Scenario().with_overrides([f"{name.replace('__', '.')}={value!r}" for name, value in values.items()])


def test_a_multiple_of_the_period_that_is_rounded_down_keeps_its_last_sample() -> None:
    assert 0.58 / 0.02 < 29.0
    times = scenario(simulation__duration=0.58).sample_times()
    assert len(times) == 30
    assert times[-1] == pytest.approx(0.58)


@pytest.mark.parametrize("period", PERIODS)
def test_a_duration_of_k_periods_has_k_samples_and_one(period: float) -> None:
    dut = scenario(mpc__period=period)
    for k in range(1, 5001):
        as_product, as_typed = k * period, float(f"{k * period:.12g}")
        assert len(dut.samples_until(as_product)) == len(dut.samples_until(as_typed)) == k + 1


@given(st.sampled_from(PERIODS), st.integers(1, 5000), st.floats(1e-6, 0.999999))
def test_a_duration_short_of_a_multiple_is_not_rounded_up(period: float, k: int, short: float) -> None:
    dut = Scenario()
    dut.mpc.period = period
    times = dut.samples_until((k - short) * period)
    assert len(times) == k
    np.testing.assert_allclose(times, period * np.arange(k))
    assert times[-1] <= (k - short) * period


# Level, so that nothing but the number of samples is checked of the mission; and none of them is made.
LONG = ["attitude_law.name=level", "mpc.period=0.001"]


@pytest.mark.parametrize("field", ["simulation.duration", "mission.duration"])
def test_a_flight_or_a_mission_has_ten_million_samples_at_most(field: str) -> None:
    assert _MAX_SAMPLES == 10_000_000
    other = "simulation.duration=1" if field == "mission.duration" else "mission.duration=40"
    longest = Scenario().with_overrides([*LONG, other, f"{field}=9999.999"])
    longest.validate()
    for duration in (10_000.0, 10_000.5, 86_400.0):
        with pytest.raises(ScenarioError, match=r"mpc\.period = 0\.001: must give at most 10000000 samples"):
            longest.with_value(field, duration).validate()


def test_a_flight_may_be_a_single_period_long() -> None:
    assert len(scenario(simulation__duration=0.02).validate().sample_times()) == 2
    with pytest.raises(ScenarioError, match=r"simulation\.duration = 0\.0199"):
        scenario(simulation__duration=0.0199).validate()
    with pytest.raises(ScenarioError, match=r"mission\.duration = 0\.01"):
        scenario(mission__duration=0.01, mission__radius=0.0).validate()
