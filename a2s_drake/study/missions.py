"""The law `planned` against the paper's law and level on other missions than Table I, twenty of them at random."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.flight import feasible
from a2s_drake.flight.log import Flight
from a2s_drake.flight.metrics import bounds, gain_percent, position_error, solver_summary, throughput
from a2s_drake.link.throughput import gain_percent as throughput_gain
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.study.ideal_tracking import (
    Geometry,
    best_measured_attitude,
    held_gain,
    held_throughput,
    measured_attitude,
)
from a2s_drake.study.paper.readings import SECOND_AIRFRAME, under_law

# The scenarios that are varied: the first one's weights fly level and the paper's law, the second one's fly the plan.
PAPER, PLANNED = "paper", "planned"
RANDOM_MISSIONS, SEED = 20, 20261122
_RANDOM = "random_"

# Wide enough for every mission: the paper's window is made for Table I.
_WINDOW = ("attitude_law.index_min=-5000", "attitude_law.index_max=5000")
_FLIGHTS = ("level", "nearest", "zero", "planned")
# Every tenth sample shows the static ceiling well enough: on Table I +43.07 % in place of +43.24 %.
_CEILING_STRIDE = 10
# Below this planned gain, %, attitude has nothing to win, and a share of it says nothing.
_LEAST_GAIN = 1.0


@dataclass(frozen=True)
class OtherMission:
    """A mission: what sets it apart from Table I, in words and as overrides."""

    words: str
    overrides: tuple[str, ...] = ()


def other_missions() -> dict[str, OtherMission]:
    """Every mission of the study by name, the same on every call: Table I, one change at a time, and at random."""
    fixed = {
        "table_1": OtherMission("nothing"),
        "1.5_ghz": OtherMission("1.5 GHz", ("link.carrier_hz=1.5e9",)),
        "5.8_ghz": OtherMission("5.8 GHz", ("link.carrier_hz=5.8e9",)),
        **{f"{distance}_m": _at_range(distance) for distance in (60, 150, 300, 1000)},
        "radius_1": OtherMission("circle of 1 m", ("mission.radius=1.0",)),
        "radius_4": OtherMission("circle of 4 m", ("mission.radius=4.0",)),
        "altitude_10": OtherMission("10 m above the sea", ("mission.sea_level=-10.0",)),
        "altitude_40": OtherMission("40 m above the sea", ("mission.sea_level=-40.0",)),
        "tilt_35": OtherMission("rotors tilted by 35 deg", SECOND_AIRFRAME),
    }
    rng = np.random.default_rng(SEED)
    return fixed | {f"{_RANDOM}{number:02d}": _at_random(rng) for number in range(1, RANDOM_MISSIONS + 1)}


def _at_range(distance: int) -> OtherMission:
    """The ship's track of Table I, begun at another distance."""
    track = (f"mission.ship_start=[{distance}.0, 0.0]", f"mission.ship_end=[{distance + 10}.0, 0.0]")
    return OtherMission(f"ship {distance} m away", track)


def _at_random(rng: np.random.Generator) -> OtherMission:
    """A mission drawn evenly from ranges; what it does not draw is as in Table I."""
    carrier = rng.uniform(1.0, 6.0)  # GHz
    distance, bearing = rng.uniform(60.0, 300.0), rng.uniform(-np.pi, np.pi)  # of the ship at first
    speed, course = rng.uniform(0.0, 1.0), rng.uniform(-np.pi, np.pi)  # of the ship
    radius, altitude, antenna = rng.uniform(0.5, 2.65), rng.uniform(10.0, 50.0), rng.uniform(5.0, 20.0)
    second = bool(rng.integers(2))
    start = distance * np.array([np.cos(bearing), np.sin(bearing)])
    end = start + 40.0 * speed * np.array([np.cos(course), np.sin(course)])
    words = (
        f"{carrier:.2f} GHz; ship {distance:.0f} m away at {np.degrees(bearing):.0f} deg, {speed:.2f} m/s on course "
        f"{np.degrees(course):.0f} deg, antenna {antenna:.1f} m; circle of {radius:.2f} m, {altitude:.0f} m above the "
        f"sea; tilt {35 if second else 20} deg"
    )
    overrides = (
        f"link.carrier_hz={carrier * 1e9:.0f}.0",
        f"link.ship_antenna_height={antenna:.3f}",
        f"mission.radius={radius:.3f}",
        f"mission.sea_level={-altitude:.3f}",
        f"mission.ship_start=[{start[0]:.3f}, {start[1]:.3f}]",
        f"mission.ship_end=[{end[0]:.3f}, {end[1]:.3f}]",
        *(SECOND_AIRFRAME if second else ()),
    )
    return OtherMission(words, overrides)


def flight_name(mission: str, flight: str) -> str:
    """The name of a flight in the study. `flight` is `level`, a fallback of the paper's law, or `planned`."""
    return f"{mission}, {flight}"


def mission_scenarios(bases: Mapping[str, Scenario], missions: Sequence[str]) -> dict[str, Scenario]:
    """Every flight of some missions by name, mission by mission.

    Args:
      bases: the scenarios named PAPER and PLANNED.
      missions: names in `other_missions`.
    Raises:
      ScenarioError: when one cannot be flown.
    """
    known = other_missions()
    scenarios: dict[str, Scenario] = {}
    for name in missions:
        overrides = [*known[name].overrides, *_WINDOW]
        paper, planned = (bases[base].with_overrides(overrides) for base in (PAPER, PLANNED))
        by_flight = {
            "level": under_law(paper, "level"),
            **{
                fallback: under_law(paper, "three_axis").with_value("attitude_law.fallback", fallback)
                for fallback in ("nearest", "zero")
            },
            "planned": under_law(planned, "planned"),
        }
        scenarios |= {flight_name(name, flight): feasible.check(scenario) for flight, scenario in by_flight.items()}
    return scenarios


@dataclass(frozen=True)
class Outcome:
    """A mission in numbers. Gains are over level, %: of a flight over level flown, of a held attitude over level held.

    Attributes:
      level_throughput: of the level flight, bit/Hz.
      flown_gain: of the paper's law under `nearest` and `zero`, and of `planned`.
      path_gain: the same with the attitudes as flown, but every position on the reference path: won by attitude alone.
      plan_gain: of the plan held exactly, a certified local optimum with margins: the dynamic ceiling, as far as known.
      hover_gain: of the best statically hoverable attitude at every instant: the static ceiling.
      plan_share: throughput of `planned` over that of its plan held exactly.
      position_error: largest in `planned`, m.
      failures: of the solver, over the mission's flights.
      excess: the furthest step of `planned` beyond a bound, as a share of the bound's range.
    """

    level_throughput: float
    flown_gain: dict[str, float]
    path_gain: dict[str, float]
    plan_gain: float
    hover_gain: float
    plan_share: float
    position_error: float
    failures: int
    excess: float

    @property
    def over_paper(self) -> float:
        """How much more `planned` transmits than the paper's law under the better of its fallbacks, %."""
        return _over_paper(self.flown_gain)

    @property
    def over_paper_on_path(self) -> float:
        """The same on the reference path: the paper's law, softly tracked, wins or loses by leaving it."""
        return _over_paper(self.path_gain)

    @property
    def gain_share(self) -> float | None:
        """The flown gain of `planned` over the gain of its plan; None where the latter is nearly zero."""
        return self.flown_gain["planned"] / self.plan_gain if self.plan_gain >= _LEAST_GAIN else None


def _over_paper(gains: Mapping[str, float]) -> float:
    return throughput_gain(100.0 + gains["planned"], 100.0 + max(gains["nearest"], gains["zero"]))


def outcome(flights: Mapping[str, Flight], mission: str) -> Outcome:
    """A mission's numbers, from the flights of `mission_scenarios`."""
    flown = {name: flights[flight_name(mission, name)] for name in _FLIGHTS}
    level, planned = flown["level"], flown["planned"]
    plan = planned.attitude_reference
    on_path = {name: _held(flight, measured_attitude(flight)) for name, flight in flown.items()}
    return Outcome(
        level_throughput=throughput(level),
        flown_gain={name: gain_percent(flown[name], level) for name in _FLIGHTS[1:]},
        path_gain={name: throughput_gain(on_path[name], on_path["level"]) for name in _FLIGHTS[1:]},
        plan_gain=held_gain(planned.scenario, Geometry.of_flight(planned), plan),
        hover_gain=_hover_gain(planned),
        plan_share=throughput(planned) / _held(planned, plan),
        position_error=float(position_error(planned).max()),
        failures=sum(solver_summary(flight).failures for flight in flown.values()),
        excess=max(bound.worst_excess_of_range for bound in bounds(planned).values()),
    )


def _held(flight: Flight, eta: FloatArray) -> float:
    """Throughput of a measured attitude (n, 3) held exactly on a flight's reference path, bit/Hz."""
    return held_throughput(flight.scenario, Geometry.of_flight(flight), eta)


def _hover_gain(flight: Flight) -> float:
    geometry = Geometry.of_flight(flight).every(_CEILING_STRIDE)
    best = best_measured_attitude(flight.scenario, geometry, hoverable=True)
    return held_gain(flight.scenario, geometry, best)


def missions_table(names: Sequence[str]) -> str:
    """What the missions are, as Markdown."""
    known = other_missions()
    rows = [f"| {name} | {known[name].words} |" for name in names]
    return "\n".join(["| mission | Table I, but for |", "|---|---|", *rows])


def outcome_table(outcomes: Mapping[str, Outcome]) -> str:
    """One row a mission, as Markdown; the last columns compare each ceiling with what is left below it."""
    head = [
        "mission",
        "level, bit/Hz",
        "paper, nearest",
        "paper, zero",
        "planned",
        "over the paper",
        "the same, positions on the path",
        "plan held",
        "best hoverable",
        "plan over hoverable",
        "flown over plan",
        "gain over gain",
        "error max",
    ]
    lines = [f"| {' | '.join(head)} |", f"|{len(head) * '---|'}"]
    for name, row in outcomes.items():
        cells = [
            name,
            f"{row.level_throughput:.1f}",
            *(f"{row.flown_gain[flight]:+.2f} %" for flight in _FLIGHTS[1:]),
            f"{row.over_paper:+.2f} %",
            f"{row.over_paper_on_path:+.2f} %",
            f"{row.plan_gain:+.2f} %",
            f"{row.hover_gain:+.2f} %",
            f"{(100.0 + row.plan_gain) / (100.0 + row.hover_gain):.1%}",
            f"{row.plan_share:.2%}",
            "-" if row.gain_share is None else f"{row.gain_share:.1%}",
            f"{100.0 * row.position_error:.2f} cm",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def missions_report(outcomes: Mapping[str, Outcome]) -> str:
    """The missions, their numbers, and summaries of all missions and of those drawn at random."""
    drawn = {name: row for name, row in outcomes.items() if name.startswith(_RANDOM)}
    parts = [missions_table(list(outcomes)), outcome_table(outcomes), "All missions:", _summary(outcomes)]
    if drawn:
        parts += ["Missions drawn at random:", _summary(drawn)]
    return "\n\n".join(parts)


def _summary(outcomes: Mapping[str, Outcome]) -> str:
    """The worst mission in each respect, and the median share of the plan that is flown."""
    rows = list(outcomes.values())
    over_level = {name: row.flown_gain["planned"] for name, row in outcomes.items()}
    over_paper = {name: row.over_paper for name, row in outcomes.items()}
    on_path = {name: row.over_paper_on_path for name, row in outcomes.items()}
    throughput_share = np.median([row.plan_share for row in rows])
    gain_shares = [row.gain_share for row in rows if row.gain_share is not None]
    gain_share = f"{np.median(gain_shares):.1%}" if gain_shares else "-"
    lines = [
        f"least of planned over level: {_least(over_level)}",
        f"least of planned over the paper's law, the better fallback: {_least(over_paper)}",
        f"the same with every position on the path: {_least(on_path)}",
        f"median of flown over plan, throughput: {throughput_share:.2%}",
        f"median of flown over plan, gain (where the plan wins {_LEAST_GAIN:g} % or more): {gain_share}",
        f"largest position error of planned: {100.0 * max(row.position_error for row in rows):.2f} cm",
        f"solver failures: {sum(row.failures for row in rows)}",
        f"worst bound excess of planned: {max(row.excess for row in rows):.1g} of the bound's range",
    ]
    return "\n".join(f"- {line}" for line in lines)


def _least(gains: Mapping[str, float]) -> str:
    name = min(gains, key=gains.__getitem__)
    return f"{gains[name]:+.2f} % ({name})"
