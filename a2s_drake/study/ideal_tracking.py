"""Ideal tracking: what each law wins where the vehicle is exactly at its reference, and what any law could win."""

from dataclasses import dataclass, fields, replace

import numpy as np

from a2s_drake.common.arrays import BoolArray, FloatArray
from a2s_drake.flight.log import Flight
from a2s_drake.guidance.courses import Courses
from a2s_drake.guidance.soft_min import affine_phase, attitude_reference
from a2s_drake.link.throughput import gain_percent
from a2s_drake.scenario.parts import FALLBACKS
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.study.ceiling import (
    affine_phase_error,
    best_attitude,
    best_hoverable_attitude,
    is_hoverable,
    throughput_of,
)


@dataclass(frozen=True)
class Geometry:
    """The mission sampled at t_k, m, W.

    Attributes:
      time: t_k, s, shape (n,).
      position: where the UAV is meant to be, shape (n, 3).
      ship: where the ship truly is, which the channel depends on, shape (n, 3).
      believed_ship: where the UAV believes it to be, which laws depend on, shape (n, 3).
    """

    time: FloatArray
    position: FloatArray
    ship: FloatArray
    believed_ship: FloatArray

    @classmethod
    def of(cls, scenario: Scenario) -> "Geometry":
        """The geometry of a scenario over its flight."""
        time, courses = scenario.sample_times(), Courses.of(scenario)
        # The report of the ship's track is this old when the UAV gets it.
        believed = courses.ship.position(time - scenario.knowledge.ship_latency)
        return cls(time, *courses.positions(time), believed)

    @classmethod
    def of_flight(cls, flight: Flight) -> "Geometry":
        """The geometry that a flight has logged: its reference path, not where it flew.

        A log does not hold what the UAV believes of the ship. Where the report is late, it is taken from the scenario's
        track.
        """
        believed, latency = flight.ship_position, flight.scenario.knowledge.ship_latency
        if latency > 0.0:
            believed = Courses.of(flight.scenario, flight.files).ship.position(flight.time - latency)
        return cls(flight.time, flight.position_reference, flight.ship_position, believed)

    def every(self, stride: int) -> "Geometry":
        """Every so many-th sample of it."""
        return Geometry(*(getattr(self, entry.name)[::stride] for entry in fields(self)))


def law_attitude(scenario: Scenario, geometry: Geometry, name: str, fallback: str) -> FloatArray:
    """The reference of a law under a fallback along a geometry, rad, shape (n, 3)."""
    law = replace(scenario.attitude_law, name=name, fallback=fallback)
    believed_ship, link = geometry.believed_ship, scenario.link
    return attitude_reference(geometry.position, believed_ship, link, law, scenario.mpc.attitude_limit)


def without_candidate(zero: FloatArray, nearest: FloatArray) -> BoolArray:
    """Where a law has no candidate to take, shape (n,): where its references under these two fallbacks differ."""
    return np.asarray((zero != nearest).any(axis=1))


def held_throughput(scenario: Scenario, geometry: Geometry, eta: FloatArray) -> float:
    """Throughput per hertz, bit/Hz, in the true channel where the UAV *measures* that it holds an attitude exactly.

    Its true pose is the measured one and the scenario's bias. `eta` is roll, pitch, yaw, rad, shape (n, 3).
    """
    bias = np.array(scenario.knowledge.pose_bias)
    position, attitude = geometry.position + bias[:3], eta + bias[3:]
    return throughput_of(position, attitude, geometry.ship, scenario.true_link(), scenario.mpc.period)


def measured_attitude(flight: Flight) -> FloatArray:
    """The attitude that flew, as the UAV measures it but for noise, rad, shape (n, 3); see `held_throughput`."""
    return flight.attitude - np.array(flight.scenario.knowledge.pose_bias)[3:]


def best_measured_attitude(scenario: Scenario, geometry: Geometry, *, hoverable: bool = False) -> FloatArray:
    """The best attitude in the box, or the best that the vehicle can rest at, as the UAV measures it, rad, (n, 3).

    It knows the truth: where the vehicle and the ship's antenna truly are.
    """
    bias, link, limit = np.array(scenario.knowledge.pose_bias), scenario.true_link(), scenario.mpc.attitude_limit
    position = geometry.position + bias[:3]
    if hoverable:
        true = best_hoverable_attitude(position, geometry.ship, link, limit, scenario.airframe)
    else:
        true = best_attitude(position, geometry.ship, link, limit)
    return true - bias[3:]


def held_gain(scenario: Scenario, geometry: Geometry, eta: FloatArray) -> float:
    """Gain in throughput of an attitude held exactly over level attitude held exactly, as measured, %."""
    mine, level = (held_throughput(scenario, geometry, attitude) for attitude in (eta, np.zeros_like(eta)))
    return gain_percent(mine, level)


def phase_errors(scenario: Scenario, geometry: Geometry) -> FloatArray:
    """Exact minus affine phase on the boundary of the attitude box, as believed, rad, shape (n, 26)."""
    phase, k = affine_phase(geometry.position, geometry.believed_ship, scenario.link)
    return affine_phase_error(
        geometry.position,
        geometry.believed_ship,
        scenario.link,
        scenario.mpc.attitude_limit,
        lambda eta: phase[:, np.newaxis] + np.einsum("nmi,ni->nm", eta, k),
    )


@dataclass(frozen=True)
class Ceilings:
    """Gain over level of the best attitude at every sample, held exactly, %.

    Attributes:
      box: the best in the attitude box.
      hoverable: the best of those at which the vehicle can rest.
    """

    box: float
    hoverable: float


@dataclass(frozen=True)
class PhaseError:
    """Error of the affine phase on the boundary of the attitude box: largest and root mean square, rad."""

    max: float
    rms: float


@dataclass(frozen=True)
class IdealTracking:
    """What a scenario's laws win with every attitude held exactly, and what any attitude could.

    Attributes:
      level_throughput_bit_per_hz: of level attitude.
      gain_percent: over level, by law and fallback.
      ceiling_percent: the most that an attitude wins.
      empty_share: share of the samples without a feasible candidate, by law.
      hoverable_share: share of the three-axis references at which the vehicle can rest, by fallback.
      affine_phase_error_rad: how good the affine phase is.
    """

    level_throughput_bit_per_hz: float
    gain_percent: dict[str, dict[str, float]]
    ceiling_percent: Ceilings
    empty_share: dict[str, float]
    hoverable_share: dict[str, float]
    affine_phase_error_rad: PhaseError


def measure_ideal_tracking(scenario: Scenario) -> IdealTracking:
    """Ideal tracking of every law and fallback of a scenario, both ceilings, and the affine phase error."""
    geometry = Geometry.of(scenario)
    references = {
        (name, fallback): law_attitude(scenario, geometry, name, fallback)
        for name in ("three_axis", "pitch_only")
        for fallback in FALLBACKS
    }
    box, hover = (best_measured_attitude(scenario, geometry, hoverable=hoverable) for hoverable in (False, True))
    errors = phase_errors(scenario, geometry)
    level = np.zeros_like(box)
    return IdealTracking(
        level_throughput_bit_per_hz=held_throughput(scenario, geometry, level),
        gain_percent={
            name: {fallback: held_gain(scenario, geometry, references[name, fallback]) for fallback in FALLBACKS}
            for name in ("three_axis", "pitch_only")
        },
        ceiling_percent=Ceilings(
            box=held_gain(scenario, geometry, box), hoverable=held_gain(scenario, geometry, hover)
        ),
        empty_share={
            name: float(without_candidate(references[name, "zero"], references[name, "nearest"]).mean())
            for name in ("three_axis", "pitch_only")
        },
        hoverable_share={
            fallback: float(is_hoverable(references["three_axis", fallback], scenario.airframe).mean())
            for fallback in FALLBACKS
        },
        affine_phase_error_rad=PhaseError(max=float(np.abs(errors).max()), rms=float(np.sqrt((errors**2).mean()))),
    )
