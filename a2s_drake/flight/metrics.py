"""Metrics: what a Flight is worth in numbers."""

import json
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.files import written_whole
from a2s_drake.common.packages import is_installed
from a2s_drake.flight.log import Fallback, Flight
from a2s_drake.flight.results import BoundUse, Fades, Limit, Metrics, SolverSummary, StepTime
from a2s_drake.link.throughput import gain_percent as throughput_gain_percent

_Given = float | Sequence[float]

OUTAGE_THRESHOLDS_DB = (0.0, 3.0, 6.0, 9.0, 12.0)


def throughput(flight: Flight) -> float:
    """Cumulative throughput per hertz, bit/Hz: the sum of T_s log2(1 + SNR) over all samples (section V)."""
    return float(flight.scenario.mpc.period * flight.spectral_efficiency.sum())


def gain_percent(flight: Flight, baseline: Flight) -> float:
    """How much more a flight transmits than a baseline, %."""
    return throughput_gain_percent(throughput(flight), throughput(baseline))


def outage_curve(flight: Flight, thresholds_db: FloatArray) -> FloatArray:
    """Fraction of the samples with an SNR below each threshold, dB; shape (m,) to (m,)."""
    return np.asarray((flight.snr_db < thresholds_db[:, np.newaxis]).mean(axis=1))


def outage(flight: Flight) -> dict[float, float]:
    """`outage_curve` at the paper's thresholds, dB."""
    return dict(zip(OUTAGE_THRESHOLDS_DB, outage_curve(flight, np.array(OUTAGE_THRESHOLDS_DB)).tolist(), strict=True))


def fade_durations(flight: Flight, threshold_db: float = 0.0) -> FloatArray:
    """How long the SNR stays below a threshold, dB, each time it goes below: s, shape (count,).

    A sample stands for T_s, as in `throughput`. A fade that the beginning or end of the flight cuts off counts with the
    part that is seen.
    """
    below = np.concatenate([[False], flight.snr_db < threshold_db, [False]])
    begins, ends = np.flatnonzero(~below[:-1] & below[1:]), np.flatnonzero(below[:-1] & ~below[1:])
    return np.asarray(flight.scenario.mpc.period * (ends - begins), dtype=float)


def fades(flight: Flight, threshold_db: float = 0.0) -> int:
    """How many times the SNR goes below a threshold, dB."""
    return len(fade_durations(flight, threshold_db))


def fade_summary(flight: Flight) -> dict[float, Fades]:
    """The fades below each of the paper's thresholds, by the threshold, dB."""
    summary: dict[float, Fades] = {}
    for threshold in OUTAGE_THRESHOLDS_DB:
        lasted = fade_durations(flight, threshold)
        median, longest = (float(np.median(lasted)), float(lasted.max())) if len(lasted) else (None, None)
        summary[threshold] = Fades(len(lasted), median, longest)
    return summary


def position_error(flight: Flight) -> FloatArray:
    """Distance of the centre of mass from its planned place, m, shape (n,)."""
    return np.linalg.norm(flight.position - flight.position_reference, axis=1)


def tracking_error(flight: Flight) -> FloatArray:
    """Distance of the centre of mass as measured from where the law wants it, m, shape (n,).

    A row without a measured place counts with the true one. NaN where the command is not known, as in files of earlier
    versions.
    """
    measured = flight.measured_state[:, :3]
    known = np.where(np.isnan(measured).any(axis=1, keepdims=True), flight.position, measured)
    return np.linalg.norm(known - flight.position_command, axis=1)


def attitude_error(flight: Flight) -> FloatArray:
    """Attitude minus reference, rad, shape (n, 3)."""
    return flight.attitude - flight.attitude_reference


def _statistics(error: FloatArray) -> tuple[float | None, float | None]:
    """Maximum and root mean square of the errors that are known; None without any."""
    known = error[~np.isnan(error)]
    return (float(known.max()), float(np.sqrt((known**2).mean()))) if len(known) else (None, None)


def _bound_use(
    values: FloatArray, lower: float | Sequence[float], upper: float | Sequence[float], unit: str
) -> BoundUse:
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    excess = np.maximum(low - values, values - high)
    return BoundUse(
        unit=unit,
        lower=_limit(low),
        upper=_limit(high),
        # Distance from the middle of the range over half its width: 1 lies on the bound.
        largest_use=float((np.abs(values - (low + high) / 2.0) / ((high - low) / 2.0)).max()),
        worst_excess=float(np.maximum(excess, 0.0).max()),
        worst_excess_of_range=float(np.maximum(excess / (high - low), 0.0).max()),
    )


def _limit(value: FloatArray) -> Limit:
    return tuple(value.tolist()) if value.ndim else float(value)


def bounds(flight: Flight) -> dict[str, BoundUse]:
    """The use of each bounded quantity by its name; without rotors, their speed is not among them."""
    airframe, mpc = flight.scenario.airframe, flight.scenario.mpc
    velocity, rate, angle = mpc.velocity_limit, mpc.angular_velocity_limit, mpc.attitude_limit
    uses = {
        "position": _bound_use(flight.position, mpc.position_lower, mpc.position_upper, "m"),
        "attitude": _bound_use(flight.attitude, -angle, angle, "rad"),
        "velocity": _bound_use(flight.velocity, -velocity, velocity, "m/s"),
        "angular_velocity": _bound_use(flight.angular_velocity, -rate, rate, "rad/s"),
    }
    if flight.has_rotors:
        low, high = airframe.rotor_speed_min, airframe.rotor_speed_max
        uses["rotor_speed"] = _bound_use(flight.rotor_speed, low, high, "Hz")
    return uses


def solver_summary(flight: Flight) -> SolverSummary:
    """How the solver of a flight with at least one sample fared.

    Time per step is a wall-clock reading, so a flight loaded from disk has none.
    """
    counts = {
        fallback.name.lower(): int((flight.solver_fallback == fallback).sum())
        for fallback in Fallback
        if fallback is not Fallback.NONE
    }
    step_ms = None
    if flight.wall_clock is not None and flight.has_solver:
        step = 1e3 * flight.wall_clock.step
        step_ms = StepTime(float(np.median(step)), float(np.percentile(step, 99)), float(step.max()))
    return SolverSummary(
        present=flight.has_solver,
        failures=int((flight.solver_success == 0).sum()) if flight.has_solver else 0,
        fallback_counts=counts,
        iterations=int(flight.solver_iterations.sum()),
        iterations_max=int(flight.solver_iterations.max()),
        step_ms=step_ms,
    )


def measure(flight: Flight) -> Metrics:
    """All metrics of a flight with at least one sample.

    Wall-clock readings are None for a flight loaded from disk. `wall_s` and `real_time_factor` are of the whole run,
    whether or not a solver was part of it.
    """
    error = position_error(flight)
    tracking_max, tracking_rms = _statistics(tracking_error(flight))
    wall = flight.wall_clock.total if flight.wall_clock is not None else None
    flown = float(flight.time[-1])
    return Metrics(
        law=flight.law,
        own_blocks=dict(flight.own_blocks),
        rebuilds_from_scenario=flight.rebuilds_from_scenario,
        samples=len(flight.time),
        complete=len(flight.time) == len(flight.scenario.sample_times()),
        throughput_bit_per_hz=throughput(flight),
        outage=outage(flight),
        fades=fade_summary(flight),
        position_error_max_m=float(error.max()),
        position_error_rms_m=float(np.sqrt((error**2).mean())),
        tracking_error_max_m=tracking_max,
        tracking_error_rms_m=tracking_rms,
        attitude_error_rms_deg=tuple(np.rad2deg(np.sqrt((attitude_error(flight) ** 2).mean(axis=0))).tolist()),
        bounds=bounds(flight),
        solver=solver_summary(flight),
        wall_s=wall,
        real_time_factor=flown / wall if wall else None,
        versions=versions(),
    )


def compute_metrics(flight: Flight) -> dict[str, Any]:
    """`measure` of a flight as the dictionary of metrics.json, `compute_metrics(flight)["throughput_bit_per_hz"]`.

    What is not known is None. Numbers that are not finite are None in the file alone.
    """
    return measure(flight).as_json()


def versions() -> dict[str, str | None]:
    """What this process flies with: versions by name, None for a package that is not installed, and the platform."""
    packages = {"drake": "pydrake", "numpy": "numpy", "scipy": "scipy", "piqp": "piqp"}
    found = {name: version(name) if is_installed(module) else None for name, module in packages.items()}
    own = {"a2s_drake": version("a2s_drake")}
    return own | found | {"python": platform.python_version(), "platform": platform.platform()}


def write_metrics(flight: Flight, folder: Path) -> None:
    """Writes `compute_metrics` of a flight as metrics.json into a folder; null for numbers that are not finite."""
    with written_whole(folder / "metrics.json") as part:
        part.write_text(json.dumps(_finite(compute_metrics(flight)), indent=2) + "\n", encoding="utf-8")


def _finite(value: Any) -> Any:
    """The same without NaN and infinity, which JSON does not know."""
    if isinstance(value, dict):
        return {name: _finite(entry) for name, entry in value.items()}
    if isinstance(value, list):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
