"""Metrics are typed; the dictionary of metrics.json is made of them, with the same keys in the same order as ever."""

import dataclasses
import inspect
import json
import re
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import compute_metrics
from a2s_drake.flight import results
from a2s_drake.flight.metrics import measure, write_metrics
from a2s_drake.flight.results import Metrics
from tests.support.flights import SAMPLES, made_up_flight

TYPES = [getattr(results, name) for name in ("Fades", "BoundUse", "StepTime", "SolverSummary", "Metrics")]

EXPECTED = """{
  "law": "three_axis",
  "own_blocks": {},
  "rebuilds_from_scenario": true,
  "samples": 5,
  "complete": false,
  "throughput_bit_per_hz": 0.4,
  "outage": {"0": 0.2, "3": 0.4, "6": 0.4, "9": 0.4, "12": 0.6},
  "fades": {
    "0": {"count": 1, "median_s": 0.02, "longest_s": 0.02},
    "3": {"count": 1, "median_s": 0.04, "longest_s": 0.04},
    "6": {"count": 1, "median_s": 0.04, "longest_s": 0.04},
    "9": {"count": 1, "median_s": 0.04, "longest_s": 0.04},
    "12": {"count": 2, "median_s": 0.03, "longest_s": 0.04}
  },
  "position_error_max_m": 5.0,
  "position_error_rms_m": 5.0,
  "tracking_error_max_m": 5.0,
  "tracking_error_rms_m": 5.0,
  "attitude_error_rms_deg": [0.0, 0.0, 0.0],
  "bounds": {
    "position": {
      "unit": "m",
      "limit": [[-10.0, -10.0, -10.0], [10.0, 10.0, 10.0]],
      "largest_use": 0.4,
      "worst_excess": 0.0,
      "worst_excess_of_range": 0.0
    },
    "attitude": {
      "unit": "rad",
      "limit": [-0.2617993877991494, 0.2617993877991494],
      "largest_use": 0.0,
      "worst_excess": 0.0,
      "worst_excess_of_range": 0.0
    },
    "velocity": {
      "unit": "m/s",
      "limit": [-1.0, 1.0],
      "largest_use": 1.5,
      "worst_excess": 0.5,
      "worst_excess_of_range": 0.25
    },
    "angular_velocity": {
      "unit": "rad/s",
      "limit": [-1.0, 1.0],
      "largest_use": 0.0,
      "worst_excess": 0.0,
      "worst_excess_of_range": 0.0
    },
    "rotor_speed": {
      "unit": "Hz",
      "limit": [16.0, 100.0],
      "largest_use": 0.0,
      "worst_excess": 0.0,
      "worst_excess_of_range": 0.0
    }
  },
  "solver": {
    "present": true,
    "failures": 0,
    "fallbacks": 3,
    "fallback_counts": {"softened": 2, "shifted_plan": 0, "hover": 1},
    "iterations": 100,
    "iterations_max": 20,
    "step_ms": {"median": 3.0, "p99": 8.8, "max": 9.0}
  },
  "wall_s": 0.05,
  "real_time_factor": 1.6
}"""


@pytest.fixture
def dut() -> Metrics:
    """The metrics of a flight whose numbers are easy to follow by hand."""
    return measure(
        made_up_flight(
            snr_db=np.array([-1.0, 1.0, 20.0, 10.0, 20.0]),
            position=np.tile([3.0, 0.0, 4.0], (SAMPLES, 1)),
            velocity=np.tile([1.5, 0.0, 0.0], (SAMPLES, 1)),
            solver_fallback=np.array([0.0, 1.0, 1.0, 3.0, 0.0]),
        )
    )


def leaves(value: object, path: str = "") -> list[tuple[str, object]]:
    """Every entry of nested dictionaries and lists, in order."""
    if isinstance(value, dict):
        return [leaf for name, entry in value.items() for leaf in leaves(entry, f"{path}/{name}")] or [(path, {})]
    if isinstance(value, list):
        return [leaf for place, entry in enumerate(value) for leaf in leaves(entry, f"{path}/{place}")]
    return [(path, value)]


def test_the_dictionary_has_every_key_in_order_and_plain_types(dut: Metrics) -> None:
    written = dut.as_json()
    assert written.pop("versions") == dict(dut.versions)
    found, wanted = leaves(written), leaves(json.loads(EXPECTED))
    assert [path for path, _ in found] == [path for path, _ in wanted]
    assert [type(value) for _, value in found] == [type(value) for _, value in wanted]
    for (path, value), (_, expected) in zip(found, wanted, strict=True):
        assert value == (pytest.approx(expected) if isinstance(expected, float) else expected), path


def test_the_keys_are_the_fields(dut: Metrics) -> None:
    assert list(dut.as_json()) == [entry.name for entry in dataclasses.fields(Metrics)]


def test_the_file_and_compute_metrics_hold_the_same(tmp_path: Path) -> None:
    flight = made_up_flight()
    dut = measure(flight).as_json()
    assert compute_metrics(flight) == dut
    write_metrics(flight, tmp_path)
    assert (tmp_path / "metrics.json").read_text() == json.dumps(dut, indent=2) + "\n"


def test_what_is_measured_has_names_and_types(dut: Metrics) -> None:
    assert dut.fades[12.0].count == 2
    assert dut.bounds["velocity"].worst_excess_of_range == pytest.approx(0.25)
    assert dut.bounds["position"].upper == (10.0, 10.0, 10.0)
    assert dut.solver.fallbacks == 3
    assert dut.solver.step_ms is not None
    assert dut.solver.step_ms.max == pytest.approx(9.0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        dut.samples = 0  # type: ignore[misc]


@pytest.mark.parametrize("kind", TYPES)
def test_every_field_is_documented(kind: type) -> None:
    documented = re.findall(r"^  (\w+): ", inspect.getdoc(kind) or "", re.MULTILINE)
    assert documented == [entry.name for entry in dataclasses.fields(kind)]
