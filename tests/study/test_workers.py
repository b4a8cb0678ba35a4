"""Worker processes: they end with the process that started them, and an interrupt is not lost while they start."""

import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

import pytest

from a2s_drake import Scenario
from a2s_drake.common.interrupts import ENDING_SIGNALS, ONE_REQUEST, interrupts_put_off
from a2s_drake.study.pool import fly_each, worker_processes
from tests.support.processes import children, end_of, is_there, needs_proc, start, start_program, wait_until

# Two workers fly for an hour; a third is done at once and waits. Each tells of itself with its first sample.
CAMPAIGN = """
import os
from a2s_drake import Scenario, run_flight
from a2s_drake.study.pool import fly_each, worker_processes
from diagrams import build_link_only

def fly(scenario, place):
    told = lambda _: Path(f"flying-{place}").touch()
    return run_flight(build_link_only(scenario), scenario, observer=told)

def main():
    ready.touch()
    endless = Scenario().with_overrides(["simulation.duration=3600", "mission.duration=3600"])
    short = endless.with_value("simulation.duration", 0.1)
    with worker_processes(3) as workers:
        list(fly_each({"first": endless, "second": endless, "third": short}, fly, workers))
"""

ENDS_WELL = """
from a2s_drake import Scenario
from a2s_drake.study.pool import fly_each, worker_processes

def law(scenario, place):
    return scenario.attitude_law.name

def main():
    with worker_processes(2) as workers:
        assert dict(fly_each({"a": Scenario()}, law, workers)) == {"a": "three_axis"}
    return 0
"""


@needs_proc
@pytest.mark.parametrize(
    ("number", "group"), [("SIGKILL", False), ("SIGTERM", False), ("SIGTERM", True), ("SIGHUP", True)]
)
def test_workers_end_with_their_parent(number: str, group: bool, tmp_path: Path) -> None:
    process = start_program(CAMPAIGN, tmp_path)
    wait_until(lambda: all((tmp_path / f"flying-{place}").exists() for place in range(3)))
    started = children(process.pid)
    assert len(started) == 4  # the workers, and Python's own process that cleans up locks
    if group:
        os.killpg(process.pid, signal.Signals[number])
    else:
        process.send_signal(signal.Signals[number])
    wait_until(lambda: not any(map(is_there, started)), seconds=10.0)
    code, err = end_of(process)
    if number != "SIGKILL":
        assert (code, err) == (128 + signal.Signals[number], "error: interrupted\n")


def test_a_campaign_that_ends_says_nothing(tmp_path: Path) -> None:
    process = start_program(ENDS_WELL, tmp_path)
    assert end_of(process) == (0, "")


@needs_proc
def test_a_worker_that_is_killed_ends_the_comparison_in_one_line(tmp_path: Path) -> None:
    # As a machine that runs out of memory does.
    process = start(["scripts/compare.py", "hover", "--duration", "600", "--out", str(tmp_path)])
    wait_until(lambda: len(workers_of(process.pid)) == 2 or process.poll() is not None)
    os.kill(workers_of(process.pid)[0], signal.SIGKILL)
    code, err = end_of(process)
    assert code == 1
    assert re.fullmatch(rf"error: .* process pool .*; flown to the end and kept in {tmp_path}: none\n", err)


def workers_of(pid: int) -> list[int]:
    """Those children of a process that are workers, so not Python's own process that cleans up locks."""
    return [child for child in children(pid) if "spawn_main" in Path(f"/proc/{child}/cmdline").read_text()]


class Starting(Executor):
    """An executor that is interrupted while it starts its first worker."""

    def __init__(self, number: signal.Signals) -> None:
        self.number, self.submitted, self.blocked = number, 0, set()

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        self.submitted += 1
        self.blocked = signal.pthread_sigmask(signal.SIG_BLOCK, [])
        if self.submitted == 1:
            os.kill(os.getpid(), self.number)
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def test_an_interrupt_while_workers_start_waits_until_they_have_started() -> None:
    workers = Starting(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        list(fly_each({"a": Scenario(), "b": Scenario()}, lambda *_: None, workers))
    assert workers.submitted == 2
    assert workers.blocked == {signal.SIGINT}  # which workers inherit, so that they never hear it
    assert signal.pthread_sigmask(signal.SIG_BLOCK, []) == set()


@pytest.fixture(params=ENDING_SIGNALS, ids=lambda number: number.name)
def number(request):
    """A signal that is answered by KeyboardInterrupt for the length of a test."""
    before = signal.signal(request.param, signal.default_int_handler)
    yield request.param
    signal.signal(request.param, before)


def test_a_signal_that_is_put_off_comes_when_the_block_is_left(number: signal.Signals) -> None:
    reached = []
    with pytest.raises(KeyboardInterrupt), interrupts_put_off():
        signal.raise_signal(number)
        signal.raise_signal(number)
        reached.append(True)
    assert reached
    assert signal.getsignal(number) is signal.default_int_handler


def test_who_asks_again_need_not_wait(number: signal.Signals, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr("a2s_drake.common.interrupts.time.monotonic", lambda: now[0])
    reached = []
    with pytest.raises(KeyboardInterrupt), interrupts_put_off():
        signal.raise_signal(number)
        now[0] = 1.1 * ONE_REQUEST
        signal.raise_signal(number)
        reached.append(True)
    assert not reached
    assert signal.getsignal(number) is signal.default_int_handler


def test_what_answers_signals_is_loaded_without_slow_packages() -> None:
    loaded = "import sys, scripts.ending; print(*sys.modules)"
    names = subprocess.run([sys.executable, "-c", loaded], capture_output=True, text=True, check=True).stdout.split()
    assert "a2s_drake.common.interrupts" in names
    assert not {"numpy", "pydrake", "scipy", "matplotlib"} & set(names)


def pause_from_the_second_on(_scenario: Scenario, place: int) -> None:
    time.sleep(60.0 if place else 0.0)


def test_workers_of_an_earlier_stage_end_with_the_one_that_fails() -> None:
    others = set(multiprocessing.active_children())
    with worker_processes(1) as workers:
        list(fly_each({"planned": Scenario()}, pause_from_the_second_on, workers))
        flights = fly_each({"short": Scenario(), "long": Scenario()}, pause_from_the_second_on, workers)
        next(flights)
        assert set(multiprocessing.active_children()) > others
        flights.close()
        wait_until(lambda: set(multiprocessing.active_children()) <= others, 20.0)


def test_signals_without_an_answer_are_left_alone() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with interrupts_put_off():
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
            assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
            signal.raise_signal(signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)
