"""How the time of a step grows with the horizon."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from a2s_drake.benchmark.contestants import Own, Run
from a2s_drake.benchmark.record import TrackingProblem, record
from a2s_drake.benchmark.timing import time_interleaved
from a2s_drake.common.arrays import FloatArray
from a2s_drake.control.solve import QP_SOLVERS
from a2s_drake.flight import feasible
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.views.figures.style import column_figure, legend_above, styled

HORIZONS = (10, 20, 30, 60, 120)
_DURATION = 1.0  # s

_STYLES: dict[str, dict[str, Any]] = {
    "piqp": {"color": "#0072B2", "marker": "o", "linestyle": "-"},
    "osqp": {"color": "#D55E00", "marker": "s", "linestyle": "--"},
}


@dataclass(frozen=True)
class Growth:
    """Median step times, ms, over horizons, each (k,), with the line of least squares through them.

    Attributes:
      iterations: median number of solver iterations at each horizon, shape (k,).
      offset_ms, per_stage_ms: time = offset + per_stage N.
      r_squared: the share of the times' variance that the line explains.
      exponent: slope of log(time) over log(N).
    """

    horizons: tuple[int, ...]
    median_ms: FloatArray
    iterations: FloatArray
    offset_ms: float
    per_stage_ms: float
    r_squared: float
    exponent: float


def fit_growth(horizons: tuple[int, ...], median_ms: FloatArray, iterations: FloatArray) -> Growth:
    """The line through median times."""
    per_stage, offset = np.polyfit(horizons, median_ms, 1)
    residual = median_ms - (offset + per_stage * np.asarray(horizons))
    r_squared = 1.0 - residual @ residual / ((median_ms - median_ms.mean()) ** 2).sum()
    exponent = np.polyfit(np.log(horizons), np.log(median_ms), 1)[0]
    line = (float(value) for value in (offset, per_stage, r_squared, exponent))
    return Growth(horizons, median_ms, iterations, *line)


def growth_scenarios(scenario: Scenario) -> dict[int, Scenario]:
    """The start of a scenario's flight under each horizon, validated.

    Raises:
      ScenarioError: when one cannot be flown.
    """
    duration = min(_DURATION, scenario.duration)
    horizons = {n: scenario.with_overrides([f"mpc.horizon={n}", f"simulation.duration={duration}"]) for n in HORIZONS}
    return {n: feasible.check(changed) for n, changed in horizons.items()}


class _AtHorizon:
    """A solver at one horizon, who picks its own among the problems of all horizons at one sample."""

    def __init__(self, scenario: Scenario, solver: str) -> None:
        scenario = scenario.with_overrides([f"mpc.solver={solver}"])
        self._horizon, self._own = scenario.mpc.horizon, Own(scenario.airframe, scenario.mpc)

    def run(self, problems: Mapping[int, TrackingProblem]) -> Run:
        return self._own.run(problems[self._horizon])


def measure_growth(scenarios: Mapping[int, Scenario]) -> dict[str, Growth]:
    """Growth of each of `QP_SOLVERS` over `growth_scenarios`, all horizons and solvers by turns."""
    # The last problems: each flight has one a sample from the second on, and before it those of a cold start.
    recorded = {n: record(scenario)[1][::-1] for n, scenario in scenarios.items()}
    count = min(map(len, recorded.values()))
    samples = [{n: problems[k] for n, problems in recorded.items()} for k in range(count)]
    contestants = {
        f"{solver} {n}": _AtHorizon(scenario, solver) for n, scenario in scenarios.items() for solver in QP_SOLVERS
    }
    timings = time_interleaved(samples, contestants)
    horizons = tuple(scenarios)
    grown = {}
    for solver in QP_SOLVERS:
        mine = [timings[f"{solver} {n}"] for n in horizons]
        medians = np.array([1e3 * np.median(timing.total) for timing in mine])
        grown[solver] = fit_growth(horizons, medians, np.array([np.median(timing.iterations) for timing in mine]))
    return grown


@styled
def growth_figure(growths: Mapping[str, Growth]) -> Figure:
    """Median step time over the horizon, one line of least squares per solver."""
    figure = column_figure(2.3)
    axes = figure.add_subplot()
    for solver, growth in growths.items():
        style = _STYLES[solver]
        axes.plot(growth.horizons, growth.median_ms, color=style["color"], marker=style["marker"], ls="none", ms=3.5)
        ends = np.array([0.0, 1.05 * max(growth.horizons)])
        label = f"{solver}: {growth.offset_ms:.2f} ms + {growth.per_stage_ms:.3f} ms $N$"
        line = growth.offset_ms + growth.per_stage_ms * ends
        axes.plot(ends, line, color=style["color"], linestyle=style["linestyle"], label=label)
    axes.set_xlabel("horizon $N$")
    axes.set_ylabel("median step time (ms)")
    axes.set_ylim(bottom=0.0)
    legend_above(figure, axes, 1)
    return figure
