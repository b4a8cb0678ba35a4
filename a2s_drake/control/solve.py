"""Solvers of the tracking problem: real-time iteration on a QP solver, and IPOPT on the whole nonlinear program."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from pydrake.solvers import (
    IpoptSolver,
    MathematicalProgram,
    MathematicalProgramResult,
    OsqpSolver,
    SolverId,
    SolverOptions,
)

from a2s_drake.common.arrays import FloatArray
from a2s_drake.control.horizon import Plan, Reference
from a2s_drake.control.program import LinearizedProgram, NonlinearProgram
from a2s_drake.scenario.parts import Airframe, Mpc
from a2s_drake.solvers.piqp import PiqpSolver, require_piqp
from a2s_drake.vehicle.rigid_body import RigidBodyModel

# A softened program has kinked costs on every bounded state. When many bounds are broken at once, it takes this many
# times more iterations: the worst of 40 random states, up to half beyond all bounds, took 8180.
_SOFT_ITERATIONS = 5

# Where PIQP converges, it does so in some ten iterations. The scenario's limit is meant for OSQP's thousands.
_MAX_INTERIOR_ITERATIONS = 40

_GAP_SHARE = 1e-5  # of the relative duality gap in the tolerance

_OSQP_SOLVED = 1  # OSQP's status for a solution within tolerance; 2 is "inaccurate", which Drake reports as success.


@dataclass(frozen=True)
class Solution:
    """A solver's answer: the plan, or None where it found none, and the iterations it took.

    Drake does not pass on IPOPT's own count; its gradient evaluations, one an iteration and one before, stand in.
    """

    plan: Plan | None
    iterations: int


class TrackingSolver(Protocol):
    """Whatever solves the tracking problem."""

    def solve(self, x0: FloatArray, reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:
        """Solves from a measured state (12,), around or starting from a guessed plan; `soft` penalises state bounds."""
        ...


@dataclass(frozen=True)
class QpAnswer:
    """What a QP solver says: its result, whether that is a solution within tolerance, and the iterations it took."""

    result: MathematicalProgramResult
    solved: bool
    iterations: int


class QpSolver(Protocol):
    """Whatever solves the Gauss-Newton QP."""

    def solve(self, prog: MathematicalProgram, guess: FloatArray, *, soft: bool) -> QpAnswer:
        """Solves a program from a guess of its variables; `soft` tells the one with penalties on the state bounds."""
        ...


def _options(solver_id: SolverId, mpc: Mpc, iterations: int, **more: Any) -> SolverOptions:
    options = SolverOptions()
    settings = {"eps_abs": mpc.qp_tolerance, "eps_rel": mpc.qp_tolerance, "max_iter": iterations}
    for name, value in (settings | more).items():
        options.SetOption(solver_id, name, value)
    return options


class OsqpQp:
    """Drake's own OSQP (`mpc.solver: osqp`)."""

    def __init__(self, mpc: Mpc) -> None:
        self._osqp = OsqpSolver()
        limits = {False: mpc.qp_max_iterations, True: _SOFT_ITERATIONS * mpc.qp_max_iterations}
        # No polishing: it helps only where OSQP has guessed the active bounds, and at 1e-5 it is not needed.
        self._options = {
            soft: _options(OsqpSolver.id(), mpc, limit, polishing=0, check_termination=10)
            for soft, limit in limits.items()
        }

    def solve(self, prog: MathematicalProgram, guess: FloatArray, *, soft: bool) -> QpAnswer:
        """See `QpSolver.solve`."""
        result = self._osqp.Solve(prog, guess, self._options[soft])
        details = result.get_solver_details()
        return QpAnswer(result, result.is_success() and details.status_val == _OSQP_SOLVED, details.iter)


class PiqpQp:
    """PIQP with its workspace kept between solves (`mpc.solver: piqp`)."""

    def __init__(self, mpc: Mpc) -> None:
        require_piqp()
        self._piqp, self._results = PiqpSolver(), {soft: MathematicalProgramResult() for soft in (False, True)}
        limit = min(mpc.qp_max_iterations, _MAX_INTERIOR_ITERATIONS)
        # The hard program is well scaled. Without a preconditioner it takes 6 iterations instead of 9. Penalties and
        # slacks are badly scaled. With a preconditioner they take 15 iterations instead of 45, or more than the limit.
        # PIQP stops here by the duality gap. With its default it sometimes stops an iteration early, 0.07 % of the
        # rotor range off. The smaller gap costs 4 % of a step.
        gap = _GAP_SHARE * mpc.qp_tolerance
        self._options = {
            False: _options(PiqpSolver.id(), mpc, limit, preconditioner_iter=0, eps_duality_gap_rel=gap),
            True: _options(PiqpSolver.id(), mpc, limit, preconditioner_scale_cost=True),
        }

    def solve(self, prog: MathematicalProgram, guess: FloatArray, *, soft: bool) -> QpAnswer:
        """See `QpSolver.solve`."""
        # One result per program is used again and again, because setting up a new one costs as much as reading it.
        result = self._piqp.Solve(prog, guess, self._options[soft], self._results[soft])
        return QpAnswer(result, result.is_success(), self._piqp.iterations)


class RealTimeIteration:
    """One Gauss-Newton QP a call, linearised along the guess, full step."""

    def __init__(self, model: RigidBodyModel, airframe: Airframe, mpc: Mpc, qp: QpSolver) -> None:
        self._programs = {soft: LinearizedProgram(model, airframe, mpc, soft=soft) for soft in (False, True)}
        self._qp = qp

    def solve(self, x0: FloatArray, reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:
        """See `TrackingSolver.solve`."""
        program = self._programs[soft]
        # The first stage is expanded about the measured state itself, so its prediction is exact.
        around = guess.starting_at(x0)
        try:
            program.linearize(around)
        except FloatingPointError:  # The numbers are too large. The code is not at fault, so there is no warning.
            return Solution(None, 0)
        program.aim(reference)
        answer = self._qp.solve(program.prog, program.guess(around), soft=soft)
        return Solution(program.read(answer.result) if answer.solved else None, answer.iterations)


class WholeProgram:
    """The nonlinear program to IPOPT's tolerance at every call (`mpc.solver: ipopt`)."""

    def __init__(self, model: RigidBodyModel, airframe: Airframe, mpc: Mpc) -> None:
        self._programs = {soft: NonlinearProgram(model, airframe, mpc, soft=soft) for soft in (False, True)}
        self._ipopt = IpoptSolver()
        self._options = SolverOptions()
        self._options.SetOption(IpoptSolver.id(), "tol", 1e-6)
        self._options.SetOption(IpoptSolver.id(), "max_iter", 300)

    def solve(self, x0: FloatArray, reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:
        """See `TrackingSolver.solve`."""
        program = self._programs[soft]
        program.start_at(x0)
        program.aim(reference)
        before = program.gradient_evaluations
        result = self._ipopt.Solve(program.prog, program.guess(guess), self._options)
        iterations = program.gradient_evaluations - before
        return Solution(program.read(result) if result.is_success() else None, iterations)


QP_SOLVERS: dict[str, Callable[[Mpc], QpSolver]] = {"piqp": PiqpQp, "osqp": OsqpQp}


def make_solver(model: RigidBodyModel, airframe: Airframe, mpc: Mpc) -> TrackingSolver:
    """The solver that `mpc.solver` names.

    Raises:
      ModuleNotFoundError: when it needs a package that is missing.
    """
    if mpc.solver == "ipopt":
        return WholeProgram(model, airframe, mpc)
    return RealTimeIteration(model, airframe, mpc, QP_SOLVERS[mpc.solver](mpc))


def solve_to_convergence(
    solver: TrackingSolver, x0: FloatArray, reference: Reference, guess: Plan, *, limit: int = 10, change: float = 1e-4
) -> Solution:
    """Calls a solver around its own last answer until the answer stays put: SQP, where one call is one iteration.

    Args:
      limit: largest number of calls.
      change: the answer stays put when no squared rotor speed moves by more than this share of the largest.
    Returns:
      the last solution, with the iterations of all calls added up; without a plan as soon as one call fails.
    """
    iterations = 0
    for _ in range(limit):
        solution = solver.solve(x0, reference, guess)
        iterations += solution.iterations
        if solution.plan is None:
            return Solution(None, iterations)
        moved = np.abs(solution.plan.input - guess.input).max()
        guess = solution.plan
        if moved <= change * np.abs(guess.input).max():
            break
    return Solution(guess, iterations)
