"""What the scripts write: two at a time, on a full disk, and where nothing can be written."""

import json
import os
import signal
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from a2s_drake import Flight, FlightEnded, Scenario, run_flight
from a2s_drake.benchmark.growth import HORIZONS, fit_growth
from a2s_drake.benchmark.suite import Benchmark
from a2s_drake.common.files import in_words
from a2s_drake.common.interrupts import ENDING_SIGNALS
from a2s_drake.views.figures import save_figure
from diagrams import build_link_only
from scripts import benchmark, common, compare, flying, missions, reproduce, robustness, show_diagram, simulate
from scripts.examples import channel_map, fed_law, linearise_airframe, one_mpc_step, own_airframe, own_law
from tests.guidance.test_plan_block import SMALL
from tests.scripts.test_command_line import SHORT, reproducing
from tests.support.damage import full_disk
from tests.support.flights import made_up_flight
from tests.support.markdown import ROOT

__all__ = ["reproducing"]

EXAMPLES = [channel_map, fed_law, linearise_airframe, one_mpc_step, own_airframe, own_law]
STUDIES = [simulate, compare, benchmark, missions, robustness, reproduce, *EXAMPLES]

WRITER = """
import sys
from pathlib import Path
from scripts import flying
from tests.scripts.test_results import flight_of
law = sys.argv[2]
print("ready", flush=True)
for _ in sys.stdin:
    flying.write_results(flight_of(law), Path(sys.argv[1]), csv=law == "level")
    print("written", flush=True)
"""


def flight_of(law: str) -> Flight:
    """A flight that can be told from one of another law by every file of it."""
    return made_up_flight(law, snr_db=np.full(5, float(len(law))))


def is_of_one_flight(folder: Path) -> bool:
    flight = Flight.load(folder)
    law = flight.scenario.attitude_law.name
    files = {"scenario.yaml", "flight.npz", "metrics.json"} | ({"flight.csv"} if law == "level" else set())
    return (
        {path.name for path in folder.iterdir()} == files
        and bool((flight.snr_db == len(law)).all())
        and json.loads((folder / "metrics.json").read_text())["law"] == law
    )


def test_two_processes_leave_a_folder_of_one_flight(tmp_path: Path) -> None:
    command, ends = [sys.executable, "-c", WRITER, str(tmp_path)], {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    writers = [subprocess.Popen([*command, law], cwd=ROOT, text=True, **ends) for law in ("level", "pitch_only")]
    try:
        assert {writer.stdout.readline() for writer in writers} == {"ready\n"}
        for _ in range(60):
            for writer in writers:
                writer.stdin.write("now\n")
                writer.stdin.flush()
            assert {writer.stdout.readline() for writer in writers} == {"written\n"}
            assert is_of_one_flight(tmp_path)
    finally:
        for writer in writers:
            writer.kill()
            writer.communicate()


def test_of_an_earlier_flight_all_goes_or_all_stays(tmp_path: Path) -> None:
    flying.write_results(flight_of("level"), tmp_path, csv=True)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with full_disk(2000), pytest.raises(OSError, match=rf"{tmp_path}/.*: File too large; {tmp_path} is as it was$"):
        flying.write_results(flight_of("pitch_only"), tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def end_of(main: Callable[[list[str]], int], arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple:
    """A script's exit code, its error and what else it printed; what it leaves to `common.run` is told as that does."""
    capsys.readouterr()
    try:
        code = main(arguments)
    except OSError as failure:
        printed = capsys.readouterr()
        return 1, f"{printed.err}error: {in_words(failure)}\n", printed.out
    printed = capsys.readouterr()
    return code, printed.err, printed.out


@pytest.mark.parametrize("script", STUDIES, ids=lambda script: script.__name__)
@pytest.mark.parametrize("folder", ["file/below", "n" * 300, "new/" + "n" * 300, "with\0nul", ""])
def test_a_place_that_cannot_be_is_refused_on_one_line(script: ModuleType, folder: str, tmp_path: Path, capsys) -> None:
    (tmp_path / "file").write_text("in the way")
    code, error, printed = end_of(script.main, ["--out", f"{tmp_path / folder}" if folder else ""], capsys)
    assert (code, printed) == (2, "")
    assert "--out" in error
    assert error.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize("name", ["file/below", "n" * 300, "with\0nul", "with\0nul/file", "", "link", "folder"])
def test_a_file_that_cannot_be_is_refused_on_one_line(name: str, tmp_path: Path, capsys) -> None:
    (tmp_path / "file").write_text("in the way")
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to("/dev/null")
    for main, arguments in ((show_diagram.main, ["link_only", "--out"]), (benchmark.main, ["--json"])):
        code, error, printed = end_of(main, [*arguments, f"{tmp_path / name}" if name else ""], capsys)
        assert (code, printed) == (2, "")
        assert arguments[-1] in error
        assert error.count("\n") == 1
    assert (tmp_path / "link").is_symlink()


@pytest.mark.parametrize("script", [simulate, compare, robustness])
def test_a_place_is_looked_at_before_anything_is_planned(script: ModuleType, tmp_path: Path, capsys, monkeypatch):
    monkeypatch.setattr(flying, "kept_plan", lambda *_, **__: pytest.fail("planned"))
    (tmp_path / "file").write_text("in the way")
    assert script.main(["planned", "--set", *SMALL, "--out", str(tmp_path / "file")]) == 2
    assert "cannot be made" in capsys.readouterr().err


@pytest.mark.parametrize("scenario", ["n" * 300, "n" * 300 + ".yaml", "with\0nul", "with\0nul.yaml"])
def test_a_scenario_that_cannot_be_a_file_is_refused_on_one_line(scenario: str, refuses) -> None:
    refuses(simulate, [scenario], "error: ")


def is_one_line(error: str, *parts: str) -> bool:
    return error.startswith("error: ") and error.count("\n") == 1 and all(part in error for part in parts)


def test_simulate_on_a_full_disk(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.setattr(flying, "fly", lambda *_, **__: made_up_flight())
    with full_disk(2000):
        code, error, _ = end_of(simulate.main, ["paper", "--out", str(tmp_path)], capsys)
    assert code == 1
    assert is_one_line(error, f"{tmp_path}/scenario.yaml: File too large; {tmp_path} is as it was")
    assert list(tmp_path.iterdir()) == []


def test_simulate_on_a_disk_that_holds_the_flight_but_not_its_replay(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.setattr(flying, "fly", lambda *_, **__: made_up_flight())
    with full_disk(100_000):
        code, error, _ = end_of(simulate.main, ["paper", "--replay", "--out", str(tmp_path)], capsys)
    assert code == 1
    assert is_one_line(error, f"{tmp_path}/replay.html", f"the flight itself is in {tmp_path}")
    assert len(Flight.load(tmp_path).time) == 5
    assert sorted(path.name for path in tmp_path.iterdir()) == ["flight.npz", "metrics.json", "scenario.yaml"]


def test_simulate_tells_of_an_early_end_on_a_full_disk(tmp_path: Path, capsys, monkeypatch) -> None:
    def end(*_: object, **__: object) -> None:
        raise FlightEnded("it broke", made_up_flight())

    monkeypatch.setattr(flying, "fly", end)
    with full_disk(2000):
        code, error, _ = end_of(simulate.main, ["paper", "--out", str(tmp_path)], capsys)
    assert code == 1
    assert is_one_line(error, "it broke", f"{tmp_path}/scenario.yaml")


@pytest.fixture
def threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Studies are flown in threads of this process, without a controller."""

    def fly(scenario: Scenario, _place: int) -> Flight:
        return run_flight(build_link_only(scenario), scenario)

    monkeypatch.setattr(flying, "fly_quietly", fly)
    monkeypatch.setattr(flying, "fly", fly)
    for module in (flying, compare):
        monkeypatch.setattr(module, "worker_processes", ThreadPoolExecutor)


@pytest.mark.usefixtures("threads")
@pytest.mark.parametrize(("size", "kept"), [(2000, "kept in {}: none"), (15_000, "the flights are in {}")])
def test_compare_on_a_full_disk(size: int, kept: str, tmp_path: Path, capsys) -> None:
    with full_disk(size):
        code, error, printed = end_of(compare.main, ["paper", *SHORT, "--out", str(tmp_path)], capsys)
    assert code == 1
    assert is_one_line(error, "File too large", kept.format(tmp_path))
    assert ("three_axis" in printed) == (size > 2000)
    assert not list(tmp_path.rglob(".part*"))


@pytest.mark.usefixtures("threads")
@pytest.mark.parametrize(("script", "file"), [(robustness, "robustness.md"), (missions, "missions.md")])
@pytest.mark.parametrize("size", [2000, 30_000])
def test_a_study_on_a_full_disk(script, file: str, size: int, tmp_path: Path, capsys, monkeypatch) -> None:
    flight = made_up_flight()
    monkeypatch.setattr(flying, "fly_quietly", lambda scenario, _: replace(flight, scenario=scenario))
    monkeypatch.setattr(flying, "_plan_each", lambda *_: None)
    monkeypatch.setattr(robustness, "robustness_table", lambda *_, **__: size * "table ")
    monkeypatch.setattr(missions, "missions_report", lambda *_: size * "table ")
    monkeypatch.setattr(missions, "outcome", lambda *_: None)
    asked = [*(["radius_1"] if script is missions else []), "--jobs", "1", "--out", str(tmp_path)]
    with full_disk(size):
        code, error, printed = end_of(script.main, asked, capsys)
    assert code == 1
    assert is_one_line(error.splitlines(keepends=True)[-1], "File too large", f"in {tmp_path / 'flights'}")
    assert (f"{tmp_path / file}:" in error) == ("table" in printed) == (size > 2000)
    assert not list(tmp_path.rglob(".part*"))


@pytest.mark.usefixtures("threads")
def test_a_study_tells_of_an_early_end_on_a_full_disk(tmp_path: Path, capsys, monkeypatch) -> None:
    def end(*_: object) -> None:
        raise FlightEnded("it broke", made_up_flight())

    monkeypatch.setattr(flying, "fly_quietly", end)
    with full_disk(2000):
        code, error, _ = end_of(robustness.main, [*SHORT, "--jobs", "1", "--out", str(tmp_path)], capsys)
    assert code == 1
    assert is_one_line(error.splitlines(keepends=True)[-1], "it broke; its samples are lost: ", "flights done are kept")


@pytest.mark.usefixtures("reproducing")
@pytest.mark.parametrize("size", [2000, 25_000])
def test_reproduce_on_a_full_disk(size: int, tmp_path: Path, capsys, monkeypatch) -> None:
    def write_report(_bases: object, _flights: object, folder: Path, _unbounded: object) -> None:
        save_figure(Figure(figsize=(9.0, 9.0)), folder / "figures" / "outage")

    monkeypatch.setattr(reproduce, "write_report", write_report)
    with full_disk(size):
        code, error, _ = end_of(reproduce.main, ["--quick", "--out", str(tmp_path)], capsys)
    assert code == 1
    kept = f"flights done are kept in {tmp_path / 'flights'}"
    assert is_one_line(error.splitlines(keepends=True)[-1], "File too large", kept)
    assert len(list(tmp_path.glob("flights/*/metrics.json"))) == (3 if size > 2000 else 0)
    assert not list(tmp_path.rglob(".part*"))


@pytest.mark.parametrize(("size", "named"), [(2000, "growth.png"), (300_000, "numbers.json")])
def test_benchmark_on_a_full_disk(size: int, named: str, tmp_path: Path, capsys, monkeypatch) -> None:
    growth = fit_growth(HORIZONS, 0.5 + 0.04 * np.array(HORIZONS), np.full(5, 7.0))
    numbers = {"numbers": list(range(100_000))}
    summary = SimpleNamespace(growth={"piqp": growth}, as_json=lambda: numbers)
    monkeypatch.setattr(Benchmark, "run", lambda *_: summary)
    monkeypatch.setattr(benchmark, "benchmark_text", lambda _: "the numbers")
    asked = ["--no-peers", "--json", str(tmp_path / "numbers.json"), "--out", str(tmp_path)]
    with full_disk(size):
        code, error, printed = end_of(benchmark.main, asked, capsys)
    assert code == 1
    assert is_one_line(error, f"{tmp_path / named}:", "File too large")
    assert "the numbers" in printed


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.__name__)
def test_an_example_on_a_full_disk(example: ModuleType, tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.setattr(example, "show", lambda **_: Figure())
    picture = tmp_path / f"{example.__name__.rpartition('.')[2]}.png"
    picture.write_text("of an earlier run")
    with full_disk(500):
        code, error, _ = end_of(example.main, ["--out", str(tmp_path)], capsys)
    assert code == 1
    assert is_one_line(error, f"{picture}:", "File too large")
    assert list(tmp_path.iterdir()) == [picture]
    assert picture.read_text() == "of an earlier run"


LIMITED = """
import sys
from tests.support.damage import full_disk
from scripts import {script}, common
with full_disk(int(sys.argv.pop(1))):
    common.run({script}.main)
"""


@pytest.mark.parametrize(
    ("script", "arguments"), [("show_diagram", ["closed_loop", "--out", "a.txt"]), ("simulate", [*SHORT, "--out", "."])]
)
def test_a_process_on_a_full_disk_ends_with_one_line(script: str, arguments: list[str], tmp_path: Path) -> None:
    command = [sys.executable, "-c", LIMITED.format(script=script), "1000", *arguments]
    environment: dict[str, Any] = os.environ | {"PYTHONPATH": str(ROOT), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False, env=environment
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert is_one_line(done.stderr, "File too large", "a.txt" if script == "show_diagram" else ". is as it was")
    assert not list(tmp_path.rglob(".part*"))


@pytest.fixture
def _process_as_before() -> Iterator[None]:
    """A script that ends changes how its process answers to signals; the tests after it want that undone."""
    answers = {number: signal.getsignal(number) for number in ENDING_SIGNALS}
    hook = sys.unraisablehook
    with warnings.catch_warnings():
        yield
    sys.unraisablehook = hook
    for number, answer in answers.items():
        signal.signal(number, answer)


@pytest.mark.usefixtures("_process_as_before")
def test_run_ends_an_unhandled_error_of_the_disk_with_one_line(capsys) -> None:
    def main() -> int:
        raise OSError(28, "No space left on device", "results/flight.npz")

    with pytest.raises(SystemExit) as ended:
        common.run(main)
    assert ended.value.code == 1
    assert capsys.readouterr().err == "error: results/flight.npz: No space left on device\n"
