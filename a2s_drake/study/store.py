"""Store: flights kept on disk, so that none is flown twice and an interrupted campaign goes on where it was."""

import hashlib
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import numpy as np

from a2s_drake.common.packages import is_installed
from a2s_drake.flight.log import Flight, array_names, optional_names
from a2s_drake.flight.metrics import write_metrics
from a2s_drake.scenario.checks import ScenarioError
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.scenario.track_file import by_content
from a2s_drake.study.pool import fly_each

# Rooms that look at flights or decide which to fly; no number in a flight depends on them.
_NO_PART_OF_A_FLIGHT = {"study", "views", "benchmark", "__init__.py"}


def code_digest(*packages: Path) -> str:
    """A digest of the Python sources below some folders, except those that change no number of a flight.

    A flight belongs to the code that flew it: with other code it is flown again.
    """
    digest = hashlib.sha256()
    for package in packages:
        for source in sorted(package.rglob("*.py")):
            name = source.relative_to(package)
            if name.parts[0] not in _NO_PART_OF_A_FLIGHT:
                digest.update(name.as_posix().encode() + b"\0" + source.read_bytes() + b"\0")
    return digest.hexdigest()


class FlightStore:
    """A folder of flights, each in a folder of its own named by all it depends on: scenario, code and libraries."""

    def __init__(self, folder: Path, code: str) -> None:
        """Opens the store in a folder, which is made where it is missing.

        Args:
          code: a digest of the code that flies; flights of other code are not found.
        """
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = folder
        libraries = {"drake": "pydrake", "numpy": "numpy", "piqp": "piqp", "scipy": "scipy"}
        versions = [f"{name} {version(name)}" for name, module in libraries.items() if is_installed(module)]
        self._maker = " ".join([code, *versions])

    def place(self, scenario: Scenario, files: Mapping[str, bytes] | None = None) -> Path:
        """Where a scenario's flight is or will be kept. It depends on what track files hold, not on their names.

        Args:
          files: the content of the scenario's track files, see `Flight.files`; without it they are read now.
        Raises:
          ScenarioError: when a track file cannot be read.
        """
        content = f"{by_content(scenario, files or {}).to_yaml()}\n{self._maker}"
        return self._folder / hashlib.sha256(content.encode()).hexdigest()[:16]

    def holds(self, scenario: Scenario) -> bool:
        """Whether there is a flight of a scenario, whole or damaged."""
        # The log is the last file that an interrupt could have kept from being written.
        return (self.place(scenario) / "flight.npz").exists()

    def find(self, scenario: Scenario) -> Flight | None:
        """The kept flight of a scenario. None where there is none, or, with a warning, where it is damaged."""
        place = self.place(scenario)
        if not self.holds(scenario):
            return None
        try:
            flight = Flight.load(place)
            _check(flight, scenario, place)
        except (OSError, ValueError) as error:
            warnings.warn(f"a kept flight is damaged and is flown again: {' '.join(str(error).split())}", stacklevel=2)
            return None
        return replace(flight, scenario=scenario)  # which names the same track files in their own places

    def save(self, flight: Flight) -> None:
        """Saves a flight; an interrupt leaves each file old or new, never half written."""
        place = self.place(flight.scenario, flight.files)
        flight.save(place)
        write_metrics(flight, place)


def _check(flight: Flight, scenario: Scenario, place: Path) -> None:
    """Raises ValueError, which names the file, unless a flight is that of a scenario, whole and finite."""
    if by_content(flight.scenario, flight.files) != by_content(scenario, {}):
        raise ValueError(f"{place / 'scenario.yaml'}: holds another scenario")
    if not flight.rebuilds_from_scenario:
        raise ValueError(f"{place / 'flight.npz'}: was flown with blocks that the scenario does not name")
    samples = len(scenario.sample_times())
    for name in array_names():
        values = getattr(flight, name)
        # An array that a diagram need not export may be NaN, but must have every row.
        if len(values) != samples or not (name in optional_names() or np.isfinite(values).all()):
            raise ValueError(f"{place / 'flight.npz'}: {name} is not {samples} finite rows")


def load_or_fly(
    scenarios: Mapping[str, Scenario],
    fly: Callable[[Scenario, int], Flight],
    store: FlightStore,
    executor: Executor,
) -> Iterator[tuple[str, Flight]]:
    """Flights by name: first those kept, then the others as they are done and kept. See `pool.fly_each`.

    Equal scenarios under several names are flown once.

    Raises:
      ScenarioError: when a track file cannot be read, or changed between the start and its flight.
    """
    names: dict[Path, list[str]] = {}
    for name, scenario in scenarios.items():
        names.setdefault(store.place(scenario), []).append(name)
    missing: dict[str, Scenario] = {}
    for place, (first, *_) in names.items():
        kept = store.find(scenarios[first])
        if kept is None:
            missing[first] = scenarios[first]
            continue
        for name in names[place]:
            yield name, kept
    places = {first: place for place, (first, *_) in names.items()}
    for first, flight in fly_each(missing, fly, executor):
        store.save(flight)
        if store.place(flight.scenario, flight.files) != places[first]:
            raise ScenarioError(f"{first}: its path_file or ship_track_file changed before it was flown; start again")
        for name in names[places[first]]:
            yield name, flight
