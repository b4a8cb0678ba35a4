import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from a2s_drake import Flight, FlightEnded, Scenario
from a2s_drake.study.pool import fly_each
from tests.support.flights import made_up_flight
from tests.support.processes import children, wait_until

SCENARIOS = {law: Scenario().with_value("attitude_law.name", law) for law in ("three_axis", "pitch_only", "level")}


def pretend(scenario: Scenario, place: int) -> Flight:
    time.sleep(0.05 * (3 - place))
    return made_up_flight(scenario.attitude_law.name)


def test_each_flight_comes_under_its_name_as_it_is_done() -> None:
    with ThreadPoolExecutor(3) as workers:
        done = list(fly_each(SCENARIOS, pretend, workers))
    assert [name for name, _ in done] == ["level", "pitch_only", "three_axis"]
    assert all(flight.scenario.attitude_law.name == name for name, flight in done)


def test_an_error_in_one_flight_ends_the_campaign() -> None:
    def fail(scenario: Scenario, place: int) -> Flight:
        if place == 0:
            raise FlightEnded("broken", made_up_flight())
        return pretend(scenario, place)

    with ThreadPoolExecutor(1) as workers, pytest.raises(FlightEnded, match="broken"):
        list(fly_each(SCENARIOS, fail, workers))


@pytest.mark.parametrize("group", [False, True])
def test_an_interrupt_ends_the_comparison_at_once_and_keeps_what_was_done(group: bool, tmp_path: Path) -> None:
    # As from a terminal, where the whole process group hears it, and as from `kill`, where one process does.
    command = [sys.executable, "scripts/compare.py", "hover", "--duration", "600", "--out", str(tmp_path)]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    wait_until(lambda: len(children(process.pid)) >= 2)  # its workers
    time.sleep(4.0)
    assert process.poll() is None
    if group:
        os.killpg(process.pid, signal.SIGINT)
    else:
        process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=20.0)
    assert process.returncode == 130
    assert err == f"error: interrupted; flown to the end and kept in {tmp_path}: none\n"
    assert out == ""
