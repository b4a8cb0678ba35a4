"""The reproduction: which flights answer the paper, and the numbers that they give."""

from collections.abc import Mapping
from dataclasses import asdict

import numpy as np

from a2s_drake.flight import feasible
from a2s_drake.flight.log import Flight
from a2s_drake.flight.metrics import compute_metrics, fades, gain_percent, outage_curve
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.scenario.parts import LAW_NAMES, PAPER_LAWS
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.study.ideal_tracking import Geometry, IdealTracking, held_gain, measure_ideal_tracking
from a2s_drake.study.paper.attribution import attribution
from a2s_drake.study.paper.comparison import PAPER_GAINS
from a2s_drake.study.paper.errata import errata
from a2s_drake.study.paper.readings import all_readings, under_law
from a2s_drake.study.paper.results import (
    CeilingRow,
    Claims,
    Gains,
    Headline,
    Metrics,
    PaperGains,
    PlannedGains,
    PlannedLaw,
    ReadingRow,
    Results,
)

# The scenario of the headline, and the one with Table I as printed; readings are varied from both.
HEADLINE, PRINTED = "paper_calibrated", "paper"


def flight_name(base: str, law: str, question: str = "", answer: str = "") -> str:
    """The name of a flight in the report: the base scenario, the reading if one is varied, and the law."""
    return " / ".join(filter(None, (base, question, answer, law)))


def report_scenarios(bases: Mapping[str, Scenario], *, quick: bool = False) -> dict[str, Scenario]:
    """Every flight of the report by name, validated.

    Args:
      bases: the scenarios named HEADLINE and PRINTED.
      quick: gives only the flights that the headline of the paper needs.
    """
    flights = {flight_name(HEADLINE, law): under_law(bases[HEADLINE], law) for law in PAPER_LAWS}
    if not quick:
        flights[flight_name(PRINTED, "planned")] = under_law(bases[PRINTED], "planned")
        for base, scenario in bases.items():
            flights |= {flight_name(base, law): under_law(scenario, law) for law in PAPER_LAWS}
            for reading in all_readings():
                read = reading.applied(scenario)
                for law in PAPER_LAWS:
                    flights[flight_name(base, law, reading.question, reading.answer)] = under_law(read, law)
    return {name: feasible.check(scenario) for name, scenario in flights.items()}


def headline_flights(flights: Mapping[str, Flight]) -> dict[str, Flight]:
    """The headline scenario's flights by law."""
    return {law: flights[flight_name(HEADLINE, law)] for law in PAPER_LAWS}


def printed_flights(flights: Mapping[str, Flight]) -> dict[str, Flight]:
    """The flights of Table I as printed, by law, `planned` among them."""
    return {law: flights[flight_name(PRINTED, law)] for law in LAW_NAMES}


def _gains(by_law: Mapping[str, Flight]) -> Gains:
    mine = by_law["three_axis"]
    return Gains(
        over_level=gain_percent(mine, by_law["level"]),
        over_pitch_only=gain_percent(mine, by_law["pitch_only"]),
        pitch_only_over_level=gain_percent(by_law["pitch_only"], by_law["level"]),
    )


def reading_rows(bases: Mapping[str, Scenario], flights: Mapping[str, Flight]) -> list[ReadingRow]:
    """What each reading makes of the headline, from both bases."""
    rows = []
    for base, scenario in bases.items():
        for reading in all_readings():
            by_law = {law: flights[flight_name(base, law, reading.question, reading.answer)] for law in PAPER_LAWS}
            metrics = {law: compute_metrics(flight) for law, flight in by_law.items()}
            rows.append(
                ReadingRow(
                    base=base,
                    question=reading.question,
                    answer=reading.answer,
                    is_base=reading.is_base(scenario),
                    **asdict(_gains(by_law)),
                    position_error_max_m=metrics["three_axis"]["position_error_max_m"],
                    solver_failures=sum(entry["solver"]["failures"] for entry in metrics.values()),
                )
            )
    return rows


def ceiling_rows(scenario: Scenario, held: IdealTracking, by_law: Mapping[str, Flight] | None) -> list[CeilingRow]:
    """Each way to choose the attitude in one scenario, from the ceiling down, with its share of the ceiling.

    Args:
      held: the scenario's ideal tracking.
      by_law: its flights; without them the rows of closed loops are absent.
    """
    fallback = scenario.attitude_law.fallback
    rows = [("best in the attitude box", "ceiling", "", held.ceiling_percent.box)]
    rows.append(("best statically hoverable", "ceiling", "", held.ceiling_percent.hoverable))
    for law, gains in held.gain_percent.items():
        rows.append((f"ideally tracked, {fallback}", "held", law, gains[fallback]))
        rows += [(f"ideally tracked, {name}", "other", law, gain) for name, gain in gains.items() if name != fallback]
    if by_law is not None and "planned" in by_law:
        plan = by_law["planned"]
        exactly = held_gain(scenario, Geometry.of_flight(plan), plan.attitude_reference)
        rows.append(("ideally tracked", "held", "planned", exactly))
        rows.append(("flown", "flown", "planned", gain_percent(plan, by_law["level"])))
    if by_law is not None:
        flown = _gains(by_law)
        rows.append(("flown", "flown", "three_axis", flown.over_level))
        rows.append(("flown", "flown", "pitch_only", flown.pitch_only_over_level))
    best = held.ceiling_percent.box
    return [CeilingRow(name, kind, law, gain, share=gain / best) for name, kind, law, gain in rows]


def _claims(by_law: Mapping[str, Flight]) -> Claims:
    """What the paper says in words of its curves, in figures."""
    thresholds = np.linspace(-10.0, 20.0, 601)
    curves = {law: outage_curve(flight, thresholds) for law, flight in by_law.items()}
    excess = curves["three_axis"] - np.minimum(curves["pitch_only"], curves["level"])
    return Claims(
        fades_below_0_db={law: fades(flight) for law, flight in by_law.items()},
        outage_worst_excess=float(excess.max()),
        outage_worst_excess_at_db=float(thresholds[excess.argmax()]),
    )


def _planned_law(by_law: Mapping[str, Flight], unbounded: AttitudeSpline) -> PlannedLaw:
    """The law `planned` beside the paper's on Table I as printed, and what each effect costs either."""
    gains = PlannedGains(
        planned_over_level=gain_percent(by_law["planned"], by_law["level"]),
        planned_over_three_axis=gain_percent(by_law["planned"], by_law["three_axis"]),
        three_axis_over_level=gain_percent(by_law["three_axis"], by_law["level"]),
    )
    laws = {law: _reproducible(compute_metrics(flight)) for law, flight in by_law.items()}
    return PlannedLaw(PRINTED, gains, laws, attribution(by_law, unbounded))


def _reproducible(metrics: Metrics) -> Metrics:
    """Metrics without those that depend on the machine's clock."""
    kept = {name: value for name, value in metrics.items() if name not in ("wall_s", "real_time_factor", "versions")}
    return kept | {"solver": {name: value for name, value in kept["solver"].items() if name != "step_ms"}}


def collect_results(
    bases: Mapping[str, Scenario], flights: Mapping[str, Flight], unbounded: AttitudeSpline | None = None
) -> Results:
    """All numbers of the report, the same on every run.

    Args:
      unbounded: the plan of `without_rate_bound(bases[PRINTED])`. Without it this is a quick report on the headline's
        flights alone, which lacks `readings`, `planned` and the closed loops of Table I as printed.
    """
    by_law = headline_flights(flights)
    metrics = {law: compute_metrics(flight) for law, flight in by_law.items()}
    held = {base: measure_ideal_tracking(scenario) for base, scenario in bases.items()}
    flown = {HEADLINE: by_law}
    if unbounded is not None:
        flown[PRINTED] = printed_flights(flights)
    headline = Headline(
        scenario=HEADLINE,
        gain_percent=_gains(by_law),
        laws={law: _reproducible(entry) for law, entry in metrics.items()},
        claims=_claims(by_law),
    )
    return Results(
        paper_gain_percent=PaperGains(**{f"over_{baseline}": gain for (_, baseline), gain in PAPER_GAINS.items()}),
        headline=headline,
        ideal_tracking=held,
        ceilings={base: ceiling_rows(bases[base], held[base], flown.get(base)) for base in bases},
        errata=errata(bases[PRINTED]),
        versions=metrics["level"]["versions"],
        readings=None if unbounded is None else reading_rows(bases, flights),
        planned=None if unbounded is None else _planned_law(flown[PRINTED], unbounded),
    )
