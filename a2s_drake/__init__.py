"""Drake blocks for one question: how much of a UAV-to-ship radio link can be won back by turning the UAV?"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # What a type checker and an editor see; at run time each name is imported when it is first used.
    from a2s_drake.common.signals import SolverStatus
    from a2s_drake.common.wiring import WiringError, build_wired
    from a2s_drake.control.controller import MpcController
    from a2s_drake.flight.folder import write_results
    from a2s_drake.flight.log import Flight, FlightEnded, FlightInterrupted, WallClock
    from a2s_drake.flight.metrics import compute_metrics
    from a2s_drake.flight.run import run_flight
    from a2s_drake.guidance.path import UavPath
    from a2s_drake.guidance.plan.block import PlannedReference
    from a2s_drake.guidance.plan.cache import kept_plan
    from a2s_drake.guidance.plan.plan import PlannedAttitude, plan_attitude
    from a2s_drake.guidance.soft_min import AttitudeReference, AttitudeReference_, attitude_reference
    from a2s_drake.link.two_ray import TwoRayChannel, TwoRayChannel_
    from a2s_drake.scenario.checks import ScenarioError
    from a2s_drake.scenario.parts import (
        Airframe,
        AttitudeLaw,
        Disturbance,
        Knowledge,
        Link,
        Mission,
        Mpc,
        Planning,
        Simulation,
    )
    from a2s_drake.scenario.scenario import Scenario
    from a2s_drake.solvers.piqp import PiqpSolver
    from a2s_drake.vehicle.airframe import add_airframe, hover_input, rotor_table, wrench_map
    from a2s_drake.world.ship import ShipTrajectory

# The public names, by the module that each comes from. A test holds this list and the imports above equal.
_MODULES = {
    "scenario.scenario": ("Scenario",),
    "scenario.checks": ("ScenarioError",),
    "scenario.parts": (
        "Airframe",
        "AttitudeLaw",
        "Link",
        "Mission",
        "Mpc",
        "Planning",
        "Disturbance",
        "Knowledge",
        "Simulation",
    ),
    "world.ship": ("ShipTrajectory",),
    "guidance.path": ("UavPath",),
    "guidance.soft_min": ("AttitudeReference", "AttitudeReference_", "attitude_reference"),
    "link.two_ray": ("TwoRayChannel", "TwoRayChannel_"),
    "guidance.plan.plan": ("PlannedAttitude", "plan_attitude"),
    "guidance.plan.block": ("PlannedReference",),
    "guidance.plan.cache": ("kept_plan",),
    "control.controller": ("MpcController",),
    "solvers.piqp": ("PiqpSolver",),
    "vehicle.airframe": ("add_airframe", "hover_input", "rotor_table", "wrench_map"),
    "common.signals": ("SolverStatus",),
    "common.wiring": ("build_wired", "WiringError"),
    "flight.log": ("Flight", "FlightEnded", "FlightInterrupted", "WallClock"),
    "flight.run": ("run_flight",),
    "flight.folder": ("write_results",),
    "flight.metrics": ("compute_metrics",),
}
_MODULE_OF = {name: f"{__name__}.{module}" for module, names in _MODULES.items() for name in names}

__all__ = [
    "Scenario",
    "ScenarioError",
    "Airframe",
    "AttitudeLaw",
    "Link",
    "Mission",
    "Mpc",
    "Planning",
    "Disturbance",
    "Knowledge",
    "Simulation",
    "ShipTrajectory",
    "UavPath",
    "AttitudeReference",
    "AttitudeReference_",
    "TwoRayChannel",
    "TwoRayChannel_",
    "PlannedAttitude",
    "PlannedReference",
    "plan_attitude",
    "kept_plan",
    "MpcController",
    "SolverStatus",
    "PiqpSolver",
    "add_airframe",
    "build_wired",
    "WiringError",
    "attitude_reference",
    "hover_input",
    "rotor_table",
    "wrench_map",
    "Flight",
    "FlightEnded",
    "FlightInterrupted",
    "WallClock",
    "run_flight",
    "write_results",
    "compute_metrics",
]


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(_MODULE_OF[name]), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
