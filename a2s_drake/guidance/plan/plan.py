"""The law `planned`: fringes by a dynamic programme, a plan by sequential QPs, polished by IPOPT, then certified."""

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.guidance.plan.certificate import Certificate, certify
from a2s_drake.guidance.plan.polish import PlanProgram
from a2s_drake.guidance.plan.search import Caution, rounded, search
from a2s_drake.guidance.plan.segment import Segment, Task
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.guidance.plan.sqp import EXCESS_TOLERANCE, improve
from a2s_drake.link.throughput import gain_percent
from a2s_drake.scenario.checks import ScenarioError
from a2s_drake.scenario.scenario import Scenario

# Two searches: one at the limits, whose corners the smooth plan cannot all follow, and one with room left for that.
# Neither is the better one on all missions; their plans differ by some 0.01 % of throughput.
_CAUTIONS = (Caution(), Caution(rate_share=0.9, rotor_reserve=0.015, turning_price=0.1))

# When the certificate finds an excess, that is between the instants at which limits were imposed: these are doubled and
# the limits drawn in by this share, this often.
_TIGHTENINGS, _TIGHTENING = 4, 0.002


@dataclass(frozen=True)
class Progress:
    """Where planning stands.

    Attributes:
      phase: `search`, `sqp`, `ipopt`, `certify`.
      iteration: within the phase.
      throughput: of the best plan so far that keeps all limits, bit/Hz.
    """

    phase: str
    iteration: int
    throughput: float


@dataclass(frozen=True)
class PlannedAttitude:
    """An attitude over the mission that the vehicle can fly.

    Attributes:
      spline: roll, pitch, yaw over time, rad, with rates and accelerations; at rest at its last value beyond the end.
      throughput: sum of T_s log2(1 + SNR) over the mission's samples on the planned path, bit/Hz.
      level_throughput: the same for level attitude.
      certificate: the independent check of every limit.
      iterations: QPs solved, and points that IPOPT evaluated.
      truncated: whether the time limit cut planning short. Otherwise the plan depends on the scenario alone.
    """

    spline: AttitudeSpline
    throughput: float
    level_throughput: float
    certificate: Certificate
    iterations: dict[str, int]
    truncated: bool

    @property
    def gain_percent(self) -> float:
        """Gain in throughput over level attitude, both held exactly, %."""
        return gain_percent(self.throughput, self.level_throughput)

    def eta(self, time: FloatArray) -> FloatArray:
        """Roll, pitch, yaw, rad; shape (...) to (..., 3)."""
        return self.spline.eta(time)

    def angular_velocity(self, time: FloatArray) -> FloatArray:
        """Body angular velocity, rad/s, B; shape (...) to (..., 3)."""
        return self.spline.angular_velocity(time)


class _OutOfTimeError(Exception):
    pass


class _Record:
    """The best feasible plan so far, who is told of it, and the time that is left."""

    def __init__(self, task: Task, progress: Callable[[Progress], None] | None, time_limit: float | None) -> None:
        self._progress = progress
        self._deadline = None if time_limit is None else time.monotonic() + time_limit
        self.iterations = {"sqp": 0, "ipopt": 0}
        self.truncated = False
        self.impose(task)

    def impose(self, task: Task) -> None:
        """Starts again from level under the limits of a task."""
        self.task, self.whole = task, Segment(task)
        self.best = np.zeros((task.grid.controls, 3))
        self._cost = self.whole.cost(self.best)
        self.throughput = -self._cost

    def seconds_left(self) -> float | None:
        return None if self._deadline is None else self._deadline - time.monotonic()

    def tell(self, phase: str, iteration: int) -> None:
        """Tells who listens.

        Raises:
          _OutOfTimeError: when the time is up.
        """
        if self._progress is not None:
            self._progress(Progress(phase, iteration, self.throughput))
        left = self.seconds_left()
        if left is not None and left <= 0.0:
            raise _OutOfTimeError

    def consider(self, control: FloatArray) -> None:
        """Takes a plan over if it keeps the limits and is the best so far."""
        # Solvers keep equations to a tolerance; rates at rest, and a level start, can be exact.
        control = self.task.grid.rested(control)
        cost = self.whole.cost(control)
        if cost < self._cost and self.whole.excess(control).max() <= EXCESS_TOLERANCE:
            self.best, self._cost, self.throughput = control, cost, self.whole.throughput(control)


def plan_attitude(
    scenario: Scenario,
    progress: Callable[[Progress], None] | None = None,
    time_limit: float | None = None,
) -> PlannedAttitude:
    """Plans the attitude of a mission before take-off, from its planned geometry alone.

    The plan maximises throughput under the exact channel on the planned path, within the vehicle's limits less the
    margins of the scenario's `planning`. It starts level and at rest, as the vehicle does, and ends at rest. It is
    never worse than level, which is where it begins.

    Args:
      progress: is told of every stage and iteration.
      time_limit: wall-clock seconds after which the best plan so far is certified and returned; without it the result
        depends on the scenario alone.
    Raises:
      ValueError: for a time limit below zero.
      ScenarioError: when the vehicle cannot fly the path even level within its limits, its rotors cannot make every
        wrench, the mission is too long for the search, or names a track file.
    """
    if time_limit is not None and not time_limit >= 0.0:
        raise ValueError(f"time_limit = {time_limit!r}: must be at least 0")
    record = _Record(Task.of(scenario), progress, time_limit)
    if record.whole.excess(record.best).max() > EXCESS_TOLERANCE:
        raise ScenarioError(
            f"mission.duration = {scenario.mission.duration!r}: on this path not even the level vehicle keeps the "
            "rotor speeds that planning.rotor_speed_min_margin and rotor_speed_max_margin leave"
        )
    level_throughput = record.throughput
    try:
        _optimise(record)
        record.tell("certify", 0)
    except _OutOfTimeError:
        record.truncated = True
    control, certificate = _certified(record)
    return PlannedAttitude(
        AttitudeSpline(record.task.grid.duration, control),
        record.whole.throughput(control),
        level_throughput,
        certificate,
        record.iterations,
        record.truncated,
    )


def _optimise(record: _Record) -> None:
    task = record.task
    for caution in _CAUTIONS:
        path = search(task, caution, lambda stage: record.tell("search", stage))
        start = rounded(task.grid, *path)
        record.consider(_toward_level(start, lambda control: bool(record.whole.excess(control).max() <= 0.0)))
        _run_sqp(record, start)
    if task.planning.ipopt_iterations > 0:
        _run_ipopt(record)


def _run_sqp(record: _Record, start: FloatArray) -> None:
    before = record.iterations["sqp"]

    def visit(control: FloatArray, solved: int) -> None:
        record.iterations["sqp"] = before + solved
        record.consider(control)
        record.tell("sqp", record.iterations["sqp"])

    improve(record.task.grid, record.whole, start, record.task.planning.sqp_iterations, visit)


def _run_ipopt(record: _Record) -> None:
    def visit(control: FloatArray) -> None:
        record.iterations["ipopt"] += 1
        record.consider(control)
        # An exception must not cross IPOPT, which keeps the time itself.
        with contextlib.suppress(_OutOfTimeError):
            record.tell("ipopt", record.iterations["ipopt"])

    program = PlanProgram(record.task)
    program.solve(record.best, record.task.planning.ipopt_iterations, record.seconds_left(), visit)


def _certified(record: _Record) -> tuple[FloatArray, Certificate]:
    """The best plan and its certificate, solved again where that finds an excess; level if all else fails."""
    task = record.task

    def check(control: FloatArray) -> Certificate:
        return certify(AttitudeSpline(task.grid.duration, control), task.scenario, task.planning.certificate_rate)

    tried = [record.best]
    certificate = check(tried[-1])
    for _ in range(_TIGHTENINGS):
        if certificate.holds or record.truncated:
            break
        planning = replace(task.planning, limit_spacing=task.planning.limit_spacing / 2.0)
        task = replace(task, planning=planning, limits=task.limits.tightened(_TIGHTENING))
        record.impose(task)
        try:
            _run_sqp(record, tried[-1])
        except _OutOfTimeError:
            record.truncated = True
        tried.append(record.best)
        certificate = check(tried[-1])
    if certificate.holds and not record.truncated:
        return tried[-1], certificate
    # What time has left of the last plan may be worth less than a share of the first one.
    options = [_toward_level(control, lambda some: check(some).holds) for control in (tried[0], tried[-1])]
    control = min((*options, np.zeros_like(tried[0])), key=record.whole.cost)
    return control, check(control)


def _toward_level(control: FloatArray, accepted: Callable[[FloatArray], bool]) -> FloatArray:
    """The largest share of a plan, in eighths, that is accepted; level where none is."""
    for share in np.arange(8.0, 0.0, -1.0) / 8.0:
        if accepted(share * control):
            return np.asarray(share * control)
    return np.zeros_like(control)
