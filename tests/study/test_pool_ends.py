"""How a campaign ends early: what waits is dropped, what is not its own is left alone, interrupts come back."""

import multiprocessing
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor

import pytest

from a2s_drake import Scenario
from a2s_drake.study.pool import fly_each

SCENARIOS = {str(number): Scenario() for number in range(10)}


class AtOnce(Executor):
    """Runs each job where and when it is submitted, and notes which signals a process started then would not hear."""

    def __init__(self) -> None:
        self.blocked: list[set[signal.Signals]] = []

    def submit(self, fn, /, *arguments, **options) -> Future:
        self.blocked.append(signal.pthread_sigmask(signal.SIG_BLOCK, []))
        job: Future = Future()
        job.set_result(fn(*arguments, **options))
        return job


@pytest.fixture
def handler() -> Iterator[Callable[..., None]]:
    """What an interrupt does here before a campaign, as it should after it."""

    def hear(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, hear)
    yield hear
    signal.signal(signal.SIGINT, before)


def test_flights_that_wait_are_dropped() -> None:
    flown, ended = [], threading.Event()

    def fail(_scenario: Scenario, place: int) -> None:
        flown.append(place)
        if place == 0:
            raise ValueError("broken")
        assert ended.wait(60.0)

    with ThreadPoolExecutor(1) as workers:
        with pytest.raises(ValueError, match="broken"):
            list(fly_each(SCENARIOS, fail, workers))
        ended.set()
    assert flown in ([0], [0, 1])  # The second may have begun before the first one's error was heard of.


def test_workers_start_deaf_to_interrupts_and_the_caller_goes_on_with_its_own(handler) -> None:
    workers = AtOnce()
    list(fly_each(SCENARIOS, lambda _scenario, place: place, workers))
    assert all(signal.SIGINT in blocked for blocked in workers.blocked)
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])
    assert signal.getsignal(signal.SIGINT) is handler


def test_interrupts_come_back_when_a_flight_cannot_even_be_handed_out(handler) -> None:
    def fail(_scenario: Scenario, _place: int) -> None:
        raise ValueError("refused")

    with pytest.raises(ValueError, match="refused"):
        list(fly_each(SCENARIOS, fail, AtOnce()))
    assert signal.getsignal(signal.SIGINT) is handler


def test_a_campaign_can_be_run_by_any_thread() -> None:
    done = []
    thread = threading.Thread(target=lambda: done.extend(fly_each(SCENARIOS, lambda _, place: place, AtOnce())))
    thread.start()
    thread.join()
    assert sorted(place for _, place in done) == list(range(10))


def test_processes_that_were_there_before_live_on() -> None:
    bystander = multiprocessing.get_context("spawn").Process(target=time.sleep, args=(60.0,), daemon=True)
    bystander.start()

    def fail(_scenario: Scenario, _place: int) -> None:
        raise ValueError("broken")

    try:
        with ThreadPoolExecutor(1) as workers, pytest.raises(ValueError, match="broken"):
            list(fly_each(SCENARIOS, fail, workers))
        bystander.join(0.2)
        assert bystander.is_alive()
    finally:
        bystander.kill()
        bystander.join()
