from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Flight, Scenario, run_flight
from a2s_drake.guidance.plan.cache import plan_for_law
from a2s_drake.scenario.parts import Link
from a2s_drake.study.ceiling import throughput_of
from a2s_drake.study.missions import (
    PAPER,
    PLANNED,
    RANDOM_MISSIONS,
    flight_name,
    mission_scenarios,
    missions_report,
    other_missions,
    outcome,
)
from diagrams import build_closed_loop, load_scenario
from scripts import flying, missions
from tests.support.flights import SAMPLES, made_up_flight

FLIGHTS = ("level", "nearest", "zero", "planned")


def bases() -> dict[str, Scenario]:
    return {name: load_scenario(name) for name in (PAPER, PLANNED)}


def at_random() -> list[str]:
    return [name for name in other_missions() if name.startswith("random")]


def held(eta: np.ndarray) -> float:
    """Throughput of an attitude held through a made-up flight, bit/Hz."""
    position, ship = np.zeros((SAMPLES, 3)), np.tile([90.0, 0.0, -20.0], (SAMPLES, 1))
    return throughput_of(position, eta, ship, Link(), 0.02)


def made_up_mission(name: str, rates: dict[str, float]) -> dict[str, Flight]:
    """A mission's flights at given spectral efficiencies, bit/s/Hz; `planned` has a plan of 0.1 rad on each axis."""
    flights = {}
    for flight, rate in rates.items():
        law = flight if flight in ("level", "planned") else "three_axis"
        reference = np.full((SAMPLES, 3), 0.1 if law == "planned" else 0.0)
        efficiency = np.full(SAMPLES, rate)
        flights[flight_name(name, flight)] = made_up_flight(
            law, spectral_efficiency=efficiency, attitude_reference=reference
        )
    return flights


def test_missions_are_the_same_on_every_call() -> None:
    known = other_missions()
    assert known == other_missions()
    assert len(at_random()) == RANDOM_MISSIONS == 20
    assert len({mission.overrides for mission in known.values()}) == len(known)


def test_every_mission_is_valid_and_flown_four_ways() -> None:
    scenarios = mission_scenarios(bases(), list(other_missions()))  # which validates
    assert list(scenarios) == [flight_name(name, flight) for name in other_missions() for flight in FLIGHTS]
    assert len({scenario.to_yaml() for scenario in scenarios.values()}) == len(scenarios)
    for name in other_missions():
        level, nearest, zero, planned = (scenarios[flight_name(name, flight)] for flight in FLIGHTS)
        assert [flown.attitude_law.name for flown in (level, nearest, zero, planned)] == [
            *("level", "three_axis", "three_axis", "planned")
        ]
        assert (nearest.attitude_law.fallback, zero.attitude_law.fallback) == ("nearest", "zero")
        assert level.mpc == nearest.mpc == zero.mpc == load_scenario("paper").mpc
        assert planned.mpc == load_scenario("planned").mpc
        for flown in (nearest, zero, planned):
            assert (flown.link, flown.mission, flown.airframe) == (level.link, level.mission, level.airframe)


def test_table_i_is_itself_but_for_the_window() -> None:
    scenario = mission_scenarios(bases(), ["table_1"])["table_1, nearest"]
    scenario.attitude_law.index_min, scenario.attitude_law.index_max = -50, 50
    assert scenario == load_scenario("paper")


def test_random_missions_fill_their_ranges() -> None:
    scenarios = mission_scenarios(bases(), at_random())
    flown = [scenarios[flight_name(name, "planned")] for name in at_random()]
    away = [float(np.hypot(*scenario.mission.ship_start)) for scenario in flown]
    for values, low, high in (
        ([scenario.link.carrier_hz / 1e9 for scenario in flown], 1.0, 6.0),
        ([scenario.link.ship_antenna_height for scenario in flown], 5.0, 20.0),
        ([scenario.mission.radius for scenario in flown], 0.5, 2.65),
        ([-scenario.mission.sea_level for scenario in flown], 10.0, 50.0),
        (away, 60.0, 300.0),
    ):
        assert low <= min(values) < low + 0.25 * (high - low)
        assert high >= max(values) > high - 0.25 * (high - low)
    assert {scenario.airframe.tilt_deg for scenario in flown} == {20.0, 35.0}


def test_outcome_of_made_up_flights() -> None:
    row = outcome(made_up_mission("table_1", {"level": 2.0, "nearest": 2.2, "zero": 2.1, "planned": 3.0}), "table_1")
    plan, level = held(np.full((SAMPLES, 3), 0.1)), held(np.zeros((SAMPLES, 3)))
    assert row.level_throughput == pytest.approx(0.2)
    assert row.flown_gain == pytest.approx({"nearest": 10.0, "zero": 5.0, "planned": 50.0})
    assert row.path_gain == {"nearest": 0.0, "zero": 0.0, "planned": 0.0}  # All are made up to fly level.
    assert row.over_paper == pytest.approx(100.0 * (3.0 / 2.2 - 1.0))
    assert row.plan_gain == pytest.approx(100.0 * (plan / level - 1.0))
    assert row.plan_share == pytest.approx(0.3 / plan)
    assert (row.failures, row.position_error, row.excess) == (0, 0.0, 0.0)
    assert row.hover_gain > 0.0


def test_on_the_reference_path_attitude_alone_counts() -> None:
    flights = made_up_mission("table_1", {"level": 2.0, "nearest": 2.2, "zero": 2.1, "planned": 3.0})
    eta = np.full((SAMPLES, 3), 0.1)
    flights["table_1, planned"] = made_up_flight("planned", attitude=eta, position=np.ones((SAMPLES, 3)))
    gain = 100.0 * (held(eta) / held(np.zeros((SAMPLES, 3))) - 1.0)
    row = outcome(flights, "table_1")
    assert row.path_gain["planned"] == pytest.approx(gain)
    assert row.over_paper_on_path == pytest.approx(gain)


def test_outcome_counts_what_went_wrong() -> None:
    flights = made_up_mission("table_1", {"level": 2.0, "nearest": 2.2})
    failed, aside = np.ones(SAMPLES), np.zeros((SAMPLES, 3))
    failed[1:3], aside[2, 1] = 0.0, -0.04
    flights["table_1, zero"] = made_up_flight(solver_success=failed)
    flights["table_1, planned"] = made_up_flight("planned", position=aside, velocity=np.full((SAMPLES, 3), -1.2))
    row = outcome(flights, "table_1")
    assert row.failures == 2
    assert row.position_error == pytest.approx(0.04)
    assert row.excess == pytest.approx(0.1)  # 0.2 m/s beyond a range of 2 m/s
    assert row.plan_gain == 0.0
    assert row.gain_share is None


def test_report_has_a_row_for_each_and_names_the_worst() -> None:
    rates = {"level": 2.0, "nearest": 2.2, "zero": 2.4}
    planned = {"table_1": 3.0, "random_01": 2.3, "random_02": 2.6}
    outcomes = {name: outcome(made_up_mission(name, rates | {"planned": rate}), name) for name, rate in planned.items()}
    listed, table, *summaries = missions_report(outcomes).split("\n\n")
    assert listed.splitlines()[2] == "| table_1 | nothing |"
    assert [line.split(" | ")[0].removeprefix("| ") for line in table.splitlines()[2:]] == list(planned)
    assert len({line.count("|") for line in table.splitlines()}) == 1
    assert "planned over level: +15.00 % (random_01)" in summaries[1]
    assert "better fallback: -4.17 % (random_01)" in summaries[1]
    assert summaries[2] == "Missions drawn at random:"
    assert missions_report({"table_1": outcomes["table_1"]}).count("\n\n") == 3


def test_script_prints_the_report_and_says_where_it_is(tmp_path: Path, monkeypatch, capsys) -> None:
    flown: list[str] = []
    planned: list[float] = []
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))

    def fly(scenario: Scenario, _place: int) -> Flight:
        flown.append(scenario.attitude_law.name)
        return replace(made_up_flight(), scenario=scenario)

    monkeypatch.setattr(flying, "fly_quietly", fly)
    monkeypatch.setattr(flying, "plan_quietly", lambda scenario, _: planned.append(scenario.mission.radius))
    monkeypatch.setattr(flying, "worker_processes", ThreadPoolExecutor)
    assert missions.main(["radius_1", "--jobs", "1", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert (tmp_path / "missions.md").read_text() in printed + "\n"
    assert f"are in {tmp_path}" in printed
    assert sorted(flown) == ["level", "planned", "three_axis", "three_axis"]
    assert planned == [1.0]


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["table_2"], "no mission named 'table_2'; there are: table_1"),
        (["--set", "attitude_law.name=level"], "this script chooses the laws"),
        (["--set", "mission.duration=1.0"], "mission.duration = 1.0"),
        (["--jobs", "0"], "--jobs 0: must be at least 1"),
    ],
)
def test_script_refuses_in_one_line(arguments: list[str], reason: str, refuses) -> None:
    refuses(missions, arguments, reason)


@pytest.mark.slow
def test_a_mission_at_random_in_closed_loop() -> None:
    name = "random_04"  # one of those with the least lead
    scenarios = mission_scenarios(bases(), [name])
    flights = {
        flight: run_flight(build_closed_loop(flown, plan=plan_for_law(flown)), flown)
        for flight, flown in scenarios.items()
    }
    row = outcome(flights, name)
    assert row.flown_gain["planned"] == pytest.approx(35.29, abs=0.1)
    assert row.over_paper == pytest.approx(1.18, abs=0.1)
    assert row.plan_share > 0.999
    assert (row.failures, row.excess) == (0, 0.0)
    assert row.position_error < 1e-3
