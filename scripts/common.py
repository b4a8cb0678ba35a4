"""What the scripts share: their command line, and how they end."""

import argparse
import contextlib
import os
import sys
import threading
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NoReturn

from a2s_drake import Scenario, ScenarioError
from a2s_drake.common import files
from a2s_drake.common.files import what_is_kept as what_is_kept
from a2s_drake.common.quoting import MESSAGE_LENGTH, one_line
from a2s_drake.flight import feasible
from a2s_drake.scenario.parts import LAW_NAMES
from a2s_drake.scenario.scenario import parse_override
from a2s_drake.views.replay import Scene, start_meshcat
from diagrams import SUFFIXES, load_scenario
from scripts import ending, streams


class UsageError(Exception):
    """Input that cannot be worked with; a script prints its one line and returns 2."""

    def __init__(self, message: object) -> None:
        super().__init__(one_line(str(message), MESSAGE_LENGTH))


class Parser(argparse.ArgumentParser):
    """An argument parser that raises UsageError where others print and exit."""

    def error(self, message: str) -> NoReturn:
        """Raises UsageError."""
        raise UsageError(message)


def run(main: Callable[[], int]) -> NoReturn:
    """Ends the process with a script's exit code.

    The code is 130 after Ctrl-C and 143 after SIGTERM, whether or not the script handles them itself. It is 1 where the
    work is done but what the script prints cannot be written, unless only the reader has left.
    """
    show_warnings()
    interruption = ending.Interruption()
    try:
        interruption.begin()
        code = _outcome(main)
        interruption.end()
    except BaseException as error:
        if interruption or isinstance(error, KeyboardInterrupt):
            reason, code = "interrupted", 130  # Other errors are what a library made of the interrupt.
        elif isinstance(error, OSError):
            reason, code = files.in_words(error), 1  # a full or failing disk, in what a script does not handle itself
        else:
            raise
        print(f"error: {reason}", file=sys.stderr)
        streams.drop_unread_output()
        sys.stdout.flush()
    code = interruption.code(code)
    if code and _are_stuck(thread for thread in threading.enumerate() if not thread.daemon):
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    interruption.end()
    sys.exit(code)


def _outcome(main: Callable[[], int]) -> int:
    """A script's exit code when all that it prints is written."""
    try:
        code = main()
    except SystemExit as shown:  # --help
        if shown.code != 0:
            raise
        code = 0
    sys.stdout.flush()
    if streams.losses and not code:
        print(f"error: standard output: {streams.losses[0]}", file=sys.stderr)
        return 1
    return code


def show_warnings() -> None:
    """Has each warning shown on one line of its own, without the code that it comes from."""

    def show(message: Warning | str, *_: object) -> None:
        # A worker process must fly on where nobody reads its warnings any more.
        with contextlib.suppress(OSError):
            print(f"warning: {message}", file=sys.stderr, flush=True)

    warnings.showwarning = show
    warnings.simplefilter("always", UserWarning)


def _are_stuck(threads: Iterable[threading.Thread]) -> bool:
    """Whether other threads do not end. A thread that reads from a terminated worker may wait for ever."""
    others = [thread for thread in threads if thread is not threading.current_thread()]
    for thread in others:
        thread.join(2.0)
    return any(thread.is_alive() for thread in others)


def add_scenario_arguments(parser: argparse.ArgumentParser, default: str, out: str = "results/SCENARIO") -> None:
    """Adds `[SCENARIO] [--set section.field=value ...] [--duration S] [--out DIR]`."""
    help_text = "a name in diagrams/scenarios.yaml or a YAML file (default: %(default)s)"
    parser.add_argument("scenario", nargs="?", default=default, metavar="SCENARIO", help=help_text)
    add_set_argument(parser)
    parser.add_argument("--duration", type=float, metavar="S", help="length of the flight, s (default: the mission's)")
    add_out_argument(parser, out)


def add_set_argument(parser: argparse.ArgumentParser) -> None:
    """Adds `[--set section.field=value ...]`."""
    help_text = "change fields of the scenario, e.g. --set mpc.horizon=20 mission.radius=2"
    parser.add_argument("--set", nargs="+", action="extend", default=[], metavar="a.b=value", help=help_text)


def add_out_argument(parser: argparse.ArgumentParser, default: str) -> None:
    """Adds `[--out DIR]`."""
    parser.add_argument("--out", type=place, metavar="DIR", help=f"where to write (default: {default})")


def add_jobs_argument(parser: argparse.ArgumentParser) -> None:
    """Adds `[--jobs N]`."""
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="flights at a time (default: %(default)s)")


def add_law_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds `[--law NAME] [--plan-within S]`."""
    help_text = "the attitude law; wins over --set attitude_law.name=..."
    parser.add_argument("--law", choices=LAW_NAMES, help=help_text)
    help_text = "settle for the best plan found within S seconds (under the law planned)"
    parser.add_argument("--plan-within", type=float, metavar="S", help=help_text)


def place(text: str) -> Path:
    """The type of an argument that names a folder or a file."""
    if not text or "\0" in text:
        raise argparse.ArgumentTypeError(f"{text!r} must name a folder or a file")
    return Path(text)


def resolve_scenario(arguments: argparse.Namespace, overrides: list[str]) -> Scenario:
    """The scenario that the command line names, overridden in order and validated.

    Raises:
      UsageError: when there is none, or it cannot be flown.
    """
    try:
        scenario = load_scenario(arguments.scenario).with_overrides([*arguments.set, *overrides])
        if arguments.duration is not None:
            scenario = scenario.with_value("simulation.duration", arguments.duration)
        return feasible.check(scenario)
    except ScenarioError as error:
        raise UsageError(error) from error


def refuse_law(arguments: argparse.Namespace) -> None:
    """Raises UsageError where `--set` names a law for a script that flies several."""
    if "attitude_law.name" in _fields_set(arguments):
        raise UsageError("--set attitude_law.name: this script chooses the laws; scripts/simulate.py flies one")


def refuse_disturbance(arguments: argparse.Namespace) -> None:
    """Raises UsageError where `--set` disturbs a script that flies disturbances of its own."""
    if any(name.startswith("disturbance.") for name in _fields_set(arguments)):
        raise UsageError("--set disturbance: this script chooses the disturbances; scripts/simulate.py flies one's own")


def _fields_set(arguments: argparse.Namespace) -> list[str]:
    """The names of the fields that `--set` changes."""
    try:
        return [parse_override(text)[0] for text in arguments.set]
    except ScenarioError as error:
        raise UsageError(error) from error


def default_folder(arguments: argparse.Namespace) -> Path:
    """Where results go unless `--out` says otherwise: results/<scenario>; a kept scenario.yaml goes by its folder.

    The folder always lies in results, whatever the scenario is called.
    """
    path = Path(arguments.scenario)
    name = path.stem if path.suffix in SUFFIXES else path.name
    if path.name in ("scenario.yaml", "scenario.yml"):
        # The path may go upwards, so only its full form says what the folder is called.
        name = path.parent.resolve().name
    shown = "".join(c if c.isprintable() and c not in r"\/:" else "_" for c in name).strip(" .")
    return Path("results") / (shown or "scenario")


def check_folder(folder: Path) -> None:
    """Raises UsageError unless a folder for results can be made and written to. Makes nothing."""
    try:
        files.check_folder(folder)
    except OSError as error:
        raise UsageError(f"--out {folder}: cannot be made or written to: {error.strerror}") from error


def make_folder(folder: Path) -> None:
    """Makes a folder for results before anything is computed.

    Raises:
      UsageError: when it cannot be made or written to.
    """
    check_folder(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"--out {folder}: cannot be made: {error.strerror}") from error


def make_study_folder(out: Path | None, default: str, *parts: str) -> Path:
    """Makes the folder of a study, `--out` or its default, with one for its flights and those of other parts.

    Raises:
      UsageError: as `make_folder`.
    """
    folder = out or Path(default)
    for made in (folder, folder / "flights", *(folder / part for part in parts)):
        make_folder(made)
    return folder


def check_file(path: Path, option: str) -> None:
    """Makes the folder of a file; raises UsageError, which names the option, unless it can be written there."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"{option} {path}: its folder cannot be made: {error.strerror}") from error
    try:
        files.check_writable(path)
    except OSError as error:
        raise UsageError(f"{option} {path}: cannot be written: {error.strerror}") from error


def check_jobs(jobs: int) -> None:
    """Raises UsageError unless there is at least one flight at a time."""
    check_count(jobs, "--jobs")


def check_count(count: int, option: str) -> None:
    """Raises UsageError, which names the option, unless it is at least 1."""
    if count < 1:
        raise UsageError(f"{option} {count}: must be at least 1")


def add_replay_argument(parser: argparse.ArgumentParser, shown: str) -> None:
    """Adds `[--replay]`."""
    parser.add_argument("--replay", action="store_true", help=f"also write replay.html, which shows {shown} in motion")


def open_live_view(scenario: Scenario) -> Scene:
    """A live view of a scenario's flight, whose address is printed.

    Raises:
      UsageError: when it cannot be served.
    """
    try:
        meshcat = start_meshcat()
    except OSError as error:
        raise UsageError(f"--meshcat: {error}") from error
    scene = Scene(meshcat, scenario)
    print(f"live view: {meshcat.web_url()}", flush=True)
    return scene


def serve_until_enter() -> None:
    """Waits for Enter or Ctrl-C where a person sits at the terminal, so that a live view stays open."""
    if sys.stdin is not None and sys.stdin.isatty():
        print("the live view stays open until you press Enter", flush=True)
        with contextlib.suppress(KeyboardInterrupt, EOFError):
            input()
