"""Attribution: what each effect costs, one after the other, from the best attitude down to what is flown.

An effect's cost depends on which effects come before it. The order here is that in which a law is made and flown.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.flight.log import Flight
from a2s_drake.flight.metrics import gain_percent
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.scenario.parts import Airframe
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.study.ceiling import is_hoverable
from a2s_drake.study.ideal_tracking import (
    Geometry,
    best_measured_attitude,
    held_gain,
    law_attitude,
    measured_attitude,
    without_candidate,
)

# An attitude that the vehicle cannot rest at is turned back towards level in steps of this share.
_SHARES = np.linspace(1.0, 0.0, 201)

# The attitude that both tables begin with.
BEST_IN_BOX = "the best attitude in the box"


@dataclass(frozen=True)
class Step:
    """An attitude on the way from the best one down to what is flown.

    Attributes:
      law: the law whose flight is at the end of the way.
      effect: what costs something here; empty at the top.
      attitude: in words.
      gain_percent: of that attitude held exactly over level held exactly; at the end, of flight over flight.
      cost: what the effect takes off the gain, percentage points.
      share: of the gain one step before; None where that is zero.
    """

    law: str
    effect: str
    attitude: str
    gain_percent: float
    cost: float
    share: float | None


def without_rate_bound(scenario: Scenario) -> Scenario:
    """The mission of a scenario under `planned`, with ten times the angular velocity limit: in effect without one."""
    limit = 10.0 * scenario.mpc.angular_velocity_limit
    return scenario.with_overrides(["attitude_law.name=planned", f"mpc.angular_velocity_limit={limit}"])


def rate_limited(reference: FloatArray, largest_step: float) -> FloatArray:
    """Follows a reference (n, 3) from level, each Euler angle by at most `largest_step` a sample, rad."""
    followed = np.zeros_like(reference)
    for before, after, wanted in zip(followed[:-1], followed[1:], reference[1:], strict=True):
        after[:] = before + np.clip(wanted - before, -largest_step, largest_step)
    return followed


def turned_back(eta: FloatArray, airframe: Airframe) -> FloatArray:
    """Attitudes (n, 3), rad; those at which the vehicle cannot hover are turned back towards level until it can."""
    kept = is_hoverable(_SHARES[:, np.newaxis, np.newaxis] * eta, airframe)
    return np.asarray(_SHARES[kept.argmax(axis=0)][:, np.newaxis] * eta)


def attribution(flights: Mapping[str, Flight], unbounded: AttitudeSpline) -> list[Step]:
    """The steps of the paper's law and those of the plan.

    Args:
      flights: of one scenario under `three_axis`, `planned` and `level`.
      unbounded: the plan of `without_rate_bound`.
    """
    flight = flights["level"]
    geometry = Geometry.of_flight(flight)
    best = best_measured_attitude(flight.scenario, geometry)
    return [*_of_the_papers_law(flights, best), *_of_the_plan(flights, best, unbounded)]


def _of_the_papers_law(flights: Mapping[str, Flight], best: FloatArray) -> list[Step]:
    flight = flights["three_axis"]
    scenario, geometry = flight.scenario, Geometry.of_flight(flight)
    law = law_attitude(scenario, geometry, "three_axis", scenario.attitude_law.fallback)
    empty = without_candidate(*(law_attitude(scenario, geometry, "three_axis", name) for name in ("zero", "nearest")))
    reachable = rate_limited(law, scenario.mpc.angular_velocity_limit * scenario.mpc.period)
    restful = turned_back(reachable, scenario.airframe)
    attitudes = [
        ("", BEST_IN_BOX, best),
        ("candidates", "the law's, the best where it has no candidate", np.where(empty[:, np.newaxis], best, law)),
        ("fallback", f"the law's, with the fallback {scenario.attitude_law.fallback}", law),
        ("rate", "the same, each Euler angle no faster than the bound on angular velocity", reachable),
        ("rotors", "the same, turned back where the vehicle could not hover", restful),
        ("tracking", "as flown", measured_attitude(flight)),
    ]
    return _steps("three_axis", scenario, geometry, attitudes, gain_percent(flight, flights["level"]))


def _of_the_plan(flights: Mapping[str, Flight], best: FloatArray, unbounded: AttitudeSpline) -> list[Step]:
    flight = flights["planned"]
    scenario, geometry = flight.scenario, Geometry.of_flight(flight)
    hover = best_measured_attitude(scenario, geometry, hoverable=True)
    attitudes = [
        ("", BEST_IN_BOX, best),
        ("rotors at rest", "the best at which the vehicle could hover", hover),
        ("rotors in motion", "a plan from level without a bound on angular velocity", unbounded.eta(geometry.time)),
        ("rate", "the plan", flight.attitude_reference),
        ("tracking", "as flown", measured_attitude(flight)),
    ]
    return _steps("planned", scenario, geometry, attitudes, gain_percent(flight, flights["level"]))


def _steps(
    law: str,
    scenario: Scenario,
    geometry: Geometry,
    attitudes: list[tuple[str, str, FloatArray]],
    flown: float,
) -> list[Step]:
    rows = [(effect, words, held_gain(scenario, geometry, eta)) for effect, words, eta in attitudes]
    rows.append(("position", "as flown, on the flown path, over level as flown", flown))
    above = [rows[0][2], *(gain for _, _, gain in rows[:-1])]
    return [
        Step(law, effect, words, gain, higher - gain, gain / higher if higher > 0.0 else None)
        for (effect, words, gain), higher in zip(rows, above, strict=True)
    ]
