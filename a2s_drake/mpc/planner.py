"""One decision of the MPC: solve, and where that fails still answer with an input that the rotors can take."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from a2s_drake.airframe import hover_input
from a2s_drake.arrays import FloatArray
from a2s_drake.mpc.model import ATTITUDE, NUM_STATES, POSITION, RigidBodyModel
from a2s_drake.mpc.plan import Plan, Reference, hold, tracking_cost
from a2s_drake.mpc.program import input_bounds, state_bounds
from a2s_drake.mpc.solve import Solution, TrackingSolver, make_solver, solve_to_convergence
from a2s_drake.parameters import Airframe, Mpc

# States beyond this many times their bounds reach no solver. No plan could help there, and the dynamics overflow over
# the horizon, which solvers answer with anything from an error message to a crash.
_SOLVABLE_SHARE = 100.0


class Fallback(IntEnum):
    """Where an input came from: the problem as posed, or one of the stand-ins in the order they are tried."""

    NONE = 0
    SOFTENED = 1  # the same problem with the state bounds as penalties
    SHIFTED_PLAN = 2  # the previous plan, one period on
    HOVER = 3  # the rotor speeds that carry the level vehicle at rest


@dataclass(frozen=True)
class Decision:
    """A plan whose inputs lie within the rotor bounds, and how it came about.

    Attributes:
      plan: finite; its first input is the one to apply.
      fallback: NONE when the problem as posed was solved.
      iterations: of the solver, over all attempts.
      objective: the tracking cost J of the plan, finite; 0 where the reference is not.
    """

    plan: Plan
    fallback: Fallback
    iterations: int
    objective: float


class Planner:
    """Decides on a plan from a measured state, a reference and the previous plan.

    It never raises on numbers, and never answers with NaN or with an input outside the rotor bounds.
    """

    def __init__(self, airframe: Airframe, mpc: Mpc, solver: TrackingSolver | None = None) -> None:
        self.model = RigidBodyModel.of(airframe)
        self._mpc = mpc
        self._solver = solver or make_solver(self.model, airframe, mpc)
        self._input_bounds = input_bounds(airframe)
        self._solvable = _SOLVABLE_SHARE * np.abs(state_bounds(mpc)).max(axis=0)
        self._hover = hover_input(airframe)

    def hover_plan(self, x0: FloatArray) -> Plan:
        """Hover thrust held from a state (12,)."""
        return hold(x0, self._hover, self._mpc.horizon, self.model, self._mpc.period)

    def decide(self, x0: FloatArray, reference: Reference, previous: Plan | None) -> Decision:
        """One sample's decision.

        Args:
          x0: measured state, shape (12,).
          reference: targets from now on.
          previous: the plan of one period ago; None for a cold start, which then iterates to convergence. A caller
            passes None as well once a plan has been shifted to its end.
        """
        # States that are finite but absurd overflow on the way; what comes out is checked, so no warning is due.
        with np.errstate(over="ignore", invalid="ignore"):
            return self._decide(x0, reference, previous)

    def _decide(self, x0: FloatArray, reference: Reference, previous: Plan | None) -> Decision:
        if previous is not None and not previous.is_finite():
            previous = None
        iterations = 0
        if (np.abs(x0) <= self._solvable).all() and reference.is_finite():  # False for NaN
            guess = self.hover_plan(x0) if previous is None else previous.shifted()
            for fallback in (Fallback.NONE, Fallback.SOFTENED):
                cold = previous is None and fallback is Fallback.NONE
                solution = self._attempt(x0, reference, guess, cold=cold, soft=fallback is Fallback.SOFTENED)
                iterations += solution.iterations
                if solution.plan is not None and solution.plan.is_finite():
                    return self._decision(solution.plan, fallback, iterations, reference)
        if previous is not None:
            shifted = previous.shifted(self.model.step(previous.state[-1], previous.input[-1], self._mpc.period))
            if shifted.is_finite():
                return self._decision(shifted, Fallback.SHIFTED_PLAN, iterations, reference)
        return self._decision(self.hover_plan(_finite_start(x0)), Fallback.HOVER, iterations, reference)

    def _attempt(self, x0: FloatArray, reference: Reference, guess: Plan, *, cold: bool, soft: bool) -> Solution:
        try:
            if cold:
                return solve_to_convergence(self._solver, x0, reference, guess)
            return self._solver.solve(x0, reference, guess, soft=soft)
        except (Exception, SystemExit):  # noqa: BLE001 - a solver of any make may raise anything; the vehicle must fly
            return Solution(None, 0)  # SystemExit is what pydrake makes of a failed assertion in C++.

    def _decision(self, plan: Plan, fallback: Fallback, iterations: int, reference: Reference) -> Decision:
        plan = Plan(plan.state, np.clip(plan.input, *self._input_bounds))
        objective = tracking_cost(plan, reference, self._mpc) if reference.is_finite() else 0.0
        return Decision(plan, fallback, iterations, float(np.nan_to_num(objective)))


def _finite_start(x0: FloatArray) -> FloatArray:
    """A state to predict hover from: at rest, where and how the vehicle is as far as that is known."""
    start = np.zeros(NUM_STATES)
    for known in (POSITION, ATTITUDE):
        if np.isfinite(x0[known]).all():
            start[known] = x0[known]
    return start
