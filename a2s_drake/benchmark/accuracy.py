"""How far an applied input lies from the exact solution of its QP."""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from a2s_drake.benchmark.record import TrackingProblem
from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.signals import NUM_INPUTS
from a2s_drake.control.program import input_bounds
from a2s_drake.control.solve import make_solver
from a2s_drake.scenario.parts import Airframe, Mpc
from a2s_drake.vehicle.rigid_body import RigidBodyModel

_EXACT = 1e-9
_MANY = 20_000  # iterations; OSQP takes some hundreds to get there


def exact_inputs(
    problems: Sequence[TrackingProblem], airframe: Airframe, mpc: Mpc, progress: Callable[[int], Any] | None = None
) -> FloatArray:
    """u_0 of each problem's QP solved to 1e-9, Hz^2, shape (n, 6); NaN where neither OSQP nor PIQP gets there.

    By the method that the MPC does not use, where that converges: a solver is no oracle of itself.

    Args:
      progress: called with 1 after each problem.
    """
    names = ("piqp", "osqp") if mpc.solver == "osqp" else ("osqp", "piqp")
    tight = dataclasses.replace(mpc, qp_tolerance=_EXACT, qp_max_iterations=_MANY)
    model = RigidBodyModel.of(airframe)
    solvers = [make_solver(model, airframe, dataclasses.replace(tight, solver=name)) for name in names]
    inputs = np.full((len(problems), NUM_INPUTS), np.nan)
    for k, problem in enumerate(problems):
        for solver in solvers:
            plan = solver.solve(problem.x0, problem.reference, problem.guess).plan
            if plan is not None:
                inputs[k] = plan.input[0]
                break
        if progress is not None:
            progress(1)
    return inputs


def deviation_percent(inputs: FloatArray, exact: FloatArray, airframe: Airframe) -> float | None:
    """Largest deviation of applied inputs from exact ones, in % of the rotors' range of squared speeds.

    Both are clipped to that range, as what is applied is. Rows without a solution do not count.

    Args:
      inputs: what was applied, Hz^2, shape (n, 6).
      exact: what should have been, Hz^2, shape (n, 6).
    Returns:
      None where no row counts.
    """
    low, high = input_bounds(airframe)
    off = np.abs(np.clip(inputs, low, high) - np.clip(exact, low, high)).max(axis=1)
    off = off[np.isfinite(off)]
    return float(100.0 * off.max() / (high - low)) if off.size else None
