"""Isolation: each case in a process of its own, so that a crash, a traceback or a hang is told from a refusal.

A server process imports all that is heavy once and forks a child per case, which saves a second of imports each. The
child then runs the script's file as if it had been typed.
"""

import io
import multiprocessing
import os
import resource
import runpy
import signal
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from time import monotonic

from scripts.trial.case import Case

# Where a case runs, what it prints and where its plans are kept, below the folder of the case or of the trial.
WORK, STDOUT, STDERR, CACHE = "work", "stdout.txt", "stderr.txt", "cache"

_PRELOADED = [f"scripts.{name}" for name in ("simulate", "compare", "robustness", "missions", "reproduce", "benchmark")]
# An input that asks for all the memory there is must fail alone.
_MEMORY = 8 * 2**30
# More than any script prints; a case that prints without end is read no further.
_PRINTED = 1_000_000


@dataclass(frozen=True)
class Ending:
    """How a case ended.

    Attributes:
      code: the exit code, minus a signal's number where one ended it, or None for a case that was still running.
      changed: the names of what was made, changed or removed in the case's folder.
      seconds: wall-clock time.
    """

    code: int | None
    stdout: str
    stderr: str
    changed: tuple[str, ...]
    seconds: float


@dataclass(frozen=True)
class _Running:
    case: Case
    process: BaseProcess
    folder: Path
    before: dict[str, tuple[int, ...]]
    started: float

    @property
    def left(self) -> float:
        return self.started + self.case.timeout - monotonic()


def endings(cases: Iterable[Case], folder: Path, jobs: int) -> Iterator[tuple[Case, Ending]]:
    """Runs each case in a folder named by its label, some at a time; gives each with its ending as soon as it ends."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(_PRELOADED)
    waiting, running = iter(cases), list[_Running]()
    try:
        while True:
            while len(running) < jobs and (case := next(waiting, None)) is not None:
                running.append(_start(case, folder / case.label, context))
            if not running:
                return
            wait([run.process.sentinel for run in running], max(0.0, min(run.left for run in running)))
            for run in [run for run in running if run.left <= 0.0 or not run.process.is_alive()]:
                running.remove(run)
                yield run.case, _finish(run)
    finally:
        for run in running:
            _kill(run.process)


def _start(case: Case, folder: Path, context: multiprocessing.context.ForkServerContext) -> _Running:
    case.prepare(folder / WORK)
    process = context.Process(target=_enact, args=(case, folder))
    before = _contents(folder / WORK)
    process.start()  # The first waits here until the server has imported everything.
    return _Running(case, process, folder, before, monotonic())


def _finish(run: _Running) -> Ending:
    hangs = run.process.is_alive()
    if hangs:
        _kill(run.process)
    run.process.join()
    after = _contents(run.folder / WORK)
    changed = tuple(sorted(name for name in run.before.keys() | after if run.before.get(name) != after.get(name)))
    code = None if hangs else run.process.exitcode
    return Ending(code, _text(run.folder / STDOUT), _text(run.folder / STDERR), changed, monotonic() - run.started)


def _kill(process: BaseProcess) -> None:
    """Ends a case with the worker processes that it has started."""
    if process.pid is not None and process.is_alive():
        with suppress(ProcessLookupError):  # where it has not come to lead a group of its own
            os.killpg(process.pid, signal.SIGKILL)
        process.kill()


def _contents(folder: Path) -> dict[str, tuple[int, ...]]:
    """What tells whether anything in a folder has changed, by name; links are not followed."""
    found = {}
    for place, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = Path(place, name)
            status = path.lstat()
            # A folder's own size and time change with what is in it, which is told by that.
            entry = () if name in folders else (status.st_size, status.st_mtime_ns, status.st_ino)
            found[str(path.relative_to(folder))] = entry
    return found


def _text(file: Path) -> str:
    if not file.exists():
        return ""
    with file.open("rb") as opened:
        return opened.read(_PRINTED).decode(errors="replace")


def _enact(case: Case, folder: Path) -> None:
    """In the child: runs the script's file as if typed, its output going to files, below this level of Python too."""
    os.setsid()  # so that its workers are ended with it
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    for stream, name in ((1, STDOUT), (2, STDERR)):
        os.dup2(os.open(folder / name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), stream)
    os.chdir(folder / WORK)
    # As in most locales, where a name that is no UTF-8 cannot be printed; workers and fresh interpreters inherit it.
    os.environ |= {"XDG_CACHE_HOME": str(folder.parent / CACHE), "PYTHONIOENCODING": "utf-8:strict"}
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(encoding="utf-8", errors="strict")
    sys.argv = [str(case.path), *case.arguments]
    if case.fresh:
        os.execv(sys.executable, [sys.executable, *sys.argv])
    runpy.run_path(str(case.path), run_name="__main__")
