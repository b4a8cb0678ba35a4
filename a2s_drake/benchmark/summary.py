"""What a benchmark found, in numbers ready for JSON."""

import platform
import resource
import sys
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import numpy as np

from a2s_drake.benchmark.accuracy import deviation_percent
from a2s_drake.benchmark.growth import Growth
from a2s_drake.benchmark.timing import Timing, statistics_ms
from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.packages import is_installed
from a2s_drake.flight.log import Flight
from a2s_drake.flight.metrics import compute_metrics
from a2s_drake.scenario.parts import Airframe


def peak_memory_mib() -> float:
    """The most memory that this process has held so far, MiB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)  # bytes on macOS, KiB elsewhere


def flight_summary(flight: Flight) -> dict[str, Any]:
    """What was flown, and how fast, by the wall clock of this run."""
    metrics, clock = compute_metrics(flight), flight.wall_clock
    return {
        "law": flight.law,
        "solver": flight.scenario.mpc.solver,
        "horizon": flight.scenario.mpc.horizon,
        "duration_s": float(flight.time[-1]),
        "failures": metrics["solver"]["failures"],
        "wall_s": metrics["wall_s"],
        "real_time_factor": metrics["real_time_factor"],
        # A sample of the controller block: the decision about the step, and Drake's own share.
        "controller_ms": statistics_ms(clock.step) if clock is not None else None,
    }


def timing_summary(timing: Timing, exact: FloatArray, airframe: Airframe) -> dict[str, Any]:
    """One contestant's times, iterations, failures and deviation from the exact inputs of all problems (n, 6)."""
    known = timing.iterations[np.isfinite(timing.iterations)]
    return {
        "problems": len(timing.places),
        "failures": timing.failures,
        "step_ms": statistics_ms(timing.total),
        "split_ms": {name: statistics_ms(part) for name, part in timing.parts.items()},
        "iterations": {"median": float(np.median(known)), "max": int(known.max())} if known.size else None,
        "deviation_percent": deviation_percent(timing.input, exact[timing.places], airframe),
    }


def casadi_summary(name: str, other: Timing, own: Timing, exact: FloatArray, airframe: Airframe) -> dict[str, Any]:
    """One of CasADi's solvers beside the MPC's own: QP against QP, or a whole program against a step."""
    mine = own.at(other.places)
    part = next(iter(other.parts))
    ours = mine.parts["solve"] if part == "solve" else mine.total
    summary = timing_summary(other, exact, airframe)
    del summary["split_ms"]
    return (
        {"name": name, "compared": "QP solve" if part == "solve" else "step"}
        | {"time_ms" if key == "step_ms" else key: value for key, value in summary.items()}
        | {"own_median_ms": float(1e3 * np.median(ours)), "ratio": float(np.median(other.total) / np.median(ours))}
    )


def growth_summary(growths: Mapping[str, Growth]) -> dict[str, Any]:
    """Growth by solver."""
    return {
        solver: {
            "horizons": list(growth.horizons),
            "median_ms": growth.median_ms.tolist(),
            "iterations": growth.iterations.tolist(),
            "offset_ms": growth.offset_ms,
            "per_stage_ms": growth.per_stage_ms,
            "r_squared": growth.r_squared,
            "exponent": growth.exponent,
        }
        for solver, growth in growths.items()
    }


def summarise(
    flight: Flight, timings: Mapping[str, Timing], exact: FloatArray, growths: Mapping[str, Growth]
) -> dict[str, Any]:
    """A whole benchmark.

    Args:
      timings: of `own`, `plain`, and of CasADi's solvers, if any.
      exact: exact u_0 of each problem, Hz^2, shape (n, 6).
    """
    airframe = flight.scenario.airframe
    own, plain = (timing_summary(timings[name], exact, airframe) for name in ("own", "plain"))
    own["accuracy_percent"] = own.pop("deviation_percent")
    packages = [name for name in ("a2s_drake", "drake", "piqp", "numpy", "scipy", "casadi") if is_installed(name)]
    return {
        "flight": flight_summary(flight),
        **own,
        "without_exact_solution": int(np.isnan(exact).any(axis=1).sum()),
        "plain": plain,
        "step_over_plain": own["step_ms"]["median"] / plain["step_ms"]["median"],
        "peers": {
            name: casadi_summary(name, timing, timings["own"], exact, airframe)
            for name, timing in timings.items()
            if name not in ("own", "plain")
        },
        "growth": growth_summary(growths),
        "machine": {"system": platform.system(), "processor": platform.machine(), "python": platform.python_version()},
        "versions": {name: version(name) for name in packages},
    }
