"""Errata: where the paper's text, followed to the letter, does not lead to its own results, each with figures."""

from dataclasses import dataclass, replace

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.guidance.soft_min import affine_phase, fringe_offsets, nearest_fringe
from a2s_drake.scenario.parts import GRAVITY
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.study.ideal_tracking import Geometry, held_gain, law_attitude
from a2s_drake.vehicle.airframe import hover_input


@dataclass(frozen=True)
class Erratum:
    """One slip: where it stands, what the text says, what holds, and labelled figures that tell them apart.

    Attributes:
      figures: label, value and unit of each figure.
    """

    where: str
    text: str
    holds: str
    figures: tuple[tuple[str, float, str], ...]


def errata(scenario: Scenario) -> list[Erratum]:
    """The slips of the paper, measured on a scenario by ideal tracking; gains are over level attitude."""
    geometry = Geometry.of(scenario)
    mended = held_gain(scenario, geometry, law_attitude(scenario, geometry, "three_axis", "nearest"))
    return [
        _sign(scenario, geometry, mended),
        _heights(scenario, geometry, mended),
        _empty_set(scenario, geometry),
        _projection(scenario, geometry),
        _smoothness(scenario, geometry),
        _start(scenario),
        _input(scenario),
    ]


def _sign(scenario: Scenario, geometry: Geometry, mended: float) -> Erratum:
    # The printed columns change the sign of J_a, and so of k. The law is odd in k, so its attitude changes sign too.
    followed = held_gain(scenario, geometry, -law_attitude(scenario, geometry, "three_axis", "nearest"))
    return Erratum(
        "section III-A",
        "J_a has columns -e_i x r_a",
        "J_a = -[r_a]_x has columns +e_i x r_a",
        (("gain if followed", followed, "%"), ("gain mended", mended, "%")),
    )


def _heights(scenario: Scenario, geometry: Geometry, mended: float) -> Erratum:
    at_zero = np.array([1.0, 1.0, 0.0])
    afloat = replace(geometry, ship=geometry.ship * at_zero, believed_ship=geometry.believed_ship * at_zero)
    attitude = law_attitude(scenario, afloat, "three_axis", "nearest")
    return Erratum(
        "section II-B",
        "ship antenna at (x, y, h), image at (x, y, -h), while z = 0 is the flight altitude",
        "both are measured from the sea, at z = -20 m",
        (
            ("gain if the law follows it", held_gain(scenario, geometry, attitude), "%"),
            ("if law and channel do", held_gain(scenario, afloat, attitude), "%"),
            ("gain mended", mended, "%"),
        ),
    )


def _needed_box_deg(phase: FloatArray, k: FloatArray) -> float:
    """Half-width of the smallest box that holds the nearest candidate at every sample, deg."""
    offset = (2.0 * nearest_fringe(phase) + 1.0) * np.pi - phase
    return float(np.rad2deg((np.abs(offset) * np.abs(k).max(axis=1) / (k * k).sum(axis=1)).max()))


def _empty_set(scenario: Scenario, geometry: Geometry) -> Erratum:
    phase, k = affine_phase(geometry.position, geometry.believed_ship, scenario.link)
    pitch = k * np.array([0.0, 1.0, 0.0])
    return Erratum(
        "section III-C",
        "M and E are sized so that M_f is never empty",
        "in the box of Table I it is empty for part of the mission",
        (
            ("box of Table I", scenario.attitude_law.candidate_limit_deg, "deg"),
            ("box needed for three axes", _needed_box_deg(phase, k), "deg"),
            ("for pitch only", _needed_box_deg(phase, pitch), "deg"),
        ),
    )


def _projection(scenario: Scenario, geometry: Geometry) -> Erratum:
    phase, k = affine_phase(geometry.position, geometry.believed_ship, scenario.link)
    farthest = float((np.abs(fringe_offsets(phase, np.array([0]))[:, 0]) / np.linalg.norm(k, axis=1)).max())
    gains = [
        (f"{label}, {words}", held_gain(scenario, geometry, law_attitude(scenario, geometry, law, fallback)), "%")
        for law, label in (("three_axis", "three axes"), ("pitch_only", "pitch only"))
        for fallback, words in (("index_zero", "gain if followed"), ("nearest", "with the nearest"))
    ]
    return Erratum(
        "section III-C",
        "where M_f is empty, the reference tends to the projection of eta_0 onto E",
        "eta_0 is not the nearest candidate but one of the farthest; the nearest, clipped, is the natural stand-in",
        (("largest norm of eta_0", farthest, "rad"), *gains),
    )


def _smoothness(scenario: Scenario, geometry: Geometry) -> Erratum:
    jumps = [
        (f"largest jump of three axes, {fallback}", float(np.rad2deg(np.abs(np.diff(eta, axis=0)).max())), "deg")
        for fallback in ("nearest", "index_zero", "zero")
        for eta in [law_attitude(scenario, geometry, "three_axis", fallback)]
    ]
    return Erratum(
        "section III-C",
        "the reference varies smoothly with the geometry",
        "in the box of Table I at most one candidate is feasible at a time, so the reference jumps between two samples",
        tuple(jumps),
    )


def _start(scenario: Scenario) -> Erratum:
    mission = scenario.mission
    return Erratum(
        "section V",
        "the time warp starts and stops free of jerk",
        "s'' = pi^2/(2 T^2) at t = 0, so the acceleration steps from zero to pi^3 R/T^2",
        (("step of the acceleration", float(np.pi**3 * mission.radius / mission.duration**2), "m/s^2"),),
    )


def _input(scenario: Scenario) -> Erratum:
    airframe = scenario.airframe
    per_unit = 6.0 * np.cos(np.deg2rad(airframe.tilt_deg)) * airframe.thrust_coefficient
    return Erratum(
        "section IV",
        "u is the squared rotor speed, and bounded by [16, 100] Hz",
        f"the bounds are squared with it; hover takes u = {hover_input(airframe)[0]:.0f} Hz^2",
        (
            ("largest lift if followed", float(per_unit * airframe.rotor_speed_max), "N"),
            ("mended", float(per_unit * airframe.rotor_speed_max**2), "N"),
            ("weight", airframe.mass * GRAVITY, "N"),
        ),
    )
