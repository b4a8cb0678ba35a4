"""Metrics of fades and of tracking, and the versions: against loops and closed forms."""

import importlib.metadata
import json
import platform
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from a2s_drake import compute_metrics
from a2s_drake.flight import metrics
from a2s_drake.flight.metrics import fade_durations, fade_summary, fades, measure, write_metrics
from tests.support.flights import SAMPLES, made_up_flight

PERIOD = 0.02


def flight_with(snr: list[float]):
    n = len(snr)
    return made_up_flight(time=PERIOD * np.arange(n), snr_db=np.array(snr, float))


def stretches(snr: list[float], threshold: float) -> list[int]:
    """The lengths of the stretches below a threshold, sample by sample."""
    lengths, run = [], 0
    for value in snr:
        if value < threshold:
            run += 1
        elif run:
            lengths.append(run)
            run = 0
    return [*lengths, run] if run else lengths


@given(st.lists(st.sampled_from([-1.0, 0.0, 3.0, 5.0, 12.0, 20.0, float("nan")]), min_size=1, max_size=40))
def test_fades_are_the_stretches_that_a_loop_finds(snr: list[float]) -> None:
    flight = flight_with(snr)
    summary = fade_summary(flight)
    assert list(summary) == [0.0, 3.0, 6.0, 9.0, 12.0]
    for threshold, dut in summary.items():
        lengths = stretches(snr, threshold)
        np.testing.assert_allclose(fade_durations(flight, threshold), PERIOD * np.array(lengths, float))
        assert dut.count == fades(flight, threshold) == len(lengths)
        if lengths:
            assert dut.median_s == pytest.approx(PERIOD * float(np.median(lengths)))
            assert dut.longest_s == pytest.approx(PERIOD * max(lengths))
        else:
            assert dut.median_s is dut.longest_s is None


def test_a_sine_fades_for_half_its_period() -> None:
    # 10 sin(2 pi t / 2 s) dB, seen for 8 s: below 0 dB for 1 s, four times.
    time = 0.02 * np.arange(400) + 0.01
    dut = fade_summary(flight_with((10.0 * np.sin(np.pi * time)).tolist()))[0.0]
    assert dut.as_json() == pytest.approx({"count": 4, "median_s": 1.0, "longest_s": 1.0})


def test_the_metrics_hold_the_fades() -> None:
    flight = flight_with([-1.0, 20.0, 1.0, -1.0, -1.0])
    assert measure(flight).fades == fade_summary(flight)
    once = {"count": 1, "median_s": 0.1, "longest_s": 0.1}
    assert compute_metrics(flight_with([-1.0] * 5))["fades"] == dict.fromkeys(["0", "3", "6", "9", "12"], once)


def at_row(row: int, value: list[float], width: int = 3) -> np.ndarray:
    rows = np.zeros((SAMPLES, width))
    rows[row, : len(value)] = value
    return rows


def test_tracking_is_the_measured_state_against_the_command() -> None:
    measured = at_row(2, [0.3, 0.4, 0.0], 12)
    dut = compute_metrics(made_up_flight(measured_state=measured))
    assert dut["tracking_error_max_m"] == pytest.approx(0.5)
    assert dut["tracking_error_rms_m"] == pytest.approx(0.5 / np.sqrt(SAMPLES))
    assert dut["position_error_max_m"] == 0.0
    dut = compute_metrics(made_up_flight(measured_state=measured, position_command=at_row(2, [0.3, 0.4, 1.2])))
    assert dut["tracking_error_max_m"] == pytest.approx(1.2)


def test_what_is_commanded_off_the_path_is_no_tracking_error() -> None:
    moved = at_row(1, [0.0, 0.0, 0.2])
    dut = compute_metrics(made_up_flight(position=moved, position_command=moved))
    assert (dut["tracking_error_max_m"], dut["tracking_error_rms_m"]) == (0.0, 0.0)
    assert dut["position_error_max_m"] == pytest.approx(0.2)


def test_where_nothing_is_measured_the_truth_counts() -> None:
    measured = at_row(2, [0.3, 0.4, 0.0], 12)
    measured[3:] = np.nan
    dut = compute_metrics(made_up_flight(measured_state=measured, position=at_row(4, [0.0, 2.0, 0.0])))
    assert dut["tracking_error_max_m"] == pytest.approx(2.0)
    assert dut["tracking_error_rms_m"] == pytest.approx(np.sqrt((0.25 + 4.0) / SAMPLES))


def test_without_a_command_tracking_is_unknown() -> None:
    dut = compute_metrics(made_up_flight(position_command=None))
    assert dut["tracking_error_max_m"] is dut["tracking_error_rms_m"] is None


def test_versions_are_those_of_the_packages_and_the_platform(monkeypatch: pytest.MonkeyPatch) -> None:
    dut = compute_metrics(made_up_flight())["versions"]
    for name in ("drake", "numpy", "scipy", "piqp"):
        assert dut[name] == importlib.metadata.version(name)
    assert (dut["python"], dut["platform"]) == (platform.python_version(), platform.platform())
    monkeypatch.setattr(metrics, "is_installed", lambda package: package != "piqp")
    assert compute_metrics(made_up_flight())["versions"]["piqp"] is None


def refuse(name: str) -> None:
    pytest.fail(f"{name} is no number of JSON")


def test_numbers_that_json_does_not_know_are_null(tmp_path: Path) -> None:
    lost = made_up_flight(position=np.full((SAMPLES, 3), np.nan), snr_db=np.full(SAMPLES, np.nan))
    write_metrics(lost, tmp_path)
    written = json.loads((tmp_path / "metrics.json").read_text(), parse_constant=refuse)
    assert written["position_error_max_m"] is None
    assert written["tracking_error_max_m"] is None
    assert written["bounds"]["position"]["largest_use"] is None
    assert written["throughput_bit_per_hz"] == pytest.approx(0.4)
