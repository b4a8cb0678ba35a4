"""Solvers of the tracking problem: real-time iteration on OSQP, and IPOPT on the whole nonlinear program."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from pydrake.solvers import IpoptSolver, OsqpSolver, SolverOptions

from a2s_drake.arrays import FloatArray
from a2s_drake.mpc.model import RigidBodyModel
from a2s_drake.mpc.plan import Plan, Reference
from a2s_drake.mpc.program import LinearizedProgram, NonlinearProgram
from a2s_drake.parameters import Airframe, Mpc

# A softened program has kinked costs on every bounded state, and takes this many times more iterations when many bounds
# are broken at once (the worst of 40 random states up to half beyond all bounds took 8180).
_SOFT_ITERATIONS = 5

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


def _osqp_options(tolerance: float, iterations: int) -> SolverOptions:
    options = SolverOptions()
    settings = {"eps_abs": tolerance, "eps_rel": tolerance, "max_iter": iterations}
    # No polishing: it helps only where OSQP has guessed the active bounds, and at 1e-5 the answer needs no help.
    for name, value in (settings | {"polishing": 0, "check_termination": 10}).items():
        options.SetOption(OsqpSolver.id(), name, value)
    return options


class RealTimeIteration:
    """One Gauss-Newton QP a call, linearised along the guess, full step (`mpc.solver: osqp`)."""

    def __init__(self, model: RigidBodyModel, airframe: Airframe, mpc: Mpc) -> None:
        self._programs = {soft: LinearizedProgram(model, airframe, mpc, soft=soft) for soft in (False, True)}
        self._osqp = OsqpSolver()
        self._options = {
            False: _osqp_options(mpc.qp_tolerance, mpc.qp_max_iterations),
            True: _osqp_options(mpc.qp_tolerance, _SOFT_ITERATIONS * mpc.qp_max_iterations),
        }

    def solve(self, x0: FloatArray, reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:
        """See `TrackingSolver.solve`."""
        program = self._programs[soft]
        # The first stage is expanded about the measured state itself, so its prediction is exact.
        around = Plan(np.vstack([x0, guess.state[1:]]), guess.input)
        program.linearize(around)
        program.aim(x0, reference)
        result = self._osqp.Solve(program.prog, program.guess(around), self._options[soft])
        details = result.get_solver_details()
        solved = result.is_success() and details.status_val == _OSQP_SOLVED
        return Solution(program.read(result) if solved else None, details.iter)


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
        program.aim(x0, reference)
        before = program.gradient_evaluations
        result = self._ipopt.Solve(program.prog, program.guess(guess), self._options)
        iterations = program.gradient_evaluations - before
        return Solution(program.read(result) if result.is_success() else None, iterations)


_SOLVERS: dict[str, type[RealTimeIteration] | type[WholeProgram]] = {"osqp": RealTimeIteration, "ipopt": WholeProgram}


def make_solver(model: RigidBodyModel, airframe: Airframe, mpc: Mpc) -> TrackingSolver:
    """The solver that `mpc.solver` names."""
    return _SOLVERS[mpc.solver](model, airframe, mpc)


def solve_to_convergence(
    solver: TrackingSolver, x0: FloatArray, reference: Reference, guess: Plan, *, limit: int = 20, change: float = 1e-4
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
