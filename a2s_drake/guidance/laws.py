"""The registry of attitude laws: what a name in `attitude_law.name` stands for."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.systems.framework import System

from a2s_drake.common.quoting import quoted
from a2s_drake.guidance.courses import Courses
from a2s_drake.guidance.plan.block import PlannedReference
from a2s_drake.guidance.plan.segment import check_plannable
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.guidance.soft_min import AttitudeReference, affine_phase, nearest_fringe
from a2s_drake.scenario.checks import ScenarioError, refuse
from a2s_drake.scenario.scenario import Scenario


@dataclass(frozen=True)
class Law:
    """One attitude law.

    Attributes:
      label: its name in figures and tables.
      style: matplotlib's settings of its lines, the same in every figure.
      build: makes its block for a scenario, with the plan that it flies, if it flies one.
      check: raises ScenarioError where the law cannot fly a scenario along the courses of UAV and ship.
      needs_plan: whether a plan must be made before take-off.
    """

    label: str
    style: dict[str, Any]
    build: Callable[[Scenario, AttitudeSpline | None], System]
    check: Callable[[Scenario, Courses], None] = lambda _scenario, _courses: None
    needs_plan: bool = False


def find_law(name: str) -> Law:
    """The law of a name.

    Raises:
      ScenarioError: for an unknown name, with the names that there are.
    """
    if name not in LAWS:
        raise ScenarioError(f"attitude_law.name = {quoted(name)}: must be one of {', '.join(LAWS)}")
    return LAWS[name]


def build_law(scenario: Scenario, plan: AttitudeSpline | None = None) -> System:
    """The block of a scenario's law.

    Args:
      plan: what the law flies, for a law that needs a plan. It is made before, by `kept_plan` for example. Without it
        the block is there, with all of its ports, and can be drawn, but raises ScenarioError when it is evaluated.
    """
    return find_law(scenario.attitude_law.name).build(scenario, plan)


def _soft_min(scenario: Scenario, _plan: AttitudeSpline | None) -> System:
    return AttitudeReference(scenario.link, scenario.attitude_law, scenario.mpc.attitude_limit, scenario.mpc.horizon)


def _planned(scenario: Scenario, plan: AttitudeSpline | None) -> System:
    return PlannedReference(plan, scenario.airframe, scenario.mission, scenario.mpc)


def _check_plannable(scenario: Scenario, _courses: Courses) -> None:
    check_plannable(scenario)


def _check_index_window(scenario: Scenario, courses: Courses) -> None:
    """The window of fringe indices must hold the nearest fringe at every sample of the mission."""
    # After the end of the courses, where previews and longer flights look, everything stands still.
    times = np.append(scenario.samples_until(courses.end), courses.end)
    phase, _ = affine_phase(*courses.positions(times), scenario.link)
    nearest = nearest_fringe(phase)
    first, last = int(nearest.min()), int(nearest.max())
    law = scenario.attitude_law
    needed = f"the nearest fringe has index {first}..{last} on this mission; the window must hold all of them"
    if law.index_min > first:
        raise refuse("attitude_law.index_min", law.index_min, needed)
    if law.index_max < last:
        raise refuse("attitude_law.index_max", law.index_max, needed)


# One colour and one dash per law, everywhere: Okabe and Ito's palette (2008), whose picks here also differ in
# lightness, so that they survive colour blindness and grey print.
LAWS: dict[str, Law] = {
    "three_axis": Law("three axes", {"color": "#0072B2", "linestyle": "-"}, _soft_min, _check_index_window),
    "pitch_only": Law("pitch only", {"color": "#E69F00", "linestyle": "--"}, _soft_min, _check_index_window),
    "level": Law("level", {"color": "#333333", "linestyle": ":"}, _soft_min),
    "planned": Law("planned", {"color": "#000000", "linestyle": "-."}, _planned, _check_plannable, needs_plan=True),
}
"""Law by name. A test holds its names equal to the choices of `attitude_law.name`."""

LAW_LABELS: dict[str, str] = {name: law.label for name, law in LAWS.items()}
"""Label by name of a law."""

LAW_STYLES: dict[str, dict[str, Any]] = {name: law.style for name, law in LAWS.items()}
"""Matplotlib's settings by name of a law."""

# Palette colour of the laws that the registry does not know; no law of the registry has it.
_OWN_STYLE: dict[str, Any] = {"color": "#D55E00", "linestyle": "-"}


def label_of(name: str) -> str:
    """The label of a law in figures and tables; a law of the user's own goes by its name."""
    # Matplotlib leaves a label that begins with an underscore out of a legend.
    return LAW_LABELS.get(name, name.lstrip("_") or name)


def style_of(name: str) -> dict[str, Any]:
    """Matplotlib's settings of a law's lines; laws of the user's own share theirs."""
    return LAW_STYLES.get(name, _OWN_STYLE)
