import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from a2s_drake import Disturbance
from a2s_drake.navigation.sensors import NavigationSensor
from a2s_drake.navigation.ship_report import ShipReport
from a2s_drake.scenario.parts import Knowledge

STATE = np.arange(12.0)


def measured(dut: NavigationSensor, time: float = 0.0) -> np.ndarray:
    context = dut.CreateDefaultContext()
    context.SetTime(time)
    dut.GetInputPort("vehicle_state").FixValue(context, STATE)
    return dut.GetOutputPort("measured_state").Eval(context).copy()


def test_a_sensor_that_knows_everything_tells_the_truth() -> None:
    np.testing.assert_array_equal(measured(NavigationSensor(0.02)), STATE)


vectors = st.lists(st.floats(-90.0, 90.0), min_size=3, max_size=3)


@given(position=vectors, attitude_deg=vectors)
def test_truth_is_what_is_measured_and_the_bias(position: list[float], attitude_deg: list[float]) -> None:
    dut = NavigationSensor(0.02, knowledge=Knowledge(position_bias=position, attitude_bias_deg=attitude_deg))
    bias = np.concatenate([position, np.deg2rad(attitude_deg), np.zeros(6)])
    np.testing.assert_allclose(measured(dut) + bias, STATE, atol=1e-12)


def test_noise_comes_on_top_of_the_bias() -> None:
    noise = Disturbance(position_noise=0.01, noise_seed=3)
    with_noise, without = (
        measured(NavigationSensor(0.02, noise, Knowledge(position_bias=bias))) for bias in ([0.5, 0.0, 0.0], [0.0] * 3)
    )
    np.testing.assert_allclose(without - with_noise, [0.5, *[0.0] * 11], atol=1e-12)


@pytest.mark.parametrize("latency", [0.0, 0.5, 3.0])
def test_a_report_tells_where_the_ship_was_to_be_some_time_ago(latency: float) -> None:
    dut = ShipReport(lambda time: np.stack([time, 2.0 * time, 0.0 * time], axis=-1), 0.02, 30, latency)
    context = dut.CreateDefaultContext()
    context.SetTime(10.0)
    rows = dut.GetOutputPort("ship_preview").Eval(context).reshape(31, 3)
    expected = 10.0 - latency + 0.02 * np.arange(31)
    np.testing.assert_allclose(rows, np.stack([expected, 2.0 * expected, 0.0 * expected], axis=-1), atol=1e-12)
