"""One decision of the MPC: solve, and where that fails still answer with an input that the rotors can take."""

import traceback
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.rotations import rotation_matrix
from a2s_drake.common.signals import ATTITUDE, NUM_STATES, POSITION, Fallback, State, by_part
from a2s_drake.control.horizon import Plan, Reference, hold, tracking_cost
from a2s_drake.control.program import input_bounds, state_bounds
from a2s_drake.control.solve import Solution, TrackingSolver, make_solver, solve_to_convergence
from a2s_drake.scenario.parts import Airframe, Mpc
from a2s_drake.vehicle.airframe import hover_input
from a2s_drake.vehicle.rigid_body import RigidBodyModel

# States beyond this many times their bounds reach no solver. No plan could help there. The dynamics would overflow over
# the horizon, and solvers answer that with anything from an error message to a crash.
_SOLVABLE_SHARE = 100.0

# Targets further away than this many times what the vehicle can cover within the horizon are drawn nearer. So are rates
# beyond this many times their bounds. The direction stays the same. Without this their pull would be too large for the
# solver's tolerance, and would outweigh the penalties of a softened program.
_REACH = 10.0

# A measured state is a surprise when it is further than this from the one that the last plan foresaw (m, rad of
# rotation, m/s, rad/s). To get that far in one period of 20 ms takes 25 g, or a blow that turns the vehicle by
# 500 rad/s^2.
_SURPRISE = np.array([1.0, 0.5, 5.0, 10.0])

# A surprise is believed when it is no further than this from where the measurement before it leads in one period. Most
# faults of a sensor contradict the dynamics at once: a vehicle that is really upside down falls.
_FOLLOWS = np.array([0.1, 0.1, 0.1, 0.5])

# Euler rates grow without limit towards a pitch of +-90 deg. Closer to it than this, rad, the pitch is taken to be this
# far off.
_OFF_SINGULARITY = 0.05


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

    It never raises on numbers, and never answers with NaN or with an input outside the rotor bounds. An exception in
    its solver counts as a failed attempt, and leads to one UserWarning for each type and line.
    """

    def __init__(self, airframe: Airframe, mpc: Mpc, solver: TrackingSolver | None = None) -> None:
        self.model = RigidBodyModel.of(airframe)
        self._mpc = mpc
        self._solver = solver or make_solver(self.model, airframe, mpc)
        self._input_bounds = input_bounds(airframe)
        self._solvable = _SOLVABLE_SHARE * np.abs(state_bounds(mpc)).max(axis=0)
        farthest = _REACH * mpc.velocity_limit * mpc.horizon * mpc.period
        rates = (_REACH * mpc.velocity_limit, _REACH * mpc.angular_velocity_limit)
        self._reach = by_part(farthest, np.pi, *rates)
        self._hover = hover_input(airframe)
        # These two affect only warnings: those already given, and those to give at the end of a decision.
        self._warned: set[tuple[str, str, int | None]] = set()
        self._untold: list[str] = []

    def hover_plan(self, x0: FloatArray) -> Plan:
        """Hover thrust held from a state (12,)."""
        return hold(x0, self._hover, self._mpc.horizon, self.model, self._mpc.period)

    def decide(
        self, x0: FloatArray, reference: Reference, previous: Plan | None, before: FloatArray | None = None
    ) -> Decision:
        """One sample's decision.

        A measured state far from what the previous plan foresaw is taken for a fault of the sensor. The previous plan
        then goes on until it is used up. The exception is a measurement that follows from the one before it, as after a
        blow to the vehicle: that one is believed.

        Args:
          x0: measured state, shape (12,).
          reference: targets from now on.
          previous: the plan of one period ago; None for a cold start, which then iterates to convergence. A caller
            passes None as well once a plan has been shifted to its end.
          before: the state measured one period ago, shape (12,); None where there was none.
        """
        try:
            # States that are finite but absurd overflow on the way. The result is checked, so no warning is needed.
            with np.errstate(over="ignore", invalid="ignore"):
                return self._decide(x0, reference, previous, before)
        finally:
            untold, self._untold = self._untold, []
            for words in untold:
                warnings.warn(words, stacklevel=2)

    def _decide(
        self, x0: FloatArray, reference: Reference, previous: Plan | None, before: FloatArray | None
    ) -> Decision:
        iterations = 0
        foreseen = previous is not None and _near(x0, previous.state[1], _SURPRISE)
        usable = (np.abs(x0) <= self._solvable).all() and reference.is_finite()  # False for NaN
        if usable and (foreseen or previous is None or self._follows(x0, before, previous)):
            guess = previous.shifted() if previous is not None and foreseen else None
            for fallback, solution in self._attempts(_in_chart(x0), reference, guess):
                iterations += solution.iterations
                if solution.plan is not None and solution.plan.is_finite():
                    return self._decision(solution.plan, fallback, iterations, reference)
        if previous is not None:
            shifted = previous.shifted(self.model.step(previous.state[-1], previous.input[-1], self._mpc.period))
            if shifted.is_finite():
                return self._decision(shifted, Fallback.SHIFTED_PLAN, iterations, reference)
        return self._decision(self.hover_plan(_finite_start(x0)), Fallback.HOVER, iterations, reference)

    def _follows(self, x0: FloatArray, before: FloatArray | None, previous: Plan) -> bool:
        """Whether a measured state is where the one before it leads under the input applied since."""
        if before is None:
            return False
        return _near(x0, self.model.step(before, previous.input[0], self._mpc.period), _FOLLOWS)

    def _attempts(
        self, x0: FloatArray, reference: Reference, guess: Plan | None
    ) -> Iterator[tuple[Fallback, Solution]]:
        """Ways to solve the problem, best first. The caller stops at the first one that works."""
        centre = np.zeros(NUM_STATES)
        centre[POSITION] = x0[POSITION]  # Any position is allowed; attitude and rates should be small.
        target = reference.within(centre, self._reach, self._input_bounds[1])
        if guess is not None and np.abs(x0[ATTITUDE] - guess.state[0, ATTITUDE]).max() > 1.0:
            guess = None  # It describes the same attitudes by other Euler angles.
        start = guess or self.hover_plan(x0)
        yield Fallback.NONE, self._attempt(x0, target, start, cold=guess is None, soft=False)
        yield Fallback.SOFTENED, self._attempt(x0, target, start, cold=False, soft=True)
        if guess is not None:
            yield Fallback.SOFTENED, self._attempt(x0, target, self.hover_plan(x0), cold=False, soft=True)

    def _attempt(self, x0: FloatArray, reference: Reference, guess: Plan, *, cold: bool, soft: bool) -> Solution:
        try:
            if cold:
                return solve_to_convergence(self._solver, x0, reference, guess)
            return self._solver.solve(x0, reference, guess, soft=soft)
        except Exception as error:  # noqa: BLE001 - a solver of any make may raise anything; the vehicle must fly
            self._note_once(error)
        except SystemExit as error:
            if not isinstance(error.code, str):
                raise  # The user, or a program, wants the process to end.
            self._note_once(error)  # pydrake makes this of a failed assertion in C++, with its text as the code.
        return Solution(None, 0)

    def _note_once(self, error: BaseException) -> None:
        """Notes a warning of an exception in the solver, once for each type and line that raises it."""
        text = " ".join(f"{type(error).__name__}: {error}".split())
        place = traceback.extract_tb(error.__traceback__)[-1]
        cause = (type(error).__name__, place.filename, place.lineno)
        if cause not in self._warned:
            self._warned.add(cause)
            where = f"{Path(place.filename).name}, line {place.lineno}"
            what = f"the solver raised {text} ({where})"
            self._untold.append(f"{what}; the planner falls back, and tells of this error only once")

    def _decision(self, plan: Plan, fallback: Fallback, iterations: int, reference: Reference) -> Decision:
        plan = Plan(plan.state, np.clip(plan.input, *self._input_bounds))
        objective = tracking_cost(plan, reference, self._mpc) if reference.is_finite() else 0.0
        return Decision(plan, fallback, iterations, float(np.nan_to_num(objective)))


def _near(x0: FloatArray, expected: FloatArray, limits: FloatArray) -> bool:
    """Whether a state (12,) is within limits (m, rad of rotation, m/s, rad/s) of the expected one."""
    position, angle, velocity, rate = (part.max() for part in State(np.abs(x0 - expected)).parts)
    if 2.0 * angle > limits[1]:  # Euler angles may jump though the vehicle does not: compare rotations.
        R_XM = rotation_matrix(expected[ATTITUDE]).T @ rotation_matrix(x0[ATTITUDE])
        angle = np.arccos(np.clip(0.5 * (np.trace(R_XM) - 1.0), -1.0, 1.0))
    return bool((np.array([position, angle, velocity, rate]) <= limits).all())  # False for NaN


def _in_chart(x0: FloatArray) -> FloatArray:
    """The same state in the Euler angles of the bounds: pitch within +-90 deg, and off the singularity."""
    largest = np.array([np.pi, 0.5 * np.pi - _OFF_SINGULARITY, np.pi])
    if (np.abs(x0[ATTITUDE]) <= largest).all():
        return x0
    eta = np.remainder(x0[ATTITUDE] + np.pi, 2.0 * np.pi) - np.pi
    if np.abs(eta[1]) > 0.5 * np.pi:  # Half a turn of roll and of yaw make pitch its supplement.
        eta = np.remainder(eta * [1.0, -1.0, 1.0], 2.0 * np.pi) - np.pi
    moved = x0.copy()
    moved[ATTITUDE] = np.clip(eta, -largest, largest)
    return moved


def _finite_start(x0: FloatArray) -> FloatArray:
    """A state to predict hover from: at rest, with the position and the attitude that are measured, if finite."""
    start = np.zeros(NUM_STATES)
    for known in (POSITION, ATTITUDE):
        if np.isfinite(x0[known]).all():
            start[known] = x0[known]
    return start
