"""Real processes under test: programs that are run, signalled, and looked at from outside."""

import array
import fcntl
import os
import signal
import subprocess
import sys
import termios
import time
from collections.abc import Callable
from pathlib import Path

import pytest

# What a program can catch, and who its children are, is read from here.
needs_proc = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs /proc")

# Programs under test are no `-c`, so that worker processes can import them.
HEAD = """import sys, time
from pathlib import Path
if __name__ == "__main__":
    import scripts.startup
from scripts import common
ready, done = Path("ready"), Path("done")
"""
TAIL = """
if __name__ == "__main__":
    common.run(main)
"""


def wait_until(condition: Callable[[], object], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


def environment(**changes: str) -> dict[str, str]:
    """The environment of a process under test, which finds the project, and whose output is buffered as usual."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    return kept | {"PYTHONPATH": str(Path.cwd())} | changes


def start(command: list[str], folder: Path | None = None) -> subprocess.Popen[str]:
    """Starts Python in a session of its own."""
    return subprocess.Popen(
        [sys.executable, *command],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
        env=environment(),
        start_new_session=True,
    )


def start_program(text: str, folder: Path) -> subprocess.Popen[str]:
    """Starts a program whose `main` `common.run` runs; once it is under way it makes the file `ready` in the folder."""
    (folder / "program.py").write_text(HEAD + text + TAIL)
    process = start(["program.py"], folder)
    wait_until(lambda: (folder / "ready").exists() or process.poll() is not None)
    return process


def end_of(process: subprocess.Popen[str]) -> tuple[int, str]:
    """Exit code and standard error; a process that does not end is killed."""
    try:
        _, err = process.communicate(timeout=60.0)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        raise
    return process.returncode, err


def unread(process: subprocess.Popen[str]) -> int:
    """How many bytes wait in the pipe of a process's standard output."""
    count = array.array("i", [0])
    fcntl.ioctl(process.stdout, termios.FIONREAD, count)
    return count[0]


def children(pid: int) -> list[int]:
    """The processes, but for zombies, that a process has started and not yet left behind."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            state, parent = (folder / "stat").read_text().rpartition(")")[2].split()[:2]
        except OSError:  # It has ended meanwhile.
            continue
        if int(parent) == pid and state != "Z":
            found.append(int(folder.name))
    return found


def is_there(pid: int) -> bool:
    """Whether a process runs."""
    try:
        return (Path("/proc") / str(pid) / "stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def catches(process: subprocess.Popen[str], number: signal.Signals) -> bool:
    """Whether a process has set up an answer of its own to a signal."""
    try:
        status = (Path("/proc") / str(process.pid) / "status").read_text()
    except OSError:
        return False
    caught = next((line.split()[1] for line in status.splitlines() if line.startswith("SigCgt")), "0")
    return bool(int(caught, 16) >> (number - 1) & 1)
