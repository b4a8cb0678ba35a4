"""What a benchmark found: its numbers by name, and how they are written as JSON."""

import platform
import resource
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any

import numpy as np

from a2s_drake.benchmark.accuracy import deviation_percent
from a2s_drake.benchmark.growth import Growth
from a2s_drake.benchmark.timing import Statistics, Timing, statistics_ms
from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.packages import is_installed
from a2s_drake.flight.log import Flight
from a2s_drake.flight.metrics import measure
from a2s_drake.scenario.parts import Airframe


@dataclass(frozen=True)
class FlightNumbers:
    """What was flown, and how fast, by the wall clock of this run.

    Attributes:
      duration_s: of the flight, s.
      failures: samples at which the problem as posed was not solved.
      wall_s: how long the flight took, s.
      real_time_factor: flown over wall-clock time.
      controller_ms: of a sample of the controller block, the decision about the step and Drake's own share, ms.
    """

    law: str
    solver: str
    horizon: int
    duration_s: float
    failures: int
    wall_s: float | None
    real_time_factor: float | None
    controller_ms: Statistics | None


@dataclass(frozen=True)
class Iterations:
    """Median and largest number of a solver's iterations."""

    median: float
    max: int


@dataclass(frozen=True)
class SolverNumbers:
    """One contestant.

    Attributes:
      problems: how many it solved or tried to.
      failures: how many of them went without a solution.
      step_ms: wall time of all parts together, ms.
      split_ms: of each part, ms.
      iterations: None where the solver does not say.
      deviation_percent: the largest of its input from the exact one, % of the rotors' range; None where none counts.
    """

    problems: int
    failures: int
    step_ms: Statistics
    split_ms: dict[str, Statistics]
    iterations: Iterations | None
    deviation_percent: float | None


@dataclass(frozen=True)
class CasadiNumbers:
    """One of CasADi's solvers beside the MPC's own on the same problems.

    Attributes:
      compared: `QP solve` for QP against QP, `step` for a whole program against a step.
      time_ms: wall time of what is compared, ms.
      own_median_ms: the same of the MPC's own solver, median, ms.
      ratio: of the medians, CasADi's over the own.
    """

    name: str
    compared: str
    problems: int
    failures: int
    time_ms: Statistics
    iterations: Iterations | None
    deviation_percent: float | None
    own_median_ms: float
    ratio: float


@dataclass(frozen=True)
class PeakMemory:
    """The most memory that the process held until the end of the flight and of the benchmark, MiB."""

    flight: float
    benchmark: float


@dataclass(frozen=True)
class Summary:
    """A whole benchmark.

    Attributes:
      flight: what was flown.
      own: the MPC's own solver.
      without_exact_solution: how many problems no solver solved to 1e-9.
      plain: `PlainOsqp`.
      casadi: CasADi's solvers by name, if any; their key in the file is `peers`.
      growth: of the step over horizons, by solver.
      machine: system, processor and Python.
      versions: of the packages, by name.
      peak_memory_mib: of this process.
    """

    flight: FlightNumbers
    own: SolverNumbers
    without_exact_solution: int
    plain: SolverNumbers
    casadi: dict[str, CasadiNumbers]
    growth: dict[str, Growth]
    machine: dict[str, str]
    versions: dict[str, str]
    peak_memory_mib: PeakMemory

    @property
    def step_over_plain(self) -> float:
        """Median time of the own step over plain Drake's."""
        return self.own.step_ms.median / self.plain.step_ms.median

    def as_json(self) -> dict[str, Any]:
        """What the file holds: the own solver's numbers stand at its top, their deviation as `accuracy_percent`."""
        numbers = asdict(self)
        own, casadi = numbers.pop("own"), numbers.pop("casadi")
        own["accuracy_percent"] = own.pop("deviation_percent")
        for growth in numbers["growth"].values():
            growth |= {name: growth[name].tolist() for name in ("median_ms", "iterations")}
        ours = {"flight": numbers.pop("flight"), **own}
        ours |= {name: numbers.pop(name) for name in ("without_exact_solution", "plain")}
        return ours | {"step_over_plain": self.step_over_plain, "peers": casadi} | numbers


def peak_memory_mib() -> float:
    """The most memory that this process has held so far, MiB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)  # bytes on macOS, KiB elsewhere


def _flight_numbers(flight: Flight) -> FlightNumbers:
    metrics, clock = measure(flight), flight.wall_clock
    return FlightNumbers(
        law=metrics.law,
        solver=flight.scenario.mpc.solver,
        horizon=flight.scenario.mpc.horizon,
        duration_s=float(flight.time[-1]),
        failures=metrics.solver.failures,
        wall_s=metrics.wall_s,
        real_time_factor=metrics.real_time_factor,
        controller_ms=statistics_ms(clock.step) if clock is not None else None,
    )


def _solver_numbers(timing: Timing, exact: FloatArray, airframe: Airframe) -> SolverNumbers:
    """One contestant beside the exact inputs of all problems (n, 6)."""
    known = timing.iterations[np.isfinite(timing.iterations)]
    return SolverNumbers(
        problems=len(timing.places),
        failures=timing.failures,
        step_ms=statistics_ms(timing.total),
        split_ms={name: statistics_ms(part) for name, part in timing.parts.items()},
        iterations=Iterations(median=float(np.median(known)), max=int(known.max())) if known.size else None,
        deviation_percent=deviation_percent(timing.input, exact[timing.places], airframe),
    )


def _casadi_numbers(name: str, other: Timing, own: Timing, exact: FloatArray, airframe: Airframe) -> CasadiNumbers:
    mine = own.at(other.places)
    part = next(iter(other.parts))
    ours = mine.parts["solve"] if part == "solve" else mine.total
    numbers = _solver_numbers(other, exact, airframe)
    return CasadiNumbers(
        name=name,
        compared="QP solve" if part == "solve" else "step",
        problems=numbers.problems,
        failures=numbers.failures,
        time_ms=numbers.step_ms,
        iterations=numbers.iterations,
        deviation_percent=numbers.deviation_percent,
        own_median_ms=float(1e3 * np.median(ours)),
        ratio=float(np.median(other.total) / np.median(ours)),
    )


def summarise(
    flight: Flight,
    timings: Mapping[str, Timing],
    exact: FloatArray,
    growths: Mapping[str, Growth],
    memory_of_flight: float,
) -> Summary:
    """A whole benchmark, which ends now.

    Args:
      timings: of `own`, `plain`, and of CasADi's solvers, if any.
      exact: exact u_0 of each problem, Hz^2, shape (n, 6).
      memory_of_flight: `peak_memory_mib` after the flight.
    """
    airframe = flight.scenario.airframe
    packages = [name for name in ("a2s_drake", "drake", "piqp", "numpy", "scipy", "casadi") if is_installed(name)]
    return Summary(
        flight=_flight_numbers(flight),
        own=_solver_numbers(timings["own"], exact, airframe),
        without_exact_solution=int(np.isnan(exact).any(axis=1).sum()),
        plain=_solver_numbers(timings["plain"], exact, airframe),
        casadi={
            name: _casadi_numbers(name, timing, timings["own"], exact, airframe)
            for name, timing in timings.items()
            if name not in ("own", "plain")
        },
        growth=dict(growths),
        machine={"system": platform.system(), "processor": platform.machine(), "python": platform.python_version()},
        versions={name: version(name) for name in packages},
        peak_memory_mib=PeakMemory(flight=memory_of_flight, benchmark=peak_memory_mib()),
    )
