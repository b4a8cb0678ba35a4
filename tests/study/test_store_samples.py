"""A kept flight has a row for every sample of its scenario, in every array; else it is damaged and flown again."""

import dataclasses
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Flight, Scenario
from a2s_drake.flight.log import array_names
from a2s_drake.study.store import FlightStore, load_or_fly
from tests.support.flights import SAMPLES, made_up_flight

SCENARIO = Scenario().with_value("simulation.duration", 0.08)


def flight_of(scenario: Scenario) -> Flight:
    return dataclasses.replace(made_up_flight(), scenario=scenario)


def kept_with_rows(names: list[str], rows: int, folder: Path) -> FlightStore:
    """A store whose one flight has another number of rows in some arrays."""
    store, flight = FlightStore(folder, "code"), flight_of(SCENARIO)
    changed = {name: np.resize(values := getattr(flight, name), (rows, *values.shape[1:])) for name in names}
    dataclasses.replace(flight, **changed).save(store.place(SCENARIO))
    return store


@pytest.mark.parametrize("rows", [0, SAMPLES - 1, SAMPLES + 1])
@pytest.mark.parametrize("names", [array_names(), ["time"], ["rotor_speed"], ["solver_fallback"]])
def test_a_sample_too_few_or_too_many_is_damage(names: list[str], rows: int, tmp_path: Path) -> None:
    store = kept_with_rows(names, rows, tmp_path)
    with pytest.warns(UserWarning, match=r"flight\.npz: .* (finite rows|of shape|start at 0)"):
        assert store.find(SCENARIO) is None


def test_all_its_samples_are_no_damage(tmp_path: Path) -> None:
    assert kept_with_rows(array_names(), SAMPLES, tmp_path).find(SCENARIO) is not None


def test_a_flight_with_a_sample_too_few_is_flown_again_and_kept(tmp_path: Path) -> None:
    store, flown = kept_with_rows(array_names(), SAMPLES - 1, tmp_path), []

    def fly(scenario: Scenario, _place: int) -> Flight:
        flown.append(scenario)
        return flight_of(scenario)

    with ThreadPoolExecutor(1) as workers, pytest.warns(UserWarning, match="is damaged and is flown again"):
        flights = dict(load_or_fly({"a": SCENARIO}, fly, store, workers))
    assert flown == [SCENARIO]
    assert len(flights["a"].time) == SAMPLES
    assert len(store.find(SCENARIO).time) == SAMPLES


def test_a_flight_depends_on_the_libraries_that_flew_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def place(newer: str = "") -> Path:
        monkeypatch.setattr("a2s_drake.study.store.version", lambda name: "2" if name == newer else "1")
        return FlightStore(tmp_path, "code").place(SCENARIO)

    assert place() == place()
    assert len({place(newer) for newer in ("", "drake", "numpy", "piqp", "scipy")}) == 5
