"""Whether a scenario can be flown: every check that needs the physics of vehicle, path and link."""

import numpy as np

from a2s_drake.common.rotations import rotation_matrix
from a2s_drake.guidance.laws import find_law
from a2s_drake.guidance.path import uav_position, uav_velocity
from a2s_drake.scenario.checks import ScenarioError, refuse
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.solvers.piqp import PiqpSolver
from a2s_drake.vehicle.airframe import hover_input


def check(scenario: Scenario) -> Scenario:
    """Checks that a scenario is valid and can be flown; returns it, so that a call can be chained.

    Raises:
      ScenarioError: names the first field that stands in the way, its value and what is allowed.
    """
    scenario.validate()
    _check_solver(scenario)
    _check_hover(scenario)
    _check_knowledge(scenario)
    _check_altitude(scenario)
    _check_path(scenario)
    find_law(scenario.attitude_law.name).check(scenario)
    return scenario


def _check_solver(scenario: Scenario) -> None:
    if scenario.mpc.solver == "piqp" and not PiqpSolver().available():
        raise refuse("mpc.solver", "piqp", "needs the package piqp (pip install piqp); osqp needs only Drake")


def _check_hover(scenario: Scenario) -> None:
    low, high = scenario.airframe.rotor_speed_min, scenario.airframe.rotor_speed_max
    speed = float(np.sqrt(hover_input(scenario.airframe).max()))
    if not low <= speed <= high:
        raise ScenarioError(
            f"airframe.mass = {scenario.airframe.mass!r} with airframe.thrust_coefficient = "
            f"{scenario.airframe.thrust_coefficient!r}: hover takes {speed:.2f} Hz, which must lie within "
            f"airframe.rotor_speed_min..max = {low!r}..{high!r} Hz"
        )


def _check_knowledge(scenario: Scenario) -> None:
    error, height = scenario.knowledge.ship_antenna_height_error, scenario.link.ship_antenna_height
    if height + error <= 0.0:
        allowed = f"must leave the ship's antenna, believed {height!r} m above the sea, above it"
        raise refuse("knowledge.ship_antenna_height_error", error, allowed)


def _check_altitude(scenario: Scenario) -> None:
    altitude = scenario.mission.start[2] - scenario.mission.sea_level
    if altitude <= 0.0:
        start = f"mission.start[2] = {scenario.mission.start[2]!r}, the UAV's height"
        raise refuse("mission.sea_level", scenario.mission.sea_level, f"must be below {start}")
    # Yaw moves nothing up or down, so a grid over roll and pitch shows how far the antenna can dip.
    angles = scenario.mpc.attitude_limit * np.linspace(-1.0, 1.0, 61)
    eta = np.stack([*np.meshgrid(angles, angles), np.zeros((61, 61))], axis=-1)
    dip = -float((rotation_matrix(eta) @ np.asarray(scenario.link.antenna_offset))[..., 2].min())
    believed, altitude = altitude, altitude + scenario.knowledge.position_bias[2]
    if altitude <= max(dip, 0.0) < believed:
        allowed = f"the UAV then flies {altitude:.3g} m above the sea, and its antenna can hang {dip:.3g} m below it"
        raise refuse("knowledge.position_bias", scenario.knowledge.position_bias, allowed)
    if altitude <= dip:
        allowed = f"the antenna can hang {dip:.3g} m below the UAV, which flies {altitude:.3g} m above the sea"
        raise refuse("link.antenna_offset", scenario.link.antenna_offset, f"{allowed}; must stay above it")


def _check_path(scenario: Scenario) -> None:
    mission, mpc = scenario.mission, scenario.mpc
    times = np.linspace(0.0, mission.duration, 2001)
    path = uav_position(times, mission)
    for name, beyond in (
        ("position_lower", (path < np.asarray(mpc.position_lower)).any()),
        ("position_upper", (path > np.asarray(mpc.position_upper)).any()),
    ):
        if beyond:
            span = f"the path runs from {path.min(axis=0).tolist()} to {path.max(axis=0).tolist()} m"
            raise refuse(f"mpc.{name}", getattr(mpc, name), f"{span} and must stay within the operating region")
    fastest = float(np.abs(uav_velocity(times, mission)).max())
    if fastest > mpc.velocity_limit:
        least = mission.duration * fastest / mpc.velocity_limit
        reason = f"the reference reaches {fastest:.4g} m/s on an axis, above mpc.velocity_limit"
        allowed = f"{reason} = {mpc.velocity_limit!r}; must be at least {least:.4g} s at this radius"
        raise refuse("mission.duration", mission.duration, allowed)
