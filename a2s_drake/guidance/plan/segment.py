"""A segment of the mission as a function of the control points that shape it: throughput, limits, derivatives.

The whole mission is one segment; IPOPT is given several short ones, so that each of its functions knows few variables.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from a2s_drake.common.arrays import FloatArray
from a2s_drake.guidance.path import uav_path
from a2s_drake.guidance.plan.limits import NUM_USES, Limits
from a2s_drake.guidance.plan.spline import SUPPORT, SplineGrid
from a2s_drake.link.throughput import efficiency_derivatives
from a2s_drake.scenario.checks import refuse
from a2s_drake.scenario.parts import Planning
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.vehicle.flatness import FlatMap
from a2s_drake.world.ship import ship_track

# Entries of the control points that shape one interval: four points, three angles each.
SHAPE = 3 * SUPPORT


def check_plannable(scenario: Scenario) -> None:
    """Checks that a scenario can be planned.

    Raises:
      ScenarioError: when it names a track file: the planner knows the circle and the line alone.
    """
    for name in ("path_file", "ship_track_file"):
        if (file := getattr(scenario.mission, name)) is not None:
            raise refuse(f"mission.{name}", file, "the planner knows the circle and the line alone; must be null")


@dataclass(frozen=True)
class Task:
    """What is planned: a scenario, its spline grid, the limits with their margins, and the penalty on acceleration."""

    scenario: Scenario
    grid: SplineGrid
    limits: Limits
    flat: FlatMap
    planning: Planning

    @classmethod
    def of(cls, scenario: Scenario) -> "Task":
        """The task of a scenario: its mission from take-off to the end, whatever part of it is flown.

        Raises:
          ScenarioError: as `check_plannable`.
        """
        check_plannable(scenario)
        planning = scenario.planning
        grid = SplineGrid.of(scenario.mission.duration, planning.knot_spacing)
        return cls(scenario, grid, Limits.of(scenario), FlatMap.of(scenario.airframe), planning)

    def limit_times(self) -> FloatArray:
        """Instants at which the limits are imposed, s: every knot, where torque has its kinks, and some between."""
        between = int(np.ceil(self.grid.spacing / self.planning.limit_spacing - 1e-9))
        return np.linspace(0.0, self.grid.duration, self.grid.intervals * between + 1)


class Segment:
    """Intervals `first`..`last`-1 of a task, shaped by control points first..last+2, passed as (last-first+3, 3)."""

    def __init__(self, task: Task, first: int = 0, last: int | None = None) -> None:
        self.first, self.last = first, task.grid.intervals if last is None else last
        self._link, self._period = task.scenario.link, task.scenario.mpc.period
        self._limits, self._flat = task.limits, task.flat
        self._bending = task.planning.acceleration_weight * task.grid.bending()
        self.shape_of_interval = np.arange(self.last - first)[:, np.newaxis] + np.arange(SUPPORT)
        self._place_samples(task)
        self._place_limits(task)

    def _place_samples(self, task: Task) -> None:
        time = task.scenario.samples_until(task.grid.duration)
        interval, inside = task.grid.locate(time)
        kept = self._holds(interval)
        time, interval = time[kept], interval[kept] - self.first
        self._position = uav_path(task.scenario.mission).position(time)
        self._ship = ship_track(task.scenario.mission).position(time)
        self._weights = task.grid.weights(inside[kept], 0)
        self._shape_of_sample = self.shape_of_interval[interval]
        ones = (np.ones(time.size), (interval, np.arange(time.size)))
        self._sum_by_interval = csr_matrix(ones, (self.last - self.first, time.size))

    def _place_limits(self, task: Task) -> None:
        time = task.limit_times()
        interval, inside = task.grid.locate(time)
        weights = np.stack([task.grid.weights(inside, order) for order in range(3)], axis=1)
        acceleration = uav_path(task.scenario.mission).acceleration(time)
        # Once more the end, as it is from then on: the path's acceleration and the attitude's have both ceased.
        interval = np.append(interval, interval[-1])
        weights = np.concatenate([weights, weights[-1:] * np.array([1.0, 1.0, 0.0])[:, np.newaxis]])
        acceleration = np.vstack([acceleration, np.zeros(3)])
        kept = self._holds(interval)
        self._motion_weights, self._acceleration = weights[kept], acceleration[kept]
        self.interval_of_limit = interval[kept] - self.first
        self.shape_of_limit = self.shape_of_interval[self.interval_of_limit]

    def _holds(self, interval: NDArray[np.int64]) -> NDArray[np.bool_]:
        return (interval >= self.first) & (interval < self.last)

    def eta(self, control: FloatArray) -> FloatArray:
        """Attitude at the samples, rad, shape (samples, 3)."""
        return np.einsum("nj,njd->nd", self._weights, control[self._shape_of_sample])

    def throughput(self, control: FloatArray) -> float:
        """Sum of log2(1 + SNR) over the samples times their period, bit/Hz."""
        value, _, _ = efficiency_derivatives(self._position, self._ship, self.eta(control), self._link)
        return float(self._period * value.sum())

    def cost(self, control: FloatArray) -> float:
        """Penalty on acceleration less throughput, bit/Hz."""
        shape = control[self.shape_of_interval]
        return float(np.einsum("kid,ij,kjd->", shape, self._bending, shape)) - self.throughput(control)

    def cost_gradient(self, control: FloatArray) -> tuple[float, FloatArray]:
        """`cost` and its gradient, shaped as `control`."""
        cost, shares, _ = self.cost_model(control)
        gradient = np.zeros_like(control)
        np.add.at(gradient, self.shape_of_interval, shares.reshape(-1, SUPPORT, 3))
        return cost, gradient

    def cost_model(self, control: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """`cost`, and per interval its share of the gradient, (K, 12), and of a convex model's Hessian, (K, 12, 12).

        The Hessian by attitude is the exact one at each sample with negative curvature set to zero: near a peak of the
        interference Newton's, in a fade flat.
        """
        value, slope, curvature = efficiency_derivatives(self._position, self._ship, self.eta(control), self._link)
        eigenvalues, axes = np.linalg.eigh(-curvature)
        convex = (axes * np.maximum(eigenvalues, 0.0)[:, np.newaxis]) @ np.swapaxes(axes, 1, 2)
        pull = np.einsum("nj,nd->njd", self._weights, slope).reshape(-1, SHAPE)
        bowl = np.einsum("ni,nj,nde->nidje", self._weights, self._weights, convex).reshape(-1, SHAPE**2)
        bending = np.kron(2.0 * self._bending, np.eye(3))
        shape = control[self.shape_of_interval].reshape(-1, SHAPE)
        bent = 0.5 * float(np.einsum("ki,ij,kj->", shape, bending, shape))
        return (
            bent - float(self._period * value.sum()),
            shape @ bending - self._period * (self._sum_by_interval @ pull),
            bending + self._period * (self._sum_by_interval @ bowl).reshape(-1, SHAPE, SHAPE),
        )

    def use(self, control: FloatArray) -> FloatArray:
        """Use of each limit, kept from -1 to 1, shape (limit samples, 12)."""
        return self._limits.use(self._flat, self._motion(control), self._acceleration)

    def use_slopes(self, control: FloatArray) -> FloatArray:
        """Derivative of `use` by the control points that shape each one, shape (limit samples, 12, 12)."""
        slopes = self._limits.use_slopes(self._flat, self._motion(control), self._acceleration)
        by_order = slopes.reshape(-1, NUM_USES, 3, 3)
        return np.einsum("nrod,noj->nrjd", by_order, self._motion_weights).reshape(-1, NUM_USES, SHAPE)

    def _motion(self, control: FloatArray) -> FloatArray:
        return np.einsum("noj,njd->nod", self._motion_weights, control[self.shape_of_limit]).reshape(-1, 9)

    def excess(self, control: FloatArray) -> FloatArray:
        """Largest excess over a limit in each interval, in units of the limit, shape (K,); zero where all are kept."""
        worst = np.zeros(self.last - self.first)
        np.maximum.at(worst, self.interval_of_limit, (np.abs(self.use(control)) - 1.0).max(axis=-1))
        return worst
