"""The whole benchmark: a flight, its problems solved by all, and growth with the horizon."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from a2s_drake.benchmark.accuracy import exact_inputs
from a2s_drake.benchmark.casadi import CASADI_QP_SOLVERS
from a2s_drake.benchmark.contestants import Conic, Contestant, Own, Plain, Whole
from a2s_drake.benchmark.growth import growth_scenarios, measure_growth
from a2s_drake.benchmark.record import TrackingProblem, record
from a2s_drake.benchmark.summary import Summary, peak_memory_mib, summarise
from a2s_drake.benchmark.timing import runs_in_a_row, spread, time_interleaved
from a2s_drake.control.solve import QP_SOLVERS
from a2s_drake.scenario.checks import ScenarioError
from a2s_drake.scenario.parts import Airframe, Mpc
from a2s_drake.scenario.scenario import Scenario

_MOST_BY_IPOPT = 40

# qpOASES takes a hundred times as long as the others. It goes on from the active set of its last problem, so it gets
# problems that follow each other, as from a controller. On problems far apart it takes five times as long again.
_RUNS_BY_QPOASES, _RUN_BY_QPOASES = 4, 5


@dataclass(frozen=True)
class Benchmark:
    """What to run.

    Attributes:
      scenario: validated.
      casadi_every: CasADi's solvers solve every how many-th problem, slow ones fewer; 0 leaves them out.
    """

    scenario: Scenario
    casadi_every: int

    def check(self) -> None:
        """Raises ScenarioError when the scenario cannot be benchmarked."""
        if self.scenario.mpc.solver not in QP_SOLVERS:
            raise ScenarioError(f"mpc.solver = {self.scenario.mpc.solver}: the benchmark times {', '.join(QP_SOLVERS)}")
        growth_scenarios(self.scenario)

    def run(self, progress: Callable[[str, int], Any]) -> Summary:
        """Runs it all.

        Args:
          progress: called with a stage's name and how many steps it takes; gives a function to call with each step.
        Raises:
          FlightEnded: when the flight does.
        """
        airframe, mpc = self.scenario.airframe, self.scenario.mpc
        # A progress function gets no name, so that its bar disappears when the stage ends.
        flight, problems = record(self.scenario, progress("flying", len(self.scenario.sample_times())))
        memory = peak_memory_mib()
        exact = exact_inputs(problems, airframe, mpc, progress("solving exactly", len(problems)))
        contestants: dict[str, Contestant[TrackingProblem]] = {"own": Own(airframe, mpc), "plain": Plain(airframe, mpc)}
        places: dict[str, NDArray[np.intp]] = {}
        if self.casadi_every:
            others = _casadi_solvers(airframe, mpc)
            contestants |= others
            places = {name: spread(len(problems), self.casadi_every, len(problems)) for name in others}
            places["ipopt"] = spread(len(problems), self.casadi_every, _MOST_BY_IPOPT)
            places["qpoases"] = runs_in_a_row(len(problems), _RUNS_BY_QPOASES, _RUN_BY_QPOASES)
        timings = time_interleaved(problems, contestants, places, progress("timing", len(problems)))
        growths = measure_growth(growth_scenarios(self.scenario))
        return summarise(flight, timings, exact, growths, memory)


def _casadi_solvers(airframe: Airframe, mpc: Mpc) -> dict[str, Contestant[TrackingProblem]]:
    conic = {name: Conic(name, airframe, mpc) for name in CASADI_QP_SOLVERS}
    return {**conic, "ipopt": Whole(airframe, mpc)}
