"""What the scripts share: naming a scenario on the command line, flying it, writing its results."""

import argparse
import os
from pathlib import Path

from tqdm import tqdm

from a2s_drake import Flight, Scenario, ScenarioError, run_flight
from a2s_drake.metrics import write_metrics
from diagrams import build_closed_loop, load_scenario


class UsageError(Exception):
    """Input that cannot be worked with; a script prints its one line and returns 2."""


def add_scenario_arguments(parser: argparse.ArgumentParser, default: str) -> None:
    """Adds `[SCENARIO] [--set section.field=value ...] [--duration S]`."""
    help_text = "a name in diagrams/scenarios.yaml or a YAML file (default: %(default)s)"
    parser.add_argument("scenario", nargs="?", default=default, metavar="SCENARIO", help=help_text)
    help_text = "change fields of the scenario, e.g. --set mpc.horizon=20 link.carrier_hz=5.8e9"
    parser.add_argument("--set", nargs="+", action="extend", default=[], metavar="a.b=value", help=help_text)
    parser.add_argument("--duration", metavar="S", help="length of the flight, s (default: the mission's)")


def resolve_scenario(arguments: argparse.Namespace, overrides: list[str]) -> Scenario:
    """The scenario that the command line names, overridden in order and validated.

    Raises:
      UsageError: when there is none, or it cannot be flown.
    """
    if arguments.duration is not None:
        overrides = [*overrides, f"simulation.duration={arguments.duration}"]
    try:
        return load_scenario(arguments.scenario).with_overrides([*arguments.set, *overrides]).validate()
    except (ScenarioError, OSError, UnicodeDecodeError) as error:
        raise UsageError(error) from error


def default_folder(arguments: argparse.Namespace) -> Path:
    """Where results go unless `--out` says otherwise: results/<scenario>."""
    return Path("results") / Path(arguments.scenario).stem


def make_folder(folder: Path) -> None:
    """Makes a folder for results before anything is computed.

    Raises:
      UsageError: when it cannot be made or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"--out {folder}: cannot be made: {error.strerror}") from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise UsageError(f"--out {folder}: cannot be written to")


def fly(scenario: Scenario, row: int = 0) -> Flight:
    """Flies a validated scenario in closed loop, with a progress bar in the given row of the terminal."""
    label = scenario.attitude_law.name
    with tqdm(total=len(scenario.sample_times()), desc=label, position=row, leave=False, disable=None) as bar:
        return run_flight(build_closed_loop(scenario), scenario, bar.update)


def write_results(flight: Flight, folder: Path) -> None:
    """Writes scenario.yaml, flight.npz and, where there is a sample to measure, metrics.json."""
    flight.save(folder)
    if len(flight.time):
        write_metrics(flight, folder)
