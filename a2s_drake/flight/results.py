"""Results: the metrics of a flight as values with names, units and types, and as the dictionary of metrics.json."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

Limit = float | tuple[float, ...]
"""A limit of all axes, or one for each axis."""


@dataclass(frozen=True)
class Fades:
    """The stretches of a flight with an SNR below some threshold.

    Attributes:
      count: how many there are.
      median_s: the median of their durations, s; None without a fade.
      longest_s: the longest duration, s; None without a fade.
    """

    count: int
    median_s: float | None
    longest_s: float | None

    def as_json(self) -> dict[str, Any]:
        """An entry of `fades` in metrics.json."""
        return asdict(self)


@dataclass(frozen=True)
class BoundUse:
    """How much of its range a bounded quantity has used over a flight.

    Attributes:
      unit: of the limits and of `worst_excess`.
      lower: the lower limit.
      upper: the upper limit.
      largest_use: the largest distance from mid-range over half the range, dimensionless; 1 lies on a limit.
      worst_excess: the largest step beyond a limit; 0 without one.
      worst_excess_of_range: the same as a share of the range, dimensionless.
    """

    unit: str
    lower: Limit
    upper: Limit
    largest_use: float
    worst_excess: float
    worst_excess_of_range: float

    def as_json(self) -> dict[str, Any]:
        """An entry of `bounds` in metrics.json."""
        limits = (self.lower, self.upper)
        return {
            "unit": self.unit,
            "limit": [list(limit) if isinstance(limit, tuple) else limit for limit in limits],
            "largest_use": self.largest_use,
            "worst_excess": self.worst_excess,
            "worst_excess_of_range": self.worst_excess_of_range,
        }


@dataclass(frozen=True)
class StepTime:
    """How long the controller's steps took on the machine that flew, ms.

    Attributes:
      median: of all steps, ms.
      p99: what 99 % of the steps stayed below, ms.
      max: the longest step, ms.
    """

    median: float
    p99: float
    max: float

    def as_json(self) -> dict[str, float]:
        """The entry `solver.step_ms` of metrics.json."""
        return asdict(self)


@dataclass(frozen=True)
class SolverSummary:
    """How the controller's solver fared over a flight.

    Attributes:
      present: whether a solver flew; without one the counts are 0.
      failures: samples in which the problem as posed was not solved.
      fallback_counts: how often each fallback stood in, by its name in lower case.
      iterations: over the whole flight.
      iterations_max: in the worst sample.
      step_ms: None without a solver, and for a flight loaded from disk.
    """

    present: bool
    failures: int
    fallback_counts: Mapping[str, int]
    iterations: int
    iterations_max: int
    step_ms: StepTime | None

    @property
    def fallbacks(self) -> int:
        """How often any fallback stood in."""
        return sum(self.fallback_counts.values())

    def as_json(self) -> dict[str, Any]:
        """The entry `solver` of metrics.json."""
        return {
            "present": self.present,
            "failures": self.failures,
            "fallbacks": self.fallbacks,
            "fallback_counts": dict(self.fallback_counts),
            "iterations": self.iterations,
            "iterations_max": self.iterations_max,
            "step_ms": self.step_ms.as_json() if self.step_ms is not None else None,
        }


@dataclass(frozen=True)
class Metrics:
    """What a flight with at least one sample is worth in numbers. The fields are the keys of metrics.json, in order.

    Attributes:
      law: the attitude law: the name of the user's own block, else of the scenario's law.
      own_blocks: the blocks of the user's own that flew, name by role.
      rebuilds_from_scenario: whether the scenario says all of what flew.
      samples: how many there are.
      complete: whether the flight lasted as long as its scenario asks.
      throughput_bit_per_hz: sum of T_s log2(1 + SNR) over all samples, bit/Hz.
      outage: share of the samples with an SNR below each threshold, by the threshold, dB.
      fades: the stretches below each threshold, by the threshold, dB.
      position_error_max_m: largest distance of the centre of mass from its path, m.
      position_error_rms_m: root mean square of that distance, m.
      tracking_error_max_m: largest distance of the measured place from what the law commands, m; None where unknown.
      tracking_error_rms_m: root mean square of that distance, m; None where unknown.
      attitude_error_rms_deg: root mean square of attitude minus reference: roll, pitch, yaw, deg.
      bounds: the use of each bounded quantity, by its name.
      solver: how the solver fared.
      wall_s: how long the whole run took, s; None for a flight loaded from disk.
      real_time_factor: flight time over `wall_s`, dimensionless; None for a flight loaded from disk.
      versions: of the packages and the platform of this process; None for a package that is not installed.
    """

    law: str
    own_blocks: Mapping[str, str]
    rebuilds_from_scenario: bool
    samples: int
    complete: bool
    throughput_bit_per_hz: float
    outage: Mapping[float, float]
    fades: Mapping[float, Fades]
    position_error_max_m: float
    position_error_rms_m: float
    tracking_error_max_m: float | None
    tracking_error_rms_m: float | None
    attitude_error_rms_deg: tuple[float, ...]
    bounds: Mapping[str, BoundUse]
    solver: SolverSummary
    wall_s: float | None
    real_time_factor: float | None
    versions: Mapping[str, str | None]

    def as_json(self) -> dict[str, Any]:
        """The content of metrics.json, but with NaN and infinity where numbers are not finite."""
        return {entry.name: _plain(getattr(self, entry.name)) for entry in fields(self)}


def _plain(value: Any) -> Any:
    """A field of `Metrics` as JSON can hold it; a threshold as a key becomes a short text."""
    if isinstance(value, Fades | BoundUse | SolverSummary):
        return value.as_json()
    if isinstance(value, Mapping):
        return {key if isinstance(key, str) else f"{key:g}": _plain(entry) for key, entry in value.items()}
    return list(value) if isinstance(value, tuple) else value
