"""Readings: the ways to settle what the paper leaves open, each a change to one of two base scenarios."""

from dataclasses import dataclass, replace

from a2s_drake.scenario.parts import FALLBACKS, AttitudeLaw
from a2s_drake.scenario.scenario import Scenario

CANDIDATE_LIMITS_DEG = (15.0, 20.0, 25.0, 28.5, 30.0, 40.0)
WAVELENGTH_SPEEDS = {"c = 299792458 m/s": 299792458.0, "c = 3e8 m/s": 3.0e8}
DRAG_SIGNS = {"drag opposes tilt": -1, "drag adds to tilt": 1}
SECOND_AIRFRAME = ("airframe.tilt_deg=35", "airframe.thrust_coefficient=9.9e-4", "airframe.drag_to_thrust=0.019")


@dataclass(frozen=True)
class Reading:
    """One choice: the question it answers, the answer, and the fields that it sets."""

    question: str
    answer: str
    overrides: tuple[str, ...] = ()

    def applied(self, base: Scenario) -> Scenario:
        """The base scenario under this reading."""
        return base.with_overrides(self.overrides)

    def is_base(self, base: Scenario) -> bool:
        """Whether the base already reads so."""
        return self.applied(base) == base


def all_readings() -> list[Reading]:
    """Every reading that the text of the paper allows, grouped by question."""
    fallbacks = [Reading("fallback", name, (f"attitude_law.fallback={name}",)) for name in FALLBACKS]
    limits = [
        Reading("candidate limit", f"{limit:g} deg", (f"attitude_law.candidate_limit_deg={limit}",))
        for limit in CANDIDATE_LIMITS_DEG
    ]
    speeds = [
        Reading("wavelength", name, (f"link.speed_of_light={speed}",)) for name, speed in WAVELENGTH_SPEEDS.items()
    ]
    drags = [Reading("rotor drag", name, (f"airframe.drag_sign={sign}",)) for name, sign in DRAG_SIGNS.items()]
    tilts = [Reading("airframe", "tilt 20 deg"), Reading("airframe", "tilt 35 deg", SECOND_AIRFRAME)]
    return [*fallbacks, *limits, *speeds, *drags, *tilts]


def under_law(scenario: Scenario, law: str) -> Scenario:
    """A scenario under one of the laws. `level` reads no other setting of the law, so it takes their defaults."""
    if law == "level":
        return replace(scenario, attitude_law=AttitudeLaw(name=law))
    return scenario.with_value("attitude_law.name", law)
