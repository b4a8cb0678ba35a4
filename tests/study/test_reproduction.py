import dataclasses
import json

import numpy as np
import pytest

from a2s_drake import Flight, Scenario
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.scenario.parts import PAPER_LAWS
from a2s_drake.study.paper.readings import all_readings, under_law
from a2s_drake.study.paper.reproduction import HEADLINE, PRINTED, collect_results, report_scenarios
from a2s_drake.study.paper.results import PaperGains
from diagrams import load_scenario
from tests.support.flights import SAMPLES, made_up_flight

RATES = {"three_axis": 6.0, "pitch_only": 5.0, "level": 4.0, "planned": 6.4}
UNBOUNDED = AttitudeSpline(40.0, np.full((13, 3), 0.1))


@pytest.fixture
def bases() -> dict[str, Scenario]:
    return {name: load_scenario(name) for name in (HEADLINE, PRINTED)}


def made_up(scenarios: dict[str, Scenario]) -> dict[str, Flight]:
    """Flights whose throughput depends on the law, and by a hundredth on the drag sign."""
    flights = {}
    for name, scenario in scenarios.items():
        rate = RATES[scenario.attitude_law.name] * (1.0 + 0.01 * (scenario.airframe.drag_sign == 1))
        if scenario.attitude_law.name == "level":
            rate = RATES["level"]
        flight = made_up_flight(spectral_efficiency=np.full(SAMPLES, rate))
        flights[name] = dataclasses.replace(flight, scenario=scenario)
    return flights


def test_every_open_reading_is_there() -> None:
    answers: dict[str, list[str]] = {}
    for reading in all_readings():
        answers.setdefault(reading.question, []).append(reading.answer)
    assert answers == {
        "fallback": ["nearest", "zero", "index_zero"],
        "candidate limit": ["15 deg", "20 deg", "25 deg", "28.5 deg", "30 deg", "40 deg"],
        "wavelength": ["c = 299792458 m/s", "c = 3e8 m/s"],
        "rotor drag": ["drag opposes tilt", "drag adds to tilt"],
        "airframe": ["tilt 20 deg", "tilt 35 deg"],
    }


def test_each_base_is_one_reading_of_every_question(bases: dict[str, Scenario]) -> None:
    for base in bases.values():
        questions = [reading.question for reading in all_readings() if reading.is_base(base)]
        assert sorted(questions) == ["airframe", "candidate limit", "fallback", "rotor drag", "wavelength"]


def test_second_airframe_is_the_named_scenario(bases: dict[str, Scenario]) -> None:
    tilted = next(reading for reading in all_readings() if reading.answer == "tilt 35 deg")
    assert tilted.applied(bases[PRINTED]) == load_scenario("tilt35")


def test_level_flights_do_not_depend_on_the_law(bases: dict[str, Scenario]) -> None:
    readings = [reading for reading in all_readings() if reading.question in ("fallback", "candidate limit")]
    level = [under_law(reading.applied(bases[PRINTED]), "level") for reading in readings]
    assert all(scenario == level[0] for scenario in level)


def test_quick_flies_the_headline_alone(bases: dict[str, Scenario]) -> None:
    scenarios = report_scenarios(bases, quick=True)
    assert [scenario.attitude_law.name for scenario in scenarios.values()] == list(PAPER_LAWS)
    assert all(scenario.link.speed_of_light == 3e8 for scenario in scenarios.values())
    everything = report_scenarios(bases)
    assert set(scenarios) < set(everything)
    distinct = {scenario.to_yaml() for scenario in everything.values()}
    assert 45 <= len(distinct) <= 55
    assert [name for name, scenario in everything.items() if scenario.attitude_law.name == "planned"] == [
        f"{PRINTED} / planned"
    ]
    assert everything[f"{PRINTED} / planned"] == load_scenario("planned")


def test_results_say_how_far_each_reading_moves_the_headline(bases: dict[str, Scenario]) -> None:
    scenarios = report_scenarios(bases)
    results = collect_results(bases, made_up(scenarios), UNBOUNDED)
    gains = {"over_level": 50.0, "over_pitch_only": 20.0, "pitch_only_over_level": 25.0}
    assert dataclasses.asdict(results.headline.gain_percent) == pytest.approx(gains)
    assert results.paper_gain_percent == PaperGains(over_level=22.2, over_pitch_only=11.4)
    drag = {row.answer: row for row in results.readings if row.question == "rotor drag" and row.base == PRINTED}
    assert drag["drag opposes tilt"].over_level == pytest.approx(50.0)
    assert drag["drag adds to tilt"].over_level == pytest.approx(51.5)
    assert drag["drag adds to tilt"].over_pitch_only == pytest.approx(20.0)
    assert [row.is_base for row in drag.values()] == [True, False]
    for rows in results.ceilings.values():
        flown = {row.law: row for row in rows if row.kind == "flown"}
        assert flown["three_axis"].gain_percent == pytest.approx(50.0)
        assert flown["pitch_only"].gain_percent == pytest.approx(25.0)
        assert flown["pitch_only"].share == pytest.approx(25.0 / rows[0].gain_percent)


def test_the_planned_law_has_its_own_part(bases: dict[str, Scenario]) -> None:
    results = collect_results(bases, made_up(report_scenarios(bases)), UNBOUNDED)
    assert dataclasses.asdict(results.planned.gain_percent) == pytest.approx(
        {
            "planned_over_level": 60.0,
            "planned_over_three_axis": 100.0 * (6.4 / 6.0 - 1.0),
            "three_axis_over_level": 50.0,
        }
    )
    assert list(results.planned.laws) == ["three_axis", "pitch_only", "level", "planned"]
    rows = {row.kind: row for row in results.ceilings[PRINTED] if row.law == "planned"}
    assert rows["flown"].gain_percent == pytest.approx(60.0)
    assert rows["held"].gain_percent == pytest.approx(0.0)  # Made up to be level.
    assert not [row for row in results.ceilings[HEADLINE] if row.law == "planned"]
    bottom = [step for step in results.planned.attribution if step.effect == "position"]
    assert {step.law: step.gain_percent for step in bottom} == pytest.approx({"three_axis": 50.0, "planned": 60.0})


def test_claims_in_words_get_figures(bases: dict[str, Scenario]) -> None:
    flights = made_up(report_scenarios(bases, quick=True))
    for name, snr in (("three_axis", [1, -1, 1, -1, 5]), ("pitch_only", [-1, -1, 1, 1, 1]), ("level", [9, 9, 9, 9, 9])):
        key = f"{HEADLINE} / {name}"
        flights[key] = dataclasses.replace(flights[key], snr_db=np.array(snr, dtype=float))
    claims = collect_results(bases, flights).headline.claims
    assert claims.fades_below_0_db == {"three_axis": 2, "pitch_only": 1, "level": 0}
    assert claims.outage_worst_excess == 1.0  # between 5 and 9 dB, where level is never below


def test_results_hold_no_reading_of_the_clock(bases: dict[str, Scenario]) -> None:
    flights = made_up(report_scenarios(bases, quick=True))
    timeless = {name: dataclasses.replace(flight, wall_clock=None) for name, flight in flights.items()}
    results = collect_results(bases, flights)
    assert results == collect_results(bases, timeless)
    assert results.readings is None


def test_the_file_holds_every_field_by_its_key(bases: dict[str, Scenario]) -> None:
    quick = collect_results(bases, made_up(report_scenarios(bases, quick=True))).as_json()
    keys = ["paper_gain_percent", "headline", "ideal", "ceilings", "errata", "versions"]
    assert list(quick) == keys
    whole = json.loads(json.dumps(collect_results(bases, made_up(report_scenarios(bases)), UNBOUNDED).as_json()))
    assert list(whole) == [*keys, "readings", "beyond"]
    assert whole["beyond"]["gain_percent"]["planned_over_level"] == pytest.approx(60.0)
    gains = ["over_level", "over_pitch_only", "pitch_only_over_level"]
    assert list(whole["readings"][0]) == [
        *("base", "question", "answer", "is_base", *gains, "position_error_max_m", "solver_failures")
    ]
    assert list(whole["ceilings"][PRINTED][0]) == ["name", "kind", "law", "gain_percent", "share"]
    assert list(whole["ideal"][PRINTED]["ceiling_percent"]) == ["box", "hoverable"]
    assert {row["kind"] for row in whole["ceilings"][PRINTED]} == {"ceiling", "ideal", "flown", "other"}
