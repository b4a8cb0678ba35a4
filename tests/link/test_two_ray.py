import cmath
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, InitializeAutoDiff

from a2s_drake import Link, Scenario, TwoRayChannel
from a2s_drake.link.two_ray import (
    antenna_position,
    channel_gain,
    path_lengths,
    phase_difference,
    snr,
    spectral_efficiency,
    specular_point,
)

UAV, SHIP = np.zeros(3), np.array([90.0, 0.0, -20.0])
SHIP_ANTENNA = np.array([90.0, 0.0, -10.0])


def gain_by_complex_numbers(d_los: float, d_ref: float, link: Link) -> float:
    """|g|^2 as the paper writes it, eq. 5: the oracle that the code under test cannot use."""
    wavelength = link.speed_of_light / link.carrier_hz
    phase = 2.0 * math.pi / wavelength * (d_ref - d_los)
    reflected = link.reflection_magnitude / d_ref * cmath.exp(-1j * (phase + math.pi))
    return abs(wavelength / (4.0 * math.pi) * (1.0 / d_los + reflected)) ** 2


def test_golden_numbers_at_the_start_of_the_mission() -> None:
    d_los, d_ref = path_lengths(antenna_position(UAV, np.zeros(3), Link()), SHIP, Link())
    assert d_los == pytest.approx(90.188925179, abs=5e-10)
    assert d_ref == pytest.approx(94.561314632, abs=5e-10)
    assert phase_difference(d_los, d_ref, Link()) == pytest.approx(274.915520076, abs=5e-10)
    assert channel_gain(d_los, d_ref, Link()) == pytest.approx(1.199032629e-8, rel=1e-9)


def test_golden_gain_at_the_best_candidate() -> None:
    eta = np.deg2rad([-9.832248, 8.733095, 2.198305])
    gain = channel_gain(*path_lengths(antenna_position(UAV, eta, Link()), SHIP, Link()), Link())
    assert gain == pytest.approx(2.412125015e-8, rel=1e-7)


@given(st.floats(1.0, 1e4), st.floats(0.0, 100.0), st.floats(0.0, 1.0))
def test_gain_is_the_papers_complex_formula(d_los: float, detour: float, reflection: float) -> None:
    link = Link(reflection_magnitude=reflection)
    expected = gain_by_complex_numbers(d_los, d_los + detour, link)
    assert channel_gain(np.array(d_los), np.array(d_los + detour), link) == pytest.approx(expected, rel=1e-9, abs=1e-24)


@given(st.floats(5.0, 200.0), st.floats(10.0, 500.0), st.floats(1.0, 50.0))
def test_level_attitude_recovers_the_static_model(height: float, separation: float, ship_height: float) -> None:
    # Section II-A of the paper: H and h are heights above the sea, L the horizontal distance of the antennas.
    link = Link(ship_antenna_height=ship_height)
    offset = np.asarray(link.antenna_offset)
    uav = np.array([0.0, 0.0, height]) - offset
    d_los, d_ref = path_lengths(antenna_position(uav, np.zeros(3), link), np.array([separation, 0.0, 0.0]), link)
    assert d_los == pytest.approx(math.hypot(separation, height - ship_height))
    assert d_ref == pytest.approx(math.hypot(separation, height + ship_height))


@given(st.floats(-180.0, 180.0))
def test_yaw_about_a_vertical_antenna_changes_nothing(yaw_deg: float) -> None:
    link = Link(antenna_offset=[0.0, 0.0, 0.3])
    level, turned = (antenna_position(UAV, np.array([0.0, 0.0, math.radians(yaw)]), link) for yaw in (0.0, yaw_deg))
    np.testing.assert_allclose(turned, level, atol=1e-15)


def test_received_power_is_recovered_from_the_gain() -> None:
    # P_r = P_t |g|^2, and SNR = P_r / sigma^2: from dBm to watt and back by hand.
    link, gain = Link(transmit_power_dbm=20.0, noise_power_dbm=-90.0), 3e-9
    received_watt = 0.1 * gain
    noise_watt = 1e-12
    assert snr(np.array(gain), link) * noise_watt == pytest.approx(received_watt, rel=1e-12)
    assert spectral_efficiency(np.array(gain), link) == pytest.approx(math.log2(1.0 + received_watt / noise_watt))


def channel(eta: np.ndarray) -> tuple[TwoRayChannel, np.ndarray]:
    return TwoRayChannel(Link()), np.concatenate([UAV, eta, np.zeros(6)])


def test_block_serves_the_functions() -> None:
    eta = np.array([0.1, -0.05, 0.02])
    dut, state = channel(eta)
    context = dut.CreateDefaultContext()
    dut.GetInputPort("vehicle_state").FixValue(context, state)
    dut.GetInputPort("ship_antenna_position").FixValue(context, SHIP_ANTENNA)
    rays = path_lengths(antenna_position(UAV, eta, Link()), SHIP, Link())
    gain = gain_by_complex_numbers(*rays, Link())
    assert dut.GetOutputPort("channel_gain").Eval(context)[0] == pytest.approx(gain)
    assert dut.GetOutputPort("snr_db").Eval(context)[0] == pytest.approx(10.0 * math.log10(1e9 * gain))
    assert dut.GetOutputPort("spectral_efficiency").Eval(context)[0] == pytest.approx(math.log2(1.0 + 1e9 * gain))
    assert dut.GetOutputPort("phase_difference").Eval(context)[0] == pytest.approx(
        2.0 * math.pi * 3e9 / 299792458.0 * (rays[1] - rays[0])
    )


@pytest.mark.parametrize("port", ["channel_gain", "snr_db", "spectral_efficiency", "phase_difference"])
def test_block_answers_to_either_input_alone(port: str) -> None:
    dut, state = channel(np.zeros(3))
    context = dut.CreateDefaultContext()
    dut.GetInputPort("vehicle_state").FixValue(context, state)
    seen = []
    for antenna in (SHIP_ANTENNA, SHIP_ANTENNA + 0.1):
        dut.GetInputPort("ship_antenna_position").FixValue(context, antenna)
        seen.append(dut.GetOutputPort(port).Eval(context)[0])
    dut.GetInputPort("vehicle_state").FixValue(context, state + 0.05)
    seen.append(dut.GetOutputPort(port).Eval(context)[0])
    assert len(set(seen)) == 3


@pytest.mark.parametrize("port", ["channel_gain", "snr_db", "spectral_efficiency", "phase_difference"])
def test_block_differentiates(port: str) -> None:
    dut, state = channel(np.array([0.12, -0.07, 0.05]))

    def evaluate(state: np.ndarray) -> float:
        context = dut.CreateDefaultContext()
        dut.GetInputPort("vehicle_state").FixValue(context, state)
        dut.GetInputPort("ship_antenna_position").FixValue(context, SHIP_ANTENNA)
        return float(dut.GetOutputPort(port).Eval(context)[0])

    step = 1e-6
    expected = [(evaluate(state + step * e) - evaluate(state - step * e)) / (2 * step) for e in np.eye(12)]

    taped = dut.ToAutoDiffXd()
    context = taped.CreateDefaultContext()
    taped.GetInputPort("vehicle_state").FixValue(context, InitializeAutoDiff(state).ravel())
    taped.GetInputPort("ship_antenna_position").FixValue(context, np.array([AutoDiffXd(x) for x in SHIP_ANTENNA]))
    value = taped.GetOutputPort(port).Eval(context)
    np.testing.assert_allclose(ExtractGradient(value)[0], expected, rtol=1e-6, atol=1e-7 * np.abs(expected).max())


def test_the_sea_reflects_at_the_angle_of_incidence(scenario: Scenario, rng: np.random.Generator) -> None:
    antenna = rng.uniform([-5.0, -5.0, -5.0], [5.0, 5.0, 5.0], (50, 3))
    ship = np.array([95.0, 3.0, -20.0])
    point = specular_point(antenna, ship + np.array([0.0, 0.0, 10.0]), -20.0)
    np.testing.assert_allclose(point[:, 2], -20.0, atol=1e-12)
    down, up = point - antenna, ship + np.array([0.0, 0.0, 10.0]) - point
    into = down / np.linalg.norm(down, axis=1, keepdims=True)
    out = up / np.linalg.norm(up, axis=1, keepdims=True)
    np.testing.assert_allclose(out, into * [1.0, 1.0, -1.0], atol=1e-12)
    length = np.linalg.norm(down, axis=1) + np.linalg.norm(up, axis=1)
    np.testing.assert_allclose(length, path_lengths(antenna, ship, scenario.link)[1], rtol=1e-13)
