"""Drake blocks for one question: how much of a UAV-to-ship radio link can be won back by turning the UAV?"""

from a2s_drake.airframe import add_airframe, hover_input, rotor_table, wrench_map
from a2s_drake.attitude_law import AttitudeReference, AttitudeReference_, attitude_reference
from a2s_drake.checks import ScenarioError
from a2s_drake.flight import Flight, FlightEnded, FlightInterrupted, WallClock, run_flight
from a2s_drake.metrics import compute_metrics
from a2s_drake.mpc.controller import MpcController, SolverStatus
from a2s_drake.parameters import Airframe, AttitudeLaw, Disturbance, Link, Mission, Mpc, Simulation
from a2s_drake.paths import ShipTrajectory, UavPath
from a2s_drake.piqp_solver import PiqpSolver
from a2s_drake.planned.keep import kept_plan
from a2s_drake.planned.plan import PlannedAttitude, plan_attitude
from a2s_drake.planned.reference import PlannedReference
from a2s_drake.scenario import Scenario
from a2s_drake.two_ray import TwoRayChannel, TwoRayChannel_
from a2s_drake.wiring import WiringError, build_wired

__all__ = [
    "Scenario",
    "ScenarioError",
    "Airframe",
    "AttitudeLaw",
    "Link",
    "Mission",
    "Mpc",
    "Disturbance",
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
    "compute_metrics",
]
