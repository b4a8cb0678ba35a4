"""Ideal tracking: what each law wins where the vehicle is exactly at its reference, and what any law could win."""

from dataclasses import dataclass, replace

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
    """The mission sampled at t_k: time (n,), where UAV and ship are meant to be (n, 3), m, W."""

    time: FloatArray
    position: FloatArray
    ship: FloatArray

    @classmethod
    def of(cls, scenario: Scenario) -> "Geometry":
        """The geometry of a scenario over its flight."""
        time = scenario.sample_times()
        return cls(time, *Courses.of(scenario).positions(time))

    @classmethod
    def of_flight(cls, flight: Flight) -> "Geometry":
        """The geometry that a flight has logged: its reference path, not where it flew."""
        return cls(flight.time, flight.position_reference, flight.ship_position)


def law_attitude(scenario: Scenario, geometry: Geometry, name: str, fallback: str) -> FloatArray:
    """The reference of a law under a fallback along a geometry, rad, shape (n, 3)."""
    law = replace(scenario.attitude_law, name=name, fallback=fallback)
    return attitude_reference(geometry.position, geometry.ship, scenario.link, law, scenario.mpc.attitude_limit)


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


def held_gain(scenario: Scenario, geometry: Geometry, eta: FloatArray) -> float:
    """Gain in throughput of an attitude held exactly over level attitude held exactly, as measured, %."""
    mine, level = (held_throughput(scenario, geometry, attitude) for attitude in (eta, np.zeros_like(eta)))
    return gain_percent(mine, level)


def phase_errors(scenario: Scenario, geometry: Geometry) -> FloatArray:
    """Exact minus affine phase on the boundary of the attitude box, rad, shape (n, 26)."""
    phase, k = affine_phase(geometry.position, geometry.ship, scenario.link)
    return affine_phase_error(
        geometry.position,
        geometry.ship,
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
    limit, airframe = scenario.mpc.attitude_limit, scenario.airframe
    references = {
        (name, fallback): law_attitude(scenario, geometry, name, fallback)
        for name in ("three_axis", "pitch_only")
        for fallback in FALLBACKS
    }
    # A ceiling knows the truth: where the vehicle truly is, and how it must measure itself to be turned as it should.
    bias, link = np.array(scenario.knowledge.pose_bias), scenario.true_link()
    position = geometry.position + bias[:3]
    box = best_attitude(position, geometry.ship, link, limit) - bias[3:]
    hover = best_hoverable_attitude(position, geometry.ship, link, limit, airframe) - bias[3:]
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
            fallback: float(is_hoverable(references["three_axis", fallback], airframe).mean()) for fallback in FALLBACKS
        },
        affine_phase_error_rad=PhaseError(max=float(np.abs(errors).max()), rms=float(np.sqrt((errors**2).mean()))),
    )
