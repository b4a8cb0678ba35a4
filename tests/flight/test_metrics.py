import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import compute_metrics
from a2s_drake.flight.metrics import fades, gain_percent, write_metrics
from tests.support.flights import SAMPLES, made_up_flight


def at_row(row: int, value: object, width: int = 3) -> np.ndarray:
    rows = np.zeros((SAMPLES, width))
    rows[row] = value
    return rows


def test_throughput_sums_every_sample() -> None:
    # 5 samples of 0.02 s at 4 bit/s/Hz.
    assert compute_metrics(made_up_flight())["throughput_bit_per_hz"] == pytest.approx(0.4)


def test_gain_is_relative_to_the_baseline() -> None:
    better = made_up_flight(spectral_efficiency=np.full(SAMPLES, 5.0))
    assert gain_percent(better, made_up_flight()) == pytest.approx(25.0)


def test_outage_is_the_fraction_strictly_below() -> None:
    dut = compute_metrics(made_up_flight(snr_db=np.array([-1.0, 0.0, 3.0, 8.0, 20.0])))
    assert dut["outage"] == {"0": 0.2, "3": 0.4, "6": 0.6, "9": 0.8, "12": 0.8}


@pytest.mark.parametrize(
    ("snr", "count"), [([1, 1, 1, 1, 1], 0), ([-1, -1, 1, -1, 1], 2), ([1, -1, -1, -1, -1], 1), ([0, 0, 0, 0, 0], 0)]
)
def test_a_fade_is_one_passage_below_the_threshold(snr: list[float], count: int) -> None:
    assert fades(made_up_flight(snr_db=np.array(snr, dtype=float))) == count


def test_position_error_is_a_distance() -> None:
    dut = compute_metrics(made_up_flight(position=at_row(2, [0.3, 0.4, 0.0])))
    assert dut["position_error_max_m"] == pytest.approx(0.5)
    assert dut["position_error_rms_m"] == pytest.approx(0.5 / np.sqrt(SAMPLES))


def test_attitude_error_is_per_axis_in_degrees() -> None:
    dut = compute_metrics(made_up_flight(attitude=at_row(1, np.deg2rad([1.0, 2.0, 3.0]))))
    np.testing.assert_allclose(dut["attitude_error_rms_deg"], np.array([1.0, 2.0, 3.0]) / np.sqrt(SAMPLES))


@pytest.mark.parametrize(
    ("quantity", "arrays", "use", "excess", "share"),
    [
        ("velocity", {"velocity": at_row(3, [0.5, 0.0, -0.75])}, 0.75, 0.0, 0.0),
        ("velocity", {"velocity": at_row(3, [0.0, -1.02, 0.0])}, 1.02, 0.02, 0.01),
        ("angular_velocity", {"angular_velocity": at_row(0, [0.0, 0.0, 0.25])}, 0.25, 0.0, 0.0),
        ("attitude", {"attitude": at_row(0, np.deg2rad([0.0, 18.0, 0.0]))}, 1.2, np.deg2rad(3.0), 0.1),
        ("position", {"position": at_row(0, [-4.0, 0.0, 0.0])}, 0.4, 0.0, 0.0),
        ("rotor_speed", {"rotor_speed": 58.0 + at_row(0, 21.0, 6)}, 0.5, 0.0, 0.0),
        ("rotor_speed", {"rotor_speed": 58.0 - at_row(0, 46.2, 6)}, 1.1, 4.2, 0.05),
    ],
)
def test_bounds(quantity: str, arrays: dict[str, np.ndarray], use: float, excess: float, share: float) -> None:
    dut = compute_metrics(made_up_flight(**arrays))["bounds"][quantity]
    assert dut["largest_use"] == pytest.approx(use)
    assert dut["worst_excess"] == pytest.approx(excess)
    assert dut["worst_excess_of_range"] == pytest.approx(share)


def test_each_axis_of_the_operating_region_has_bounds_of_its_own() -> None:
    made_up = made_up_flight(position=at_row(2, [0.0, 0.0, 2.5]))
    corners = ["mpc.position_lower=[-10, -5, -1]", "mpc.position_upper=[30, 7, 2]"]
    flight = dataclasses.replace(made_up, scenario=made_up.scenario.with_overrides(corners))
    dut = compute_metrics(flight)["bounds"]["position"]
    assert dut["limit"] == [[-10.0, -5.0, -1.0], [30.0, 7.0, 2.0]]
    assert dut["worst_excess"] == pytest.approx(0.5)
    assert dut["worst_excess_of_range"] == pytest.approx(0.5 / 3.0)
    assert dut["largest_use"] == pytest.approx(2.0 / 1.5)


def test_bounds_state_their_limits() -> None:
    dut = compute_metrics(made_up_flight())["bounds"]
    assert {name: bound["unit"] for name, bound in dut.items()} == {
        "position": "m",
        "attitude": "rad",
        "velocity": "m/s",
        "angular_velocity": "rad/s",
        "rotor_speed": "Hz",
    }
    assert dut["rotor_speed"]["limit"] == [16.0, 100.0]
    assert dut["attitude"]["limit"] == pytest.approx([-np.deg2rad(15.0), np.deg2rad(15.0)])


def test_solver_counts_failures_and_what_stood_in() -> None:
    flight = made_up_flight(solver_success=np.array([1, 0, 0, 0, 1]), solver_fallback=np.array([0, 1, 1, 3, 0]))
    dut = compute_metrics(flight)["solver"]
    assert (dut["failures"], dut["fallbacks"]) == (3, 3)
    assert dut["fallback_counts"] == {"softened": 2, "shifted_plan": 0, "hover": 1}
    assert (dut["iterations"], dut["iterations_max"]) == (100, 20)


def test_wall_clock_comes_from_the_run_alone() -> None:
    flown = compute_metrics(made_up_flight())
    assert flown["solver"]["step_ms"] == pytest.approx({"median": 3.0, "p99": 8.8, "max": 9.0})
    assert (flown["wall_s"], flown["real_time_factor"]) == pytest.approx((0.05, 0.08 / 0.05))
    loaded = compute_metrics(dataclasses.replace(made_up_flight(), wall_clock=None))
    assert loaded["wall_s"] is loaded["real_time_factor"] is loaded["solver"]["step_ms"] is None


def test_ideal_flights_have_no_rotor_bound_and_no_failures() -> None:
    flight = made_up_flight(rotor_speed=np.full((SAMPLES, 6), np.nan), solver_success=np.zeros(SAMPLES))
    dut = compute_metrics(flight)
    assert "rotor_speed" not in dut["bounds"]
    assert dut["solver"]["failures"] == 0


def test_file_holds_the_metrics(tmp_path: Path) -> None:
    write_metrics(made_up_flight("level"), tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["metrics.json"]
    written = json.loads((tmp_path / "metrics.json").read_text())
    assert written == compute_metrics(made_up_flight("level"))
    assert written["law"] == "level"
    assert set(written["versions"]) == {"a2s_drake", "drake", "numpy", "scipy", "piqp", "python", "platform"}
