"""PIQP behind Drake's SolverInterface: convex quadratic programs, with a workspace kept between solves."""

import weakref
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from pydrake.solvers import (
    ClarabelSolver,
    GetProgramType,
    MathematicalProgram,
    MathematicalProgramResult,
    ProgramType,
    SolutionResult,
    SolverId,
    SolverInterface,
    SolverOptions,
)

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.packages import is_installed, require
from a2s_drake.solvers.quadratic_form import QuadraticForm

_ID = SolverId("PIQP")


class PiqpSolver(SolverInterface):
    """Solves convex QPs and LPs by PIQP, a proximal interior-point method (R. Schwan et al., CDC 2023).

    Its multistage backend factors the KKT system block by block along the variables. In a control problem whose
    variables are created in the order of time, its time is therefore linear in the horizon.

    One workspace is kept per program. With the option `preconditioner_iter` at 0, it takes over new linear costs, new
    bounds, and new coefficients within the sparsity of linear constraints. Other changes to a program are noticed, and
    the workspace is then set up anew. One change is not noticed: a binding that is removed, and its evaluator bound to
    other variables. A preconditioner would carry over from one set of numbers to the next, so with it the workspace is
    set up for each solve. Every solve starts cold: an answer depends only on the program, not on what was solved
    before, and the initial guess is ignored.

    Options, the call's before the program's, are the fields of PIQP's `Settings` under the solver's id; Drake's common
    options have no effect.

    Drake lets a Python solver write neither its id nor costs, details and dual solutions into a result. So
    `get_solver_id()` of the result says Clarabel, and `get_optimal_cost()` is NaN. The iterations are read from this
    object.
    """

    def __init__(self) -> None:
        SolverInterface.__init__(self)
        self._workspaces: WeakKeyDictionary[MathematicalProgram, _Workspace] = WeakKeyDictionary()
        self._iterations = 0
        self._last: tuple[MathematicalProgramResult, weakref.ref[MathematicalProgram], FloatArray] | None = None

    @property
    def iterations(self) -> int:
        """Interior-point iterations of the last solve."""
        return self._iterations

    @staticmethod
    def id() -> SolverId:
        """The id under which options are set."""
        return _ID

    def solver_id(self) -> SolverId:
        """See `id`."""
        return _ID

    def available(self) -> bool:
        """Whether the package piqp is installed."""
        return is_installed("piqp")

    def enabled(self) -> bool:
        """Always: PIQP needs no license."""
        return True

    def AreProgramAttributesSatisfied(self, prog: MathematicalProgram) -> bool:  # noqa: N802 - Drake's name
        """Whether a program is a linear or a convex quadratic one."""
        return GetProgramType(prog) in (ProgramType.kLP, ProgramType.kQP)

    def ExplainUnsatisfiedProgramAttributes(self, prog: MathematicalProgram) -> str:  # noqa: N802 - Drake's name
        """Why a program cannot be solved; empty when it can."""
        if self.AreProgramAttributesSatisfied(prog):
            return ""
        return f"PiqpSolver solves linear and convex quadratic programs, not one of type {GetProgramType(prog).name}."

    def Solve(  # noqa: N802 - Drake's name
        self,
        prog: MathematicalProgram,
        initial_guess: FloatArray | None = None,  # noqa: ARG002 - part of Drake's signature
        solver_options: SolverOptions | None = None,
        result: MathematicalProgramResult | None = None,
    ) -> MathematicalProgramResult:
        """Solves a program; writes into `result` where one is given.

        Raises:
          ModuleNotFoundError: when the package piqp is missing.
          ValueError: when the program is neither an LP nor a convex QP, or PIQP has no such option.
        """
        if reason := self.ExplainUnsatisfiedProgramAttributes(prog):
            raise ValueError(reason)
        given = (prog.solver_options(), solver_options or SolverOptions())
        options = {name: value for source in given for name, value in source.options.get(_ID.name(), {}).items()}
        workspace = self._workspaces.pop(prog, None)
        if workspace is None or not workspace.take_over(prog, options):
            workspace = _Workspace(prog, options)
        outcome, values = workspace.solve()
        self._iterations = workspace.iterations
        if outcome == SolutionResult.kSolutionFound:  # Else iterates that are not finite might linger in it.
            self._workspaces[prog] = workspace
        answer = MathematicalProgramResult() if result is None else result
        if not self._is_bound(answer, prog):
            _bind(answer, prog)
        answer.set_x_val(values)
        self._last = (answer, weakref.ref(prog), values)
        answer.set_solution_result(outcome)
        return answer

    def _is_bound(self, result: MathematicalProgramResult, prog: MathematicalProgram) -> bool:
        """Whether a result is known to speak of a program's variables: the last one of ours, still as we left it."""
        size = prog.num_vars()
        if self._last is None:
            return False
        mine, solved, values = self._last
        same_variables = mine is result and solved() is prog and values.size == size
        return same_variables and np.array_equal(result.get_x_val(), values)


class _Workspace:
    """PIQP set up for one program under one set of options."""

    def __init__(self, prog: MathematicalProgram, options: dict[str, Any]) -> None:
        piqp = require_piqp()
        self._outcomes = {
            piqp.PIQP_SOLVED: SolutionResult.kSolutionFound,
            piqp.PIQP_MAX_ITER_REACHED: SolutionResult.kIterationLimit,
            piqp.PIQP_PRIMAL_INFEASIBLE: SolutionResult.kInfeasibleConstraints,
            piqp.PIQP_DUAL_INFEASIBLE: SolutionResult.kDualInfeasible,
        }
        self._form, self._options = QuadraticForm(prog), dict(options)
        self._solver = piqp.SparseSolver()
        settings = {"kkt_solver": piqp.KKTSolver.sparse_multistage} | self._options
        for name, value in settings.items():
            if not hasattr(self._solver.settings, name):
                raise ValueError(f"PIQP has no option {name!r}")
            try:
                setattr(self._solver.settings, name, value)
            except TypeError as error:
                raise ValueError(f"PIQP's option {name!r} cannot be {value!r}") from error
        form = self._form
        self._solver.setup(form.P, form.c, form.A, form.b, form.G, form.h_l, form.h_u, form.x_l, form.x_u)

    def take_over(self, prog: MathematicalProgram, options: dict[str, Any]) -> bool:
        """Updates the numbers in place; False when that is not enough."""
        form = self._form
        if options != self._options or options.get("preconditioner_iter") != 0 or not form.refresh(prog):
            return False
        constraints = {"G": form.G, "h_l": form.h_l, "h_u": form.h_u} if form.G.nnz else {}
        self._solver.update(c=form.c, A=form.A, b=form.b, x_l=form.x_l, x_u=form.x_u, **constraints)
        return True

    def solve(self) -> tuple[SolutionResult, FloatArray]:
        """How it went, and the decision variables."""
        status = self._solver.solve()
        # A copy, since PIQP's own answer is a view of memory that its next solve overwrites.
        return self._outcomes.get(status, SolutionResult.kSolverSpecificError), self._solver.result.x.copy()

    @property
    def iterations(self) -> int:
        return self._solver.result.info.iter


def _bind(result: MathematicalProgramResult, prog: MathematicalProgram) -> None:
    """Tells a result which decision variables its numbers belong to.

    Only Drake's own solvers can. One that is given an initial guess of the wrong size has done so before it refuses.
    """
    try:
        ClarabelSolver().Solve(prog, np.zeros(prog.num_vars() + 1), None, result)
    except ValueError:
        return


def require_piqp() -> Any:
    """The module piqp.

    Raises:
      ModuleNotFoundError: that says what to install.
    """
    return require("piqp", "PiqpSolver needs the package piqp: pip install piqp")
