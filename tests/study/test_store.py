import dataclasses
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Flight, Scenario
from a2s_drake.study.store import FlightStore, code_digest, load_or_fly
from tests.support.flights import SAMPLES, made_up_flight

SCENARIO = Scenario().with_value("simulation.duration", 0.08)


def flight_of(scenario: Scenario) -> Flight:
    return dataclasses.replace(made_up_flight(), scenario=scenario)


@pytest.fixture
def store(tmp_path: Path) -> FlightStore:
    return FlightStore(tmp_path / "flights", "code")


class Flying:
    """Flies at once, and remembers what it flew."""

    def __init__(self) -> None:
        self.flown: list[Scenario] = []

    def __call__(self, scenario: Scenario, _place: int) -> Flight:
        self.flown.append(scenario)
        return flight_of(scenario)


def fly_all(scenarios: dict[str, Scenario], store: FlightStore, fly: Flying) -> dict[str, Flight]:
    with ThreadPoolExecutor(2) as workers:
        return dict(load_or_fly(scenarios, fly, store, workers))


def test_a_kept_flight_is_found_as_it_was(store: FlightStore) -> None:
    assert store.find(SCENARIO) is None
    store.save(flight_of(SCENARIO))
    found = store.find(SCENARIO)
    assert found is not None
    assert found.scenario == SCENARIO
    np.testing.assert_array_equal(found.snr_db, flight_of(SCENARIO).snr_db)


def test_a_flight_depends_on_scenario_and_code(store: FlightStore, tmp_path: Path) -> None:
    store.save(flight_of(SCENARIO))
    assert store.find(SCENARIO.with_value("mission.radius", 2.6)) is None
    assert FlightStore(tmp_path / "flights", "other code").find(SCENARIO) is None
    assert FlightStore(tmp_path / "flights", "code").find(SCENARIO) is not None


def test_nothing_is_flown_twice(store: FlightStore) -> None:
    other = SCENARIO.with_value("mission.radius", 2.0)
    first, second = Flying(), Flying()
    flights = fly_all({"a": SCENARIO, "b": other, "also a": SCENARIO}, store, first)
    assert sorted(flights) == ["a", "also a", "b"]
    assert len(first.flown) == 2
    assert sorted(fly_all({"a": SCENARIO, "c": other}, store, second)) == ["a", "c"]
    assert second.flown == []


@pytest.mark.parametrize(
    ("damage", "named"),
    [
        ("truncate", "flight.npz"),
        ("garbage", "flight.npz"),
        ("nan", "flight.npz"),
        ("swap", "scenario.yaml"),
        ("yaml", "scenario.yaml"),
    ],
)
def test_a_damaged_flight_is_flown_again_with_a_warning_that_names_the_file(damage, named, store: FlightStore) -> None:
    store.save(flight_of(SCENARIO))
    place = store.place(SCENARIO)
    file = place / "flight.npz"
    if damage == "truncate":
        file.write_bytes(file.read_bytes()[:200])
    elif damage == "garbage":
        file.write_bytes(b"garbage")
    elif damage == "nan":
        dataclasses.replace(flight_of(SCENARIO), snr_db=np.full(SAMPLES, np.nan)).save(place)
    elif damage == "swap":
        flight_of(SCENARIO.with_value("mission.radius", 2.0)).save(place)
    else:
        (place / "scenario.yaml").write_text("[")
    fly = Flying()
    with pytest.warns(UserWarning, match=rf"a kept flight is damaged and is flown again: .*{place / named}"):
        flights = fly_all({"a": SCENARIO}, store, fly)
    assert len(fly.flown) == 1
    assert len(flights["a"].time) == SAMPLES
    assert store.find(SCENARIO) is not None


def test_a_flight_interrupted_while_it_was_kept_is_flown_without_a_warning(store: FlightStore) -> None:
    store.save(flight_of(SCENARIO))
    (store.place(SCENARIO) / "flight.npz").unlink()
    fly = Flying()
    fly_all({"a": SCENARIO}, store, fly)
    assert len(fly.flown) == 1


def test_an_interrupt_leaves_the_flights_done_whole(store: FlightStore) -> None:
    scenarios = {str(radius): SCENARIO.with_value("mission.radius", radius) for radius in (2.0, 2.1, 2.2)}

    def interrupted(scenario: Scenario, place: int) -> Flight:
        if place == 1:
            raise KeyboardInterrupt
        return flight_of(scenario)

    with ThreadPoolExecutor(1) as workers, pytest.raises(KeyboardInterrupt):
        dict(load_or_fly(scenarios, interrupted, store, workers))
    fly = Flying()
    assert sorted(fly_all(scenarios, store, fly)) == ["2.0", "2.1", "2.2"]
    assert len(fly.flown) == 2


def test_code_digest_follows_what_flies_and_nothing_else(tmp_path: Path) -> None:
    for room in ("link", "views"):
        (tmp_path / room).mkdir()
    sources = [tmp_path / name for name in ("diagrams.py", "link/two_ray.py", "views/style.py", "__init__.py")]
    for source in sources:
        source.write_text("a = 1\n")
    before = code_digest(tmp_path)
    for source, flies in zip(sources, (True, True, False, False), strict=True):
        source.write_text("a = 2\n")
        assert (code_digest(tmp_path) != before) == flies
        source.write_text("a = 1\n")
    assert code_digest(tmp_path) == before
