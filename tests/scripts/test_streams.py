"""Standard streams that the caller closed, whose reader has left, or that lie on a full disk."""

import subprocess
import sys
from pathlib import Path

import pytest

from a2s_drake import Flight
from tests.support.processes import HEAD, TAIL, end_of, environment, start_program

SIMULATE = "scripts/simulate.py hover --duration 0.1 --out OUT"
COMPARE = "scripts/compare.py hover --duration 0.1 --set mpc.horizon=8 --out OUT"
SHOW = "scripts/show_diagram.py closed_loop --format html"  # which is longer than a pipe is deep

REDIRECTIONS = [">&-", "2>&-", "<&-", "<&- >&- 2>&-", "| true", "| head -n 1", "2>&1 >/dev/null | true", "2>/dev/full"]
FULL = "error: standard output: No space left on device\n"
needs_full = pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")


def run_in_shell(command: str, redirection: str, folder: Path, **variables: str) -> tuple[int, str]:
    """The exit code of a script, and what it and the shell print to standard error."""
    line = f"{sys.executable} {command.replace('OUT', str(folder / 'out'))} {redirection}; exit ${{PIPESTATUS[0]}}"
    shell = ["bash", "-c", line]
    done = subprocess.run(
        shell, capture_output=True, text=True, check=False, timeout=120.0, env=environment(**variables)
    )
    return done.returncode, done.stderr


@pytest.mark.parametrize("redirection", REDIRECTIONS)
def test_a_script_does_its_work_whatever_becomes_of_its_streams(redirection: str, tmp_path: Path) -> None:
    assert run_in_shell(SIMULATE, redirection, tmp_path) == (0, "")
    assert len(Flight.load(tmp_path / "out").time) == 6
    assert (tmp_path / "out" / "metrics.json").exists()


@pytest.mark.parametrize("redirection", [">&- 2>&-", "| head -n 1"])
def test_long_output_may_go_nowhere(redirection: str, tmp_path: Path) -> None:
    assert run_in_shell(SHOW, redirection, tmp_path) == (0, "")


@pytest.mark.slow
@pytest.mark.parametrize("redirection", ["<&- >&- 2>&-", "| true", "2>&1 >/dev/null | true"])
def test_a_campaign_does_its_work_whatever_becomes_of_its_streams(redirection: str, tmp_path: Path) -> None:
    assert run_in_shell(COMPARE, redirection, tmp_path) == (0, "")
    for law in ("three_axis", "pitch_only", "level"):
        assert len(Flight.load(tmp_path / "out" / law).time) == 6
    for picture in ("channel_gain.png", "attitude.png"):
        assert (tmp_path / "out" / picture).read_bytes().startswith(b"\x89PNG")


@needs_full
@pytest.mark.parametrize(("redirection", "code"), [("| true", 0), (">/dev/full", 1)])
def test_unbuffered_output_is_no_different(redirection: str, code: int, tmp_path: Path) -> None:
    err = FULL if code else ""
    assert run_in_shell(SIMULATE, redirection, tmp_path, PYTHONUNBUFFERED="1") == (code, err)


@needs_full
@pytest.mark.parametrize("command", [SIMULATE, SHOW, f"{SIMULATE} --help"])
def test_a_full_disk_under_standard_output_is_one_line(command: str, tmp_path: Path) -> None:
    assert run_in_shell(command, ">/dev/full", tmp_path) == (1, FULL)


def test_a_refusal_stays_one_where_nobody_reads_why(tmp_path: Path) -> None:
    assert run_in_shell("scripts/simulate.py papper", "2>&1 | true", tmp_path) == (2, "")


def test_work_goes_on_behind_what_nobody_reads(tmp_path: Path) -> None:
    # The reader is gone before the first word.
    process = start_program(
        "def main():\n    ready.touch()\n    while not Path('gone').exists():\n        time.sleep(0.01)\n"
        "    print('to nobody', flush=True)\n    done.touch()\n    return 0\n",
        tmp_path,
    )
    process.stdout.close()
    (tmp_path / "gone").touch()
    process.stdout = None
    assert end_of(process) == (0, "")
    assert (tmp_path / "done").exists()


def test_no_file_gets_the_number_of_a_closed_stream_here_or_in_a_worker(tmp_path: Path) -> None:
    program = """
import os
from a2s_drake.study.pool import worker_processes

def opened(_):
    return os.open("/dev/zero", os.O_RDONLY)

def main():
    print("to nobody")
    print("to nobody", file=sys.stderr)
    with worker_processes(1) as workers:
        numbers = [opened(0), *workers.map(opened, range(2))]
    done.write_text(" ".join(map(str, numbers)))
    return 0
"""
    (tmp_path / "program.py").write_text(HEAD + program + TAIL)
    command = f"cd {tmp_path}; {sys.executable} program.py <&- >&- 2>&-"
    done = subprocess.run(["bash", "-c", command], check=False, timeout=120.0, env=environment())
    assert done.returncode == 0
    numbers = [int(number) for number in (tmp_path / "done").read_text().split()]
    assert len(numbers) == 3
    assert min(numbers) > 2
