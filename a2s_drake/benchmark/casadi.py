"""Other solvers of the same tracking problem, by way of CasADi: what the MPC's own solvers are measured against."""

import contextlib
import io
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, triu, vstack

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.packages import require
from a2s_drake.common.signals import ANGULAR_VELOCITY, ATTITUDE, NUM_INPUTS, NUM_STATES, VELOCITY
from a2s_drake.control.horizon import Plan, Reference, state_weights
from a2s_drake.control.program import INPUT_SCALE, input_bounds, state_bounds
from a2s_drake.scenario.parts import GRAVITY, Airframe, Mpc
from a2s_drake.solvers.quadratic_form import QuadraticForm
from a2s_drake.vehicle.airframe import wrench_map

_STAGE = NUM_STATES + NUM_INPUTS

CASADI_QP_SOLVERS = ("hpipm", "qpoases", "osqp")


def _options(name: str, tolerance: float) -> dict[str, Any]:
    if name == "hpipm":
        # The residuals of stationarity, dynamics, bounds and complementarity. "speed" is the fastest of HPIPM's modes
        # that checks them all: "speed_abs" answers up to 5e-3 off. The multipliers here are of order one, and a barrier
        # that starts there instead of at ten spares an iteration or two.
        residuals = dict.fromkeys(("res_g_max", "res_b_max", "res_d_max", "res_m_max"), tolerance)
        return {"hpipm": {"mode": "speed", "mu0": 1.0, "iter_max": 100, **residuals}}
    if name == "qpoases":
        # An active-set method ends at the solution or not at all: no tolerance. Dense matrices cost it three times the
        # time from scratch, and its Schur complement method needs HSL's MA27.
        return {"sparse": True, "hessian_type": "posdef", "printLevel": "none"}
    # As the MPC sets Drake's own OSQP.
    settings = {"eps_abs": tolerance, "eps_rel": tolerance, "max_iter": 4000, "check_termination": 10}
    return {"osqp": {"verbose": False, **settings}}


@dataclass(frozen=True)
class CasadiAnswer:
    """What one of CasADi's solvers answers.

    Attributes:
      values: decision variables [x_0, u_0, x_1, ..., x_N], inputs in units of `INPUT_SCALE`.
      solved: whether the solver calls that a solution within its tolerance.
      seconds: wall time of filling in a sample's numbers and of the call.
      inner_seconds: the part of it that the solver itself says it spent; None where it says nothing.
      iterations: None where the solver does not say.
    """

    values: FloatArray
    solved: bool
    seconds: float
    inner_seconds: float | None
    iterations: int | None

    @property
    def plan(self) -> Plan:
        """The values as a plan."""
        stages = np.append(self.values, np.zeros(NUM_INPUTS)).reshape(-1, _STAGE)
        return Plan(stages[:, :NUM_STATES], INPUT_SCALE * stages[:-1, NUM_STATES:])


def require_casadi() -> Any:
    """The module casadi.

    Raises:
      ModuleNotFoundError: that says what to install.
    """
    return require("casadi", "CasADi's solvers need the package casadi: pip install 'a2s_drake[bench]'")


class CasadiQp:
    """A QP solver behind CasADi's `conic`, set up once for the structure of a hard `LinearizedProgram`.

    Arguments and results stand in CasADi's buffers, so a call costs little beyond the solver itself. HPIPM and OSQP
    start from scratch each time; qpOASES goes on from the active set of its last call.

    HPIPM expects the stages of an optimal control problem, and has no place for rows that fix x_0. For HPIPM the number
    x_0 is therefore put into the first stage. The other solvers get the QP unchanged.
    """

    def __init__(self, name: str, form: QuadraticForm, horizon: int, tolerance: float = 1e-5) -> None:
        """Sets a solver up.

        Args:
          name: one of `CASADI_QP_SOLVERS`.
          form: of a program of this horizon; its Hessian stays, all other numbers are read at each solve.
          tolerance: of residuals, absolute (and for OSQP relative as well), as `mpc.qp_tolerance`.
        Raises:
          ModuleNotFoundError: when the package casadi is missing.
          ValueError: when HPIPM is given a form that is not one of stages alone.
        """
        casadi = require_casadi()
        options = {"error_on_fail": False} | _options(name, tolerance)
        self._pinned = NUM_STATES if name == "hpipm" else 0
        if name == "hpipm":
            if form.G.shape[0] or form.P.shape[0] != _STAGE * horizon + NUM_STATES:
                raise ValueError("HPIPM takes the hard program alone, without slacks and inequalities")
            sizes = {"nx": [0] + [NUM_STATES] * horizon, "nu": [NUM_INPUTS] * horizon + [0], "ng": [0] * (horizon + 1)}
            options |= {"N": horizon} | sizes
        hessian = _sorted((form.P + triu(form.P, 1).T)[self._pinned :, self._pinned :])
        self._bind_rows(form)
        structure = {"h": _sparsity(casadi, hessian), "a": _sparsity(casadi, self._rows)}
        with contextlib.redirect_stdout(io.StringIO()):  # qpOASES introduces itself, twice.
            solver = casadi.conic("casadi_qp", name, structure, options)
            self._buffer, self._call = solver.buffer()
        self._values = np.zeros(form.P.shape[0])
        # HPIPM crashes where an argument or a result has no place, so all have one.
        self._in = {key: np.zeros(solver.numel_in(key)) for key in solver.name_in()}
        self._in |= {"h": hessian.data, "a": self._rows.data}
        results = {key: np.zeros(solver.numel_out(key)) for key in solver.name_out()}
        results["x"] = self._values[self._pinned :]
        self._results = [array.data for array in results.values()]
        for i, array in enumerate(self._in.values()):
            self._buffer.set_arg(i, array.data)
        self._inner_total = 0.0

    def _bind_rows(self, form: QuadraticForm) -> None:
        """Finds where each coefficient of A and G goes: into the solver's rows, or to x_0 where that is put in."""
        entries = np.arange(form.A.nnz + form.G.nnz)
        parts = np.split(entries + 1.0, [form.A.nnz])  # From 1, so that no entry looks like a zero.
        rows = zip(parts, (form.A, form.G), strict=True)
        stacked = csc_matrix(vstack([csc_matrix((part, m.indices, m.indptr), m.shape) for part, m in rows]))
        self._rows = _sorted(stacked[self._pinned :, self._pinned :])
        self._sources = self._rows.data.astype(int) - 1
        start = stacked[self._pinned :, : self._pinned].tocoo()
        self._start = (start.row, start.col, start.data.astype(int) - 1)

    def solve(self, form: QuadraticForm) -> CasadiAnswer:
        """Solves a form of the structure that the solver was set up for."""
        began = time.perf_counter()
        self._fill(form)
        for i, view in enumerate(self._results):  # Each time: HPIPM's interface changes the addresses.
            self._buffer.set_res(i, view)
        self._call()
        seconds = time.perf_counter() - began
        stats = self._buffer.stats()
        total = stats.get("t_wall_solver", 0.0)  # of all calls through this buffer
        inner, self._inner_total = total - self._inner_total, total
        iterations = max(stats.get("iter_count", 0), 0)  # 0 or -1 where CasADi does not pass them on.
        return CasadiAnswer(self._values.copy(), stats["success"], seconds, inner or None, iterations or None)

    def _fill(self, form: QuadraticForm) -> None:
        numbers, pinned = self._in, self._pinned
        coefficients = np.concatenate([form.A.data, form.G.data])
        np.take(coefficients, self._sources, out=numbers["a"])
        numbers["lba"][:] = np.concatenate([form.b, form.h_l])[pinned:]
        numbers["uba"][:] = np.concatenate([form.b, form.h_u])[pinned:]
        numbers["g"][:], numbers["lbx"][:], numbers["ubx"][:] = form.c[pinned:], form.x_l[pinned:], form.x_u[pinned:]
        if pinned:
            self._values[:pinned] = -form.b[:pinned]  # The first rows say -x_0 = b.
            rows, columns, places = self._start
            known = np.bincount(rows, coefficients[places] * self._values[columns], numbers["lba"].size)
            numbers["lba"] -= known
            numbers["uba"] -= known


def _sorted(matrix: Any) -> Any:
    matrix = csc_matrix(matrix)
    matrix.sort_indices()
    return matrix


def _sparsity(casadi: Any, matrix: Any) -> Any:
    return casadi.Sparsity(*matrix.shape, matrix.indptr.tolist(), matrix.indices.tolist())


class CasadiNlp:
    """IPOPT on the whole nonlinear program with exact Hessians, by CasADi's automatic differentiation.

    Multiple shooting over the same RK4 steps, cost, bounds and scaling as `NonlinearProgram`, written down once more in
    CasADi's symbols, and with the same tolerance and iteration limit as `mpc.solver: ipopt`.
    """

    def __init__(self, airframe: Airframe, mpc: Mpc) -> None:
        """Builds and differentiates the program.

        Raises:
          ModuleNotFoundError: when the package casadi is missing.
        """
        casadi = require_casadi()
        x, u = casadi.SX.sym("x", NUM_STATES, mpc.horizon + 1), casadi.SX.sym("u", NUM_INPUTS, mpc.horizon)
        target = casadi.SX.sym("target", NUM_STATES, mpc.horizon + 1)
        wanted = casadi.SX.sym("wanted", NUM_INPUTS, mpc.horizon)
        cost = casadi.dot(state_weights(mpc), casadi.sum2((x - target) ** 2))
        cost += mpc.input_weight * INPUT_SCALE**2 * casadi.sumsqr(u - wanted)
        step = _rk4_step(casadi, airframe, mpc.period).map(mpc.horizon)
        defects = casadi.vec(step(x[:, :-1], INPUT_SCALE * u) - x[:, 1:])
        variables = casadi.vertcat(casadi.vec(casadi.vertcat(x[:, :-1], u)), x[:, -1])
        settings = {"ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-6, "ipopt.max_iter": 300}
        options = {"print_time": False, "record_time": True, "error_on_fail": False} | settings
        program = {"x": variables, "p": casadi.vertcat(casadi.vec(target), casadi.vec(wanted)), "f": cost, "g": defects}
        self._solver = casadi.nlpsol("casadi_nlp", "ipopt", program, options)
        lower, upper = (np.broadcast_to(side, (mpc.horizon + 1, NUM_STATES)) for side in state_bounds(mpc))
        low, high = (np.full((mpc.horizon, NUM_INPUTS), side) for side in input_bounds(airframe))
        self._lower, self._upper = _values(Plan(lower, low)), _values(Plan(upper, high))

    def solve(self, x0: FloatArray, reference: Reference, guess: Plan) -> CasadiAnswer:
        """Solves from a measured state (12,), starting from a guessed plan."""
        began = time.perf_counter()
        target = np.concatenate([reference.state.ravel(), reference.input.ravel() / INPUT_SCALE])
        self._lower[:NUM_STATES] = self._upper[:NUM_STATES] = x0
        bounds = {"lbx": self._lower, "ubx": self._upper, "lbg": 0.0, "ubg": 0.0}
        answer = self._solver(x0=_values(guess), p=target, **bounds)
        seconds = time.perf_counter() - began
        stats = self._solver.stats()
        values = np.asarray(answer["x"]).ravel()
        return CasadiAnswer(values, stats["success"], seconds, stats["t_wall_total"], stats["iter_count"])


def _values(plan: Plan) -> FloatArray:
    """A plan as decision variables."""
    return np.append(np.hstack([plan.state[:-1], plan.input / INPUT_SCALE]).ravel(), plan.state[-1])


def _rk4_step(casadi: Any, airframe: Airframe, period: float) -> Any:
    """The function of x (12) and u (6, Hz^2) that gives the state one period (s) later."""
    x, u = casadi.SX.sym("x", NUM_STATES), casadi.SX.sym("u", NUM_INPUTS)
    slope = casadi.Function("slope", [x, u], [_slope(casadi, airframe, x, u)])
    first = slope(x, u)
    second = slope(x + period / 2.0 * first, u)
    third = slope(x + period / 2.0 * second, u)
    fourth = slope(x + period * third, u)
    following = x + period / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
    return casadi.Function("step", [x, u], [following])


def _slope(casadi: Any, airframe: Airframe, x: Any, u: Any) -> Any:
    """dx/dt: Newton in W, Euler in B, and the ZYX Euler angles' kinematics."""
    eta, velocity, omega = x[ATTITUDE], x[VELOCITY], x[ANGULAR_VELOCITY]
    (sr, sp, sy), (cr, cp, cy) = (casadi.vertsplit(wave(eta)) for wave in (casadi.sin, casadi.cos))
    R_x = _matrix(casadi, [[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    R_y = _matrix(casadi, [[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    R_z = _matrix(casadi, [[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    along = sr * omega[1] + cr * omega[2]  # the share of omega that pitch spreads between roll and yaw
    eta_dot = casadi.vertcat(omega[0] + along * sp / cp, cr * omega[1] - sr * omega[2], along / cp)
    wrench = casadi.DM(wrench_map(airframe)) @ u
    inertia = casadi.DM(airframe.inertia)
    acceleration = R_z @ R_y @ R_x @ wrench[:3] / airframe.mass - casadi.DM([0.0, 0.0, GRAVITY])
    omega_dot = (wrench[3:] - casadi.cross(omega, inertia * omega)) / inertia
    return casadi.vertcat(velocity, eta_dot, acceleration, omega_dot)


def _matrix(casadi: Any, rows: list[list[Any]]) -> Any:
    return casadi.vertcat(*(casadi.horzcat(*row) for row in rows))
