"""Campaign: many flights through one executor."""

import multiprocessing
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from typing import TypeVar

from tqdm import tqdm

from a2s_drake.scenario import Scenario

Result = TypeVar("Result")


def worker_processes(count: int) -> ProcessPoolExecutor:
    """Worker processes for flights, started afresh rather than forked, that share one terminal for progress bars."""
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(count, context, initializer=tqdm.set_lock, initargs=(context.RLock(),))


def fly_each(
    scenarios: Mapping[str, Scenario], fly: Callable[[Scenario, int], Result], executor: Executor
) -> Iterator[tuple[str, Result]]:
    """Flights, or what else is made of scenarios, by name, in the order in which they are done.

    Whatever ends the iteration early (an interrupt, a flight's own error, a caller that stops) drops the flights that
    wait, and those under way with the worker processes that fly them; threads and clusters finish theirs.

    Args:
      fly: flies one validated scenario, given its place in the mapping; importable by the executor's workers.
    """
    others = set(multiprocessing.active_children())
    try:
        # Workers inherit the disposition they are started under: an interrupt is for this process alone to handle.
        with _interrupts_ignored():
            jobs = {executor.submit(fly, scenario, i): name for i, (name, scenario) in enumerate(scenarios.items())}
        for job in as_completed(jobs):
            yield jobs[job], job.result()
    except BaseException:
        executor.shutdown(wait=False, cancel_futures=True)
        for child in set(multiprocessing.active_children()) - others:
            child.terminate()
        raise


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread hears signals, and only it may change how
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
