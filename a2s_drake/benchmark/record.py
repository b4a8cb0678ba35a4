"""The tracking problems that a flight poses, recorded as it poses them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.wiring import mark_own_blocks
from a2s_drake.control.controller import MpcController
from a2s_drake.control.horizon import Plan, Reference
from a2s_drake.control.ladder import Planner
from a2s_drake.control.solve import Solution, TrackingSolver, make_solver
from a2s_drake.diagrams import Blocks, build_closed_loop
from a2s_drake.flight.log import Flight, FlightEnded
from a2s_drake.flight.run import run_flight
from a2s_drake.guidance.laws import find_law
from a2s_drake.guidance.plan.cache import plan_for_law
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.vehicle.rigid_body import RigidBodyModel


@dataclass(frozen=True)
class TrackingProblem:
    """What a solver is asked: the measured state (12,), the targets, and the plan to linearise about."""

    x0: FloatArray
    reference: Reference
    guess: Plan


class _Recorder:
    """A solver that keeps the hard problems it is asked to solve."""

    def __init__(self, solver: TrackingSolver) -> None:
        self._solver = solver
        self.problems: list[TrackingProblem] = []

    def solve(self, x0: FloatArray, reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:
        """See `TrackingSolver.solve`."""
        solution = self._solver.solve(x0, reference, guess, soft=soft)
        if not soft:  # Recorded only after the solve: a problem whose linearisation overflows cannot be timed.
            self.problems.append(TrackingProblem(x0.copy(), reference, guess))
        return solution


def record(scenario: Scenario, progress: Callable[[int], Any] | None = None) -> tuple[Flight, list[TrackingProblem]]:
    """Flies a validated scenario and records its problems as posed, without those with softened bounds.

    There is one a sample. The first sample has some more, because its cold start iterates.

    Args:
      progress: called with 1 after each sample.
    Raises:
      FlightEnded: see `run_flight`; and when there was no problem to record.
    """
    airframe, mpc, law = scenario.airframe, scenario.mpc, find_law(scenario.attitude_law.name)
    recorder = _Recorder(make_solver(RigidBodyModel.of(airframe), airframe, mpc))
    planner, fed = Planner(airframe, mpc, recorder), law.needs_plan and mpc.feedforward
    blocks = Blocks(controller=lambda _: MpcController(airframe, mpc, planner, feedforward=fed))
    diagram = build_closed_loop(scenario, blocks=blocks, plan=plan_for_law(scenario))
    mark_own_blocks(diagram, {})  # The library's own controller flies, and is only recorded.
    flight = run_flight(diagram, scenario, progress)
    if not recorder.problems:
        raise FlightEnded("the flight posed no problem that could be linearised", flight)
    return flight, recorder.problems
