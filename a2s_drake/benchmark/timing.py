"""Timing of several solvers over the same problems, by turns, so that noise of the machine hits all alike."""

import gc
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from a2s_drake.benchmark.contestants import Contestant, Run
from a2s_drake.common.arrays import FloatArray

Problem = TypeVar("Problem")


@dataclass(frozen=True)
class Timing:
    """One contestant's runs.

    Attributes:
      places: which of the problems it solved, shape (m,).
      parts: wall time of each part, s, each shape (m,).
      input: u_0 of each, Hz^2, shape (m, 6); NaN where there was no solution.
      iterations: shape (m,); NaN where unknown.
    """

    places: NDArray[np.intp]
    parts: dict[str, FloatArray]
    input: FloatArray
    iterations: FloatArray

    @property
    def total(self) -> FloatArray:
        """Wall time of all parts together, s, shape (m,)."""
        return np.asarray(sum(self.parts.values()))

    @property
    def failures(self) -> int:
        """How many problems went without a solution."""
        return int(np.isnan(self.input).any(axis=1).sum())

    def at(self, places: NDArray[np.intp]) -> "Timing":
        """The runs on some of the problems alone."""
        rows = np.isin(self.places, places)
        parts = {name: part[rows] for name, part in self.parts.items()}
        return Timing(self.places[rows], parts, self.input[rows], self.iterations[rows])


def spread(count: int, every: int, at_most: int) -> NDArray[np.intp]:
    """Every `every`-th of some problems, thinned out evenly to no more than `at_most`."""
    places = np.arange(0, count, every)
    return places[:: max(1, -(-len(places) // at_most))]


def runs_in_a_row(count: int, runs: int, length: int) -> NDArray[np.intp]:
    """Evenly spread runs of consecutive problems, as far as there are so many."""
    starts = np.linspace(0, max(0, count - length), runs).astype(int)
    places = np.unique(starts[:, np.newaxis] + np.arange(length))
    return places[places < count]


def time_interleaved(
    problems: Sequence[Problem],
    contestants: Mapping[str, Contestant[Problem]],
    places: Mapping[str, NDArray[np.intp]] | None = None,
    progress: Callable[[int], Any] | None = None,
    turn: int = 20,
) -> dict[str, Timing]:
    """Times contestants, who take turns at every few problems.

    Each first solves its first problem once untimed, so that no set-up is timed.

    Args:
      places: which problems a contestant is given; all, where it is not named.
      progress: called with 1 after each problem.
    """
    chosen = {name: np.arange(len(problems)) for name in contestants} | dict(places or {})
    due = {name: set(chosen[name].tolist()) for name in contestants}
    runs: dict[str, list[Run]] = {name: [] for name in contestants}
    for name, contestant in contestants.items():
        contestant.run(problems[chosen[name][0]])
    with _quiet_collector():
        for first in range(0, len(problems), turn):
            now = range(first, min(first + turn, len(problems)))
            for name, contestant in contestants.items():
                runs[name] += [contestant.run(problems[k]) for k in now if k in due[name]]
            if progress is not None:
                progress(len(now))
    return {name: _collect(chosen[name], mine) for name, mine in runs.items()}


@contextmanager
def _quiet_collector() -> Iterator[None]:
    """Python's garbage collector stays on, but is spared what was there before."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


def _collect(places: NDArray[np.intp], runs: Sequence[Run]) -> Timing:
    parts = {name: np.array([run.seconds[name] for run in runs]) for name in runs[0].seconds}
    return Timing(
        places, parts, np.array([run.input for run in runs]), np.array([float(run.iterations) for run in runs])
    )


@dataclass(frozen=True)
class Statistics:
    """Median, 99th and 99.9th percentile and maximum of some times."""

    median: float
    p99: float
    p99_9: float
    max: float


def statistics_ms(seconds: FloatArray) -> Statistics:
    """Statistics of times, s, in ms."""
    return Statistics(*(1e3 * np.percentile(seconds, [50.0, 99.0, 99.9, 100.0])).tolist())
