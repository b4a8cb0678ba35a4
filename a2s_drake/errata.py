"""Errata: where the paper's text, followed to the letter, does not lead to its own results, each with a number."""

from dataclasses import dataclass, replace

import numpy as np

from a2s_drake.airframe import hover_input
from a2s_drake.attitude_law import affine_phase, fringe_offsets, nearest_fringe
from a2s_drake.ideal import Geometry, ideal_gain, law_attitude
from a2s_drake.parameters import GRAVITY
from a2s_drake.scenario import Scenario


@dataclass(frozen=True)
class Erratum:
    """One slip: where it stands, what the text says, what holds, and the figures that tell them apart."""

    where: str
    text: str
    mended: str
    name: str
    followed: float
    here: float
    unit: str


def errata(scenario: Scenario) -> list[Erratum]:
    """The slips of the paper, measured by ideal tracking of a scenario's three-axis law."""
    geometry = Geometry.of(scenario)
    reference = law_attitude(scenario, geometry, "three_axis", "nearest")
    gain = ideal_gain(scenario, geometry, reference)
    return [
        _sign(scenario, geometry, gain),
        _heights(scenario, geometry, gain),
        _empty_set(scenario, geometry),
        _projection(scenario, geometry, gain),
        _smoothness(scenario, geometry),
        _start(scenario),
        _input(scenario),
    ]


def _sign(scenario: Scenario, geometry: Geometry, gain: float) -> Erratum:
    # The law is odd in k, so the printed columns, which turn J_a and with it k around, turn its attitude around.
    wrong = ideal_gain(scenario, geometry, -law_attitude(scenario, geometry, "three_axis", "nearest"))
    return Erratum(
        "section III-A",
        "J_a has columns -e_i x r_a",
        "J_a = -[r_a]_x has columns +e_i x r_a",
        "gain over level, ideal tracking",
        wrong,
        gain,
        "%",
    )


def _heights(scenario: Scenario, geometry: Geometry, gain: float) -> Erratum:
    afloat = replace(geometry, ship=geometry.ship * np.array([1.0, 1.0, 0.0]))
    literal = ideal_gain(scenario, afloat, law_attitude(scenario, afloat, "three_axis", "nearest"))
    return Erratum(
        "section II-B",
        "ship antenna at (x, y, h), image at (x, y, -h), while z = 0 is the flight altitude",
        "both are measured from the sea, at z = -20 m",
        "gain over level, ideal tracking",
        literal,
        gain,
        "%",
    )


def _empty_set(scenario: Scenario, geometry: Geometry) -> Erratum:
    phase, k = affine_phase(geometry.position, geometry.ship, scenario.link)
    offset = (2.0 * nearest_fringe(phase) + 1.0) * np.pi - phase
    largest = np.abs(offset) * np.abs(k).max(axis=1) / (k * k).sum(axis=1)
    return Erratum(
        "section III-C",
        "M and E are sized so that M_f is never empty",
        "in the 15 deg box it is empty for part of the mission; the box would have to be this wide",
        "half-width of the box",
        scenario.attitude_law.candidate_limit_deg,
        float(np.rad2deg(largest.max())),
        "deg",
    )


def _projection(scenario: Scenario, geometry: Geometry, gain: float) -> Erratum:
    literal = ideal_gain(scenario, geometry, law_attitude(scenario, geometry, "three_axis", "index_zero"))
    phase, k = affine_phase(geometry.position, geometry.ship, scenario.link)
    farthest = float((np.abs(fringe_offsets(phase, np.array([0]))[:, 0]) / np.linalg.norm(k, axis=1)).max())
    return Erratum(
        "section III-C",
        f"where M_f is empty, the projection of eta_0 onto E (eta_0 has a norm of up to {farthest:.0f} rad)",
        "the candidate of smallest norm, clipped to E",
        "gain over level, ideal tracking",
        literal,
        gain,
        "%",
    )


def _smoothness(scenario: Scenario, geometry: Geometry) -> Erratum:
    step = np.diff(law_attitude(scenario, geometry, "three_axis", "nearest"), axis=0)
    return Erratum(
        "section III-C",
        "the reference varies smoothly with the geometry",
        "at most one candidate is feasible at a time, so it jumps from fringe to fringe",
        "largest rate of the reference on an axis, against the bound on angular velocity",
        scenario.mpc.angular_velocity_limit,
        float(np.abs(step).max() / scenario.mpc.period),
        "rad/s",
    )


def _start(scenario: Scenario) -> Erratum:
    mission = scenario.mission
    return Erratum(
        "section V",
        "the time warp starts and stops free of jerk",
        "s'' = pi^2/(2 T^2) at t = 0, so the acceleration steps from zero to pi^3 R/T^2",
        "acceleration at the start",
        0.0,
        float(np.pi**3 * mission.radius / mission.duration**2),
        "m/s^2",
    )


def _input(scenario: Scenario) -> Erratum:
    airframe = scenario.airframe
    literal = 6.0 * np.cos(np.deg2rad(airframe.tilt_deg)) * airframe.thrust_coefficient * airframe.rotor_speed_max
    return Erratum(
        "section IV",
        "u is the squared rotor speed and bounded by [16, 100] Hz",
        f"the bounds are squared with it; hover takes u = {hover_input(airframe)[0]:.0f} Hz^2",
        f"largest lift, against a weight of {airframe.mass * GRAVITY:.1f} N",
        float(literal),
        float(literal * airframe.rotor_speed_max),
        "N",
    )
