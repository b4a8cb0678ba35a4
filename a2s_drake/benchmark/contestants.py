"""The solvers that are timed: each solves a recorded problem and says how long each part of it took."""

from dataclasses import dataclass
from time import perf_counter
from typing import Protocol, TypeVar

import numpy as np
from pydrake.solvers import MathematicalProgram

from a2s_drake.benchmark.casadi import CasadiNlp, CasadiQp
from a2s_drake.benchmark.plain import PlainOsqp
from a2s_drake.benchmark.record import TrackingProblem
from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.signals import NUM_INPUTS
from a2s_drake.control.horizon import Plan
from a2s_drake.control.program import LinearizedProgram
from a2s_drake.control.solve import QP_SOLVERS, QpAnswer, QpSolver, RealTimeIteration
from a2s_drake.scenario.parts import Airframe, Mpc
from a2s_drake.solvers.quadratic_form import QuadraticForm
from a2s_drake.vehicle.rigid_body import RigidBodyModel


@dataclass(frozen=True)
class Run:
    """One problem solved.

    Attributes:
      seconds: wall time of each part; `solve` takes a program whose numbers are updated to a solution.
      input: u_0 as solved for, Hz^2, shape (6,); NaN where there is no solution.
      iterations: NaN where the solver does not say.
    """

    seconds: dict[str, float]
    input: FloatArray
    iterations: float


Problem = TypeVar("Problem", contravariant=True)


class Contestant(Protocol[Problem]):
    """A solver of problems of some kind."""

    def run(self, problem: Problem) -> Run:
        """Solves a problem."""
        ...


def _first_input(plan: Plan | None) -> FloatArray:
    return np.full(NUM_INPUTS, np.nan) if plan is None else plan.input[0]


@dataclass(frozen=True)
class _ClockedModel(RigidBodyModel):
    """A model that marks when its linearisation begins and ends."""

    marks: list[float]

    def linearized_step(self, x: FloatArray, u: FloatArray, period: float) -> tuple[FloatArray, FloatArray]:
        self.marks.append(perf_counter())
        answer = super().linearized_step(x, u, period)
        self.marks.append(perf_counter())
        return answer


class _ClockedQp:
    """A QP solver that marks when it begins and ends."""

    def __init__(self, qp: QpSolver, marks: list[float]) -> None:
        self._qp, self._marks = qp, marks

    def solve(self, prog: MathematicalProgram, guess: FloatArray, *, soft: bool) -> QpAnswer:
        self._marks.append(perf_counter())
        answer = self._qp.solve(prog, guess, soft=soft)
        self._marks.append(perf_counter())
        return answer


class Own:
    """The MPC's own real-time iteration on the QP solver that `mpc.solver` names, in the four parts of a step."""

    def __init__(self, airframe: Airframe, mpc: Mpc) -> None:
        self._marks: list[float] = []
        plain = RigidBodyModel.of(airframe)
        model = _ClockedModel(plain.mass, plain.inertia, plain.wrench_map, self._marks)
        self._solver = RealTimeIteration(model, airframe, mpc, _ClockedQp(QP_SOLVERS[mpc.solver](mpc), self._marks))

    def run(self, problem: TrackingProblem) -> Run:
        """See `Contestant.run`."""
        self._marks.clear()
        begin = perf_counter()
        solution = self._solver.solve(problem.x0, problem.reference, problem.guess)
        end = perf_counter()
        linearise, linearised, solve, solved = self._marks
        seconds = {
            "linearise": linearised - linearise,
            "update": (solve - begin) - (linearised - linearise),
            "solve": solved - solve,
            "read_back": end - solved,
        }
        return Run(seconds, _first_input(solution.plan), solution.iterations)


class Plain:
    """`PlainOsqp`."""

    def __init__(self, airframe: Airframe, mpc: Mpc) -> None:
        self._plain = PlainOsqp(RigidBodyModel.of(airframe), airframe, mpc)

    def run(self, problem: TrackingProblem) -> Run:
        """See `Contestant.run`."""
        begin = perf_counter()
        self._plain.pose(problem.x0, problem.reference, problem.guess)
        posed = perf_counter()
        solution = self._plain.answer(problem.guess)
        seconds = {"pose": posed - begin, "solve": perf_counter() - posed}
        return Run(seconds, _first_input(solution.plan), solution.iterations)


class Conic:
    """A `CasadiQp` on the MPC's own QP. Only its `solve` is timed: reading the program's numbers, and the call."""

    def __init__(self, name: str, airframe: Airframe, mpc: Mpc) -> None:
        self._program = LinearizedProgram(RigidBodyModel.of(airframe), airframe, mpc)
        self._name, self._mpc = name, mpc
        self._form: QuadraticForm | None = None
        self._casadi: CasadiQp | None = None

    def run(self, problem: TrackingProblem) -> Run:
        """See `Contestant.run`."""
        self._program.linearize(problem.guess.starting_at(problem.x0))
        self._program.aim(problem.reference)
        if self._form is None or self._casadi is None:
            # Set up here, untimed, because a form needs numbers to find its sparsity.
            self._form = QuadraticForm(self._program.prog)
            self._casadi = CasadiQp(self._name, self._form, self._mpc.horizon, self._mpc.qp_tolerance)
        begin = perf_counter()
        if not self._form.refresh(self._program.prog):
            raise RuntimeError("the program changed its structure")
        answer = self._casadi.solve(self._form)
        seconds = perf_counter() - begin
        iterations = np.nan if answer.iterations is None else answer.iterations
        return Run({"solve": seconds}, _first_input(answer.plan if answer.solved else None), iterations)


class Whole:
    """`CasadiNlp`: the nonlinear program solved to the end, where others solve one QP."""

    def __init__(self, airframe: Airframe, mpc: Mpc) -> None:
        self._casadi = CasadiNlp(airframe, mpc)

    def run(self, problem: TrackingProblem) -> Run:
        """See `Contestant.run`."""
        answer = self._casadi.solve(problem.x0, problem.reference, problem.guess)
        iterations = np.nan if answer.iterations is None else answer.iterations
        return Run({"whole": answer.seconds}, _first_input(answer.plan if answer.solved else None), iterations)
