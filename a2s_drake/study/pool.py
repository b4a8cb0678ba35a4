"""Pool: many flights through one executor, such as a pool of worker processes."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from typing import Any, TypeVar

from tqdm import tqdm

from a2s_drake.common.interrupts import deaf_offspring, interrupts_put_off
from a2s_drake.scenario.scenario import Scenario

Result = TypeVar("Result")


def worker_processes(count: int) -> ProcessPoolExecutor:
    """Worker processes for flights, started afresh rather than forked, that share one terminal for progress bars.

    They end with this process, however it ends.
    """
    context = multiprocessing.get_context("spawn")
    # The first lock starts Python's own process that cleans up locks. A terminal that closes must not end that one too.
    with deaf_offspring(signal.SIGHUP):
        progress_lock = context.RLock()
    return _Workers(count, context, initializer=_begin_work, initargs=(progress_lock,))


class _Workers(ProcessPoolExecutor):
    """Worker processes that are listed, so that only they are ended."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.started: set[Any] = set()

    def submit(self, fn: Callable[..., Result], /, *args: Any, **options: Any) -> Future[Result]:
        """As in the class above; notes the processes that it starts."""
        before = set(multiprocessing.active_children())
        try:
            return super().submit(fn, *args, **options)
        finally:
            self.started |= set(multiprocessing.active_children()) - before


def _begin_work(progress_lock: Any) -> None:
    tqdm.set_lock(progress_lock)
    threading.Thread(target=_end_with_parent, name="end with parent", daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        # A worker that waits for its next flight, or is in the middle of one, would otherwise never notice.
        os._exit(1)


def fly_each(
    scenarios: Mapping[str, Scenario], fly: Callable[[Scenario, int], Result], executor: Executor
) -> Iterator[tuple[str, Result]]:
    """Flights, or what else is made of scenarios, by name, in the order in which they are done.

    The iteration may end early: by an interrupt, by a flight's own error, or because the caller stops. Then the flights
    that wait are dropped, and so are those under way in worker processes, which are ended. Threads and clusters finish
    the flights that they have begun.

    Args:
      fly: flies one validated scenario, given its place in the mapping; importable by the executor's workers.
    """
    others = set(multiprocessing.active_children())
    try:
        # Only this process handles an interrupt, so workers are started deaf to it. A worker that is cut off from its
        # parent while it starts would complain, so this process answers only after all have started.
        with interrupts_put_off(), deaf_offspring(signal.SIGINT):
            jobs = {executor.submit(fly, scenario, i): name for i, (name, scenario) in enumerate(scenarios.items())}
        for job in as_completed(jobs):
            yield jobs[job], job.result()
    except BaseException:
        executor.shutdown(wait=False, cancel_futures=True)
        # Workers of ours may have been started by an earlier call with the same executor, so it names them itself.
        newcomers = set(multiprocessing.active_children()) - others
        for child in executor.started if isinstance(executor, _Workers) else newcomers:
            child.terminate()
        raise
