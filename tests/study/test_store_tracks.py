"""Kept flights go by what their track files hold, not by the names of these files."""

import dataclasses
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Flight, Scenario, ScenarioError
from a2s_drake.scenario.track_file import read_files
from a2s_drake.study.store import FlightStore, load_or_fly
from tests.support.flights import made_up_flight
from tests.support.tracks import write_track

POINTS = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]])


def flying(file: Path, points: np.ndarray = POINTS) -> Scenario:
    """A flight of five samples on the path of a file, which is written."""
    write_track(file, np.array([0.0, 40.0]), points)
    return Scenario().with_overrides([f"mission.path_file={file}", "simulation.duration=0.08"])


def flight_of(scenario: Scenario, _place: int = 0) -> Flight:
    return dataclasses.replace(made_up_flight(), scenario=scenario, files=read_files(scenario.mission))


@pytest.fixture
def store(tmp_path: Path) -> FlightStore:
    return FlightStore(tmp_path / "flights", "code")


def test_a_kept_flight_goes_by_the_content_of_its_file(store: FlightStore, tmp_path: Path) -> None:
    dut = flying(tmp_path / "path.csv")
    store.save(flight_of(dut))
    found = store.find(dut)
    assert found is not None
    assert found.scenario == dut
    assert found.files == flight_of(dut).files
    assert store.find(flying(tmp_path / "renamed.csv")) is not None
    assert store.find(dut.with_value("mission.path_file", None)) is None
    assert store.find(flying(tmp_path / "path.csv", POINTS + 1.0)) is None
    assert store.find(flying(tmp_path / "path.csv")) is not None


def test_a_kept_flight_outlives_its_file(store: FlightStore, tmp_path: Path) -> None:
    flight = flight_of(flying(tmp_path / "path.csv"))
    (tmp_path / "path.csv").unlink()
    store.save(flight)
    again = store.find(flying(tmp_path / "elsewhere.csv"))
    assert again is not None
    (tmp_path / "elsewhere.csv").unlink()
    again.save(tmp_path / "out")
    assert Flight.load(tmp_path / "out").files == flight.files


def test_a_kept_copy_that_was_changed_is_damage(store: FlightStore, tmp_path: Path) -> None:
    dut = flying(tmp_path / "path.csv")
    store.save(flight_of(dut))
    copy = store.place(dut) / "path.csv"
    write_track(copy, np.array([0.0, 40.0]), POINTS + 1.0)
    with pytest.warns(UserWarning, match="scenario.yaml: holds another scenario"):
        assert store.find(dut) is None


def test_files_alike_are_flown_once_and_each_flight_has_its_own_scenario(store: FlightStore, tmp_path: Path) -> None:
    scenarios = {name: flying(tmp_path / f"{name}.csv") for name in ("one", "other")}
    flown: list[str | None] = []

    def fly(scenario: Scenario, place: int) -> Flight:
        flown.append(scenario.mission.path_file)
        return flight_of(scenario, place)

    for _ in range(2):
        with ThreadPoolExecutor(1) as workers:
            flights = dict(load_or_fly(scenarios, fly, store, workers))
        assert sorted(flights) == ["one", "other"]
    assert flown == [scenarios["one"].mission.path_file]


def test_a_file_that_changes_before_its_flight_ends_the_study(store: FlightStore, tmp_path: Path) -> None:
    dut = flying(tmp_path / "path.csv")

    def fly(scenario: Scenario, place: int) -> Flight:
        flying(tmp_path / "path.csv", POINTS + 1.0)
        return flight_of(scenario, place)

    with ThreadPoolExecutor(1) as workers, pytest.raises(ScenarioError, match="mine: its path_file or ship_track_file"):
        dict(load_or_fly({"mine": dut}, fly, store, workers))
    assert store.find(dut) is not None  # What was flown is kept, as the flight of what is in the file now.
