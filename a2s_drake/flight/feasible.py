"""Whether a scenario can be flown: every check that needs the physics of vehicle, path and link."""

from collections.abc import Collection

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.rotations import rotation_matrix
from a2s_drake.guidance.courses import Courses
from a2s_drake.guidance.laws import find_law
from a2s_drake.scenario.checks import ScenarioError, refuse
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.solvers.piqp import PiqpSolver
from a2s_drake.vehicle.airframe import hover_input


def check(scenario: Scenario, courses: Courses | None = None, *, unknown: Collection[str] = ()) -> Scenario:
    """Checks that a scenario is valid and can be flown; returns it, so that a call can be chained.

    Args:
      courses: where UAV and ship go; as the scenario says without it.
      unknown: which of `path`, `ship` and `law` are blocks that nobody can look into. What depends on them is not
        checked.
    Raises:
      ScenarioError: names the first field that stands in the way, its value and what is allowed.
    """
    scenario.validate()
    _check_solver(scenario)
    _check_hover(scenario)
    _check_knowledge(scenario)
    courses = courses or Courses.of(scenario)
    times = _instants(scenario, courses)
    if "path" not in unknown:
        _check_altitude(scenario, times, courses)
        _check_path(scenario, times, courses)
    if not {"path", "ship"} & set(unknown):
        _check_distance(scenario, times, courses)
    if not unknown:
        find_law(scenario.attitude_law.name).check(scenario, courses)
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


def _instants(scenario: Scenario, courses: Courses) -> FloatArray:
    """The instants at which the courses are looked at, s: every sample and between, at least 2001."""
    times = np.linspace(0.0, courses.end, 2001)
    if not courses.uav_name and not courses.ship_name:
        return times  # This is fine enough for a circle and a line, of any duration.
    samples = scenario.samples_until(courses.end)
    return np.unique(np.concatenate([times, samples, samples + scenario.mpc.period / 2.0]))


def _check_altitude(scenario: Scenario, times: FloatArray, courses: Courses) -> None:
    mission, lowest = scenario.mission, float(courses.uav.position(times)[:, 2].min())
    altitude = lowest - mission.sea_level
    if altitude <= 0.0:
        height = f"mission.start[2] = {mission.start[2]!r}, the UAV's height"
        if courses.uav_name:
            height = f"{lowest:.6g} m, the lowest height of {courses.uav_name}"
        raise refuse("mission.sea_level", mission.sea_level, f"must be below {height}")
    # Yaw moves nothing up or down, so a grid over roll and pitch shows how far the antenna can dip.
    angles = scenario.mpc.attitude_limit * np.linspace(-1.0, 1.0, 61)
    eta = np.stack([*np.meshgrid(angles, angles), np.zeros((61, 61))], axis=-1)
    dip = -float((rotation_matrix(eta) @ np.asarray(scenario.link.antenna_offset))[..., 2].min())
    believed, altitude = altitude, altitude + scenario.knowledge.position_bias[2]
    if altitude <= max(dip, 0.0) < believed:
        allowed = f"the UAV then flies {altitude:.3g} m above the sea, and its antenna can hang {dip:.3g} m below it"
        raise refuse("knowledge.position_bias", scenario.knowledge.position_bias, allowed)
    if altitude <= dip:
        flies = "comes down to" if courses.uav_name else "flies"
        allowed = f"the antenna can hang {dip:.3g} m below the UAV, which {flies} {altitude:.3g} m above the sea"
        raise refuse("link.antenna_offset", scenario.link.antenna_offset, f"{allowed}; must stay above it")


def _check_path(scenario: Scenario, times: FloatArray, courses: Courses) -> None:
    mission, mpc = scenario.mission, scenario.mpc
    path, speed = courses.uav.position(times), np.abs(courses.uav.velocity(times)).max(axis=1)
    for name, is_left in (
        ("position_lower", (path < np.asarray(mpc.position_lower)).any()),
        ("position_upper", (path > np.asarray(mpc.position_upper)).any()),
    ):
        if is_left:
            span = f"the path runs from {path.min(axis=0).tolist()} to {path.max(axis=0).tolist()} m"
            raise refuse(f"mpc.{name}", getattr(mpc, name), f"{span} and must stay within the operating region")
    fastest = float(speed.max())
    if fastest > mpc.velocity_limit and courses.uav_name:
        reason = f"reaches {fastest:.4g} m/s on an axis at t = {times[speed.argmax()]:.4g} s"
        allowed = f"{reason}; must be at most mpc.velocity_limit = {mpc.velocity_limit!r}"
        raise ScenarioError(f"{courses.uav_name}: {allowed}")
    if fastest > mpc.velocity_limit:
        least = mission.duration * fastest / mpc.velocity_limit
        reason = f"the reference reaches {fastest:.4g} m/s on an axis, above mpc.velocity_limit"
        allowed = f"{reason} = {mpc.velocity_limit!r}; must be at least {least:.4g} s at this radius"
        raise refuse("mission.duration", mission.duration, allowed)


def _check_distance(scenario: Scenario, times: FloatArray, courses: Courses) -> None:
    """The ship's antenna must stay out of reach of the UAV's, wherever that one is turned: there is no link at 0 m."""
    link, (path, ship) = scenario.link, courses.positions(times)
    # The law computes with the believed antenna, the channel with the true one.
    heights = (link.ship_antenna_height, scenario.true_link().ship_antenna_height)
    closest = min(_closest(path - ship - np.array([0.0, 0.0, height])) for height in heights)
    reach = float(np.linalg.norm(link.antenna_offset))
    if closest <= reach:
        name = courses.ship_name or courses.uav_name or f"mission.ship_start = {scenario.mission.ship_start!r}"
        allowed = f"must stay farther off than the reach of link.antenna_offset, {reach:.3g} m"
        words = f"the UAV comes as close as {closest:.3g} m to the ship's antenna; {allowed}"
        raise ScenarioError(f"{name}: {words}")


def _closest(between: FloatArray) -> float:
    """The smallest length of vectors (n, 3), m, between the rows too, where they change almost linearly."""
    start, step = between[:-1], np.diff(between, axis=0)
    length = np.maximum((step * step).sum(axis=1), np.finfo(float).tiny)
    share = np.clip(-(start * step).sum(axis=1) / length, 0.0, 1.0)
    return float(np.linalg.norm(start + share[:, np.newaxis] * step, axis=1).min())
