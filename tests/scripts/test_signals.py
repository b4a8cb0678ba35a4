"""What asks a script to end: Ctrl-C, `kill`, and a terminal that closes."""

import ast
import os
import re
import signal
import subprocess
import time
from pathlib import Path
from select import PIPE_BUF

import pytest

from a2s_drake import Flight
from tests.support.processes import catches, end_of, needs_proc, start, start_program, unread, wait_until

SCRIPTS = sorted(
    path
    for folder in ("scripts", "scripts/examples")
    for path in Path(folder).glob("*.py")
    if "def main(" in path.read_text()
)
CODES = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}
INTERRUPTED = "error: interrupted\n"

FLIES = """
from scripts import flying, simulate
fly = flying.fly
flying.fly = lambda scenario, observer, plan: fly(scenario, observer=lambda _: ready.touch(), plan=plan)
main = lambda: simulate.main(["hover", "--duration", "600", "--out", "out"])
"""

PLANS = """
from a2s_drake.guidance.plan.plan import plan_attitude
from diagrams import load_scenario
small = ["mission.duration=3.0", "mission.radius=0.05"]
scenario = load_scenario("planned").with_overrides(small)
def main():
    while True:
        plan_attitude(scenario, lambda progress: progress.phase == "PHASE" and ready.touch())
"""

WRITES = """
from a2s_drake.flight import folder as results
from scripts import simulate
write = results.write_metrics
def write_slowly(flight, folder):
    ready.touch()
    end = time.monotonic() + 0.5
    while time.monotonic() < end:
        pass
    write(flight, folder)
results.write_metrics = write_slowly
main = lambda: simulate.main(["hover", "--duration", "0.1", "--csv", "--out", "out"])
"""

ENDS_SLOWLY = """
def main():
    try:
        ready.touch()
        time.sleep(60.0)
    except KeyboardInterrupt:
        Path("ending").touch()
        time.sleep(SECONDS)
        done.touch()
        return 130
"""

LOSES = """
class Held:
    def __del__(self):
        ready.touch()
        time.sleep(60.0)
def main():
    held = Held()
    del held
    done.touch()
    time.sleep(60.0)
"""

CONVERTS = """
def main():
    try:
        ready.touch()
        time.sleep(60.0)
    except KeyboardInterrupt:
        raise RuntimeError("what a library makes of it")
"""

IGNORES = """
def main():
    ready.touch()
    while not Path("go").exists():
        time.sleep(0.01)
    return 0
"""

FAILS = """
def main():
    ready.touch()
    raise ZeroDivisionError("a bug")
"""


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_every_script_listens_before_it_imports_anything_else(script: Path) -> None:
    _, first, *_ = ast.parse(script.read_text()).body
    assert ast.unparse(first) == "if __name__ == '__main__':\n    import scripts.startup"


@needs_proc
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=lambda number: number.name)
@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_a_signal_during_the_imports_ends_in_one_line(script: Path, number: signal.Signals) -> None:
    process = start([str(script)])
    # Python alone does not catch SIGTERM: from here on the script listens, and imports for another half a second.
    wait_until(lambda: catches(process, signal.SIGTERM))
    process.send_signal(number)
    assert end_of(process) == (CODES[number], INTERRUPTED)


@needs_proc
@pytest.mark.slow
@pytest.mark.parametrize("number", CODES, ids=lambda number: number.name)
@pytest.mark.parametrize("delay", [0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 2.0])
def test_no_instant_is_bad_for_a_signal(delay: float, number: signal.Signals, tmp_path: Path) -> None:
    process = start(["scripts/simulate.py", "--duration", "1", "--out", str(tmp_path)])
    wait_until(lambda: catches(process, signal.SIGTERM))
    time.sleep(delay)
    process.send_signal(number)
    code, err = end_of(process)
    assert code in (0, CODES[number])
    assert err == "" if code == 0 else err.startswith("error: interrupted") and err.count("\n") == 1


@pytest.mark.parametrize("number", CODES, ids=lambda number: number.name)
def test_a_signal_in_flight_keeps_the_samples(number: signal.Signals, tmp_path: Path) -> None:
    process = start_program(FLIES, tmp_path)
    process.send_signal(number)
    code, err = end_of(process)
    assert code == CODES[number]
    samples = len(Flight.load(tmp_path / "out").time)
    assert re.fullmatch(rf"error: interrupted at t = \d+\.\d\d s; its {samples} samples are in out\n", err)


@pytest.mark.parametrize("phase", ["search", "sqp", "ipopt"])
def test_a_signal_ends_planning(phase: str, tmp_path: Path) -> None:
    process = start_program(PLANS.replace("PHASE", phase), tmp_path)
    process.send_signal(signal.SIGTERM)
    assert end_of(process) == (143, INTERRUPTED)


def test_what_is_being_written_is_written_to_its_end(tmp_path: Path) -> None:
    process = start_program(WRITES, tmp_path)
    process.send_signal(signal.SIGTERM)
    assert end_of(process) == (143, INTERRUPTED)
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert written == {"scenario.yaml", "flight.npz", "metrics.json", "flight.csv"}


def test_a_second_signal_of_the_same_request_changes_nothing(tmp_path: Path) -> None:
    process = start_program(ENDS_SLOWLY.replace("SECONDS", "0.5"), tmp_path)
    process.send_signal(signal.SIGTERM)
    wait_until((tmp_path / "ending").exists)
    process.send_signal(signal.SIGINT)
    assert end_of(process) == (143, "")
    assert (tmp_path / "done").exists()


def test_a_later_signal_ends_a_script_that_does_not_end(tmp_path: Path) -> None:
    process = start_program(ENDS_SLOWLY.replace("SECONDS", "120.0"), tmp_path)
    process.send_signal(signal.SIGINT)
    wait_until((tmp_path / "ending").exists)
    end = time.monotonic() + 60.0
    while process.poll() is None and time.monotonic() < end:
        time.sleep(1.2)
        process.send_signal(signal.SIGTERM)
    assert end_of(process) == (130, INTERRUPTED)
    assert not (tmp_path / "done").exists()


@pytest.mark.parametrize("program", [LOSES, CONVERTS], ids=["dropped in a finaliser", "made another error"])
def test_an_interrupt_that_python_or_a_library_loses_still_ends_the_script(program: str, tmp_path: Path) -> None:
    process = start_program(program, tmp_path)
    process.send_signal(signal.SIGTERM)
    assert end_of(process) == (143, INTERRUPTED)


def test_an_error_without_a_signal_stays_an_error(tmp_path: Path) -> None:
    code, err = end_of(start_program(FAILS, tmp_path))
    assert code == 1
    assert err.endswith("ZeroDivisionError: a bug\n")


def test_signals_that_the_caller_ignores_stay_ignored(tmp_path: Path) -> None:
    before = {number: signal.signal(number, signal.SIG_IGN) for number in CODES}
    try:
        process = start_program(IGNORES, tmp_path)
    finally:
        for number, answer in before.items():
            signal.signal(number, answer)
    for number in CODES:
        process.send_signal(number)
    (tmp_path / "go").touch()
    assert end_of(process) == (0, "")


def moves(process: subprocess.Popen[str]) -> bool:
    before = unread(process)
    time.sleep(0.2)
    return unread(process) != before


def test_an_interrupt_drops_what_nobody_reads(tmp_path: Path) -> None:
    # The reader of a full pipe does nothing: to wait for it would be to wait for ever.
    text = "def main():\n    ready.touch()\n    while True:\n        print('nobody reads this', flush=True)\n"
    process = start_program(text, tmp_path)
    wait_until(lambda: unread(process) > PIPE_BUF and not moves(process))
    process.send_signal(signal.SIGINT)
    process.wait(timeout=60.0)
    assert end_of(process) == (130, INTERRUPTED)


def test_show_diagram_ends_with_the_child_that_draws(tmp_path: Path) -> None:
    # A program `dot` that never ends, found first.
    dot, picture = tmp_path / "dot", tmp_path / "out.svg"
    dot.write_text(f"#!/bin/sh\ntouch {tmp_path}/ready\nexec sleep 60\n")
    dot.chmod(0o755)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
        process = start(["scripts/show_diagram.py", "closed_loop", "--format", "svg", "--out", str(picture)])
    wait_until((tmp_path / "ready").exists)
    process.send_signal(signal.SIGTERM)
    assert end_of(process) == (143, INTERRUPTED)
    assert not picture.exists()
