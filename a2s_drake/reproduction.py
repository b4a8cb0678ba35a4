"""The reproduction: which flights answer the paper, and what they say, as one dictionary of numbers."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from a2s_drake.comparison import PAPER_GAINS
from a2s_drake.errata import errata
from a2s_drake.flight import Flight
from a2s_drake.ideal import ideal_study
from a2s_drake.metrics import compute_metrics, gain_percent
from a2s_drake.parameters import LAWS
from a2s_drake.readings import all_readings, under_law
from a2s_drake.scenario import Scenario

# The scenario of the headline, and the one with Table I as printed; readings are varied from both.
HEADLINE, PRINTED = "paper_calibrated", "paper"


def flight_name(base: str, law: str, question: str = "", answer: str = "") -> str:
    """What a flight of a campaign goes by."""
    return " / ".join(filter(None, (base, question, answer, law)))


def planned_flights(bases: Mapping[str, Scenario], *, quick: bool = False) -> dict[str, Scenario]:
    """Every flight of the report by name, validated; with `quick` the headline scenario's alone.

    Args:
      bases: the scenarios named HEADLINE and PRINTED.
    """
    flights = {flight_name(HEADLINE, law): under_law(bases[HEADLINE], law) for law in LAWS}
    if not quick:
        for base, scenario in bases.items():
            flights |= {flight_name(base, law): under_law(scenario, law) for law in LAWS}
            for reading in all_readings():
                read = reading.applied(scenario)
                for law in LAWS:
                    flights[flight_name(base, law, reading.question, reading.answer)] = under_law(read, law)
    return {name: scenario.validate() for name, scenario in flights.items()}


def headline_flights(flights: Mapping[str, Flight]) -> dict[str, Flight]:
    """The headline scenario's flights by law."""
    return {law: flights[flight_name(HEADLINE, law)] for law in LAWS}


def _gains(by_law: Mapping[str, Flight]) -> dict[str, float]:
    mine = by_law["three_axis"]
    return {
        "over_level": gain_percent(mine, by_law["level"]),
        "over_pitch_only": gain_percent(mine, by_law["pitch_only"]),
    }


def reading_rows(bases: Mapping[str, Scenario], flights: Mapping[str, Flight]) -> list[dict[str, Any]]:
    """What each reading makes of the headline, from both bases."""
    rows = []
    for base, scenario in bases.items():
        for reading in all_readings():
            by_law = {law: flights[flight_name(base, law, reading.question, reading.answer)] for law in LAWS}
            metrics = {law: compute_metrics(flight) for law, flight in by_law.items()}
            rows.append(
                {
                    "base": base,
                    "question": reading.question,
                    "answer": reading.answer,
                    "is_base": reading.is_base(scenario),
                    **_gains(by_law),
                    "position_error_max_m": metrics["three_axis"]["position_error_max_m"],
                    "solver_failures": sum(entry["solver"]["failures"] for entry in metrics.values()),
                }
            )
    return rows


def ceiling_rows(ideal: Mapping[str, Any], rows: list[dict[str, Any]]) -> list[tuple[str, str, float]]:
    """Name, kind and gain over level, %, of each way to choose the attitude, from the ceiling down."""
    gain, ceiling = ideal["gain_percent"], ideal["ceiling_percent"]
    flown = {row["base"]: row["over_level"] for row in rows if row["is_base"]}
    return [
        ("best in the attitude box", "ceiling", ceiling["box"]),
        ("best statically hoverable", "ceiling", ceiling["hoverable"]),
        ("three axes, nearest", "ideal", gain["three_axis"]["nearest"]),
        ("three axes, index zero", "ideal", gain["three_axis"]["index_zero"]),
        ("three axes, zero", "ideal", gain["three_axis"]["zero"]),
        ("pitch only, nearest", "ideal", gain["pitch_only"]["nearest"]),
        ("pitch only, index zero", "ideal", gain["pitch_only"]["index_zero"]),
        ("pitch only, zero", "ideal", gain["pitch_only"]["zero"]),
        *((f"three axes, {base}", "flown", value) for base, value in flown.items()),
    ]


def _reproducible(metrics: dict[str, Any]) -> dict[str, Any]:
    """Metrics short of what the machine's clock put in."""
    kept = {name: value for name, value in metrics.items() if name not in ("wall_s", "real_time_factor", "versions")}
    return kept | {"solver": {name: value for name, value in kept["solver"].items() if name != "step_ms"}}


def collect_results(
    bases: Mapping[str, Scenario], flights: Mapping[str, Flight], *, quick: bool = False
) -> dict[str, Any]:
    """All numbers of the report, the same on every run: headline, readings, ceilings, errata.

    `readings` and `ceilings` are absent from a quick report, which flies the headline alone.
    """
    by_law = headline_flights(flights)
    metrics = {law: compute_metrics(flight) for law, flight in by_law.items()}
    ideal = ideal_study(bases[PRINTED])
    results: dict[str, Any] = {
        "paper_gain_percent": {f"over_{baseline}": gain for (_, baseline), gain in PAPER_GAINS.items()},
        "headline": {
            "scenario": HEADLINE,
            "gain_percent": _gains(by_law),
            "laws": {law: _reproducible(entry) for law, entry in metrics.items()},
        },
        "ideal": ideal,
        "errata": [asdict(erratum) for erratum in errata(bases[PRINTED])],
        "versions": metrics["level"]["versions"],
    }
    if not quick:
        results["readings"] = reading_rows(bases, flights)
        rows = ceiling_rows(ideal, results["readings"])
        results["ceilings"] = [{"name": name, "kind": kind, "gain_percent": gain} for name, kind, gain in rows]
    return results
