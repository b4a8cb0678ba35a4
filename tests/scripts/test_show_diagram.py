import subprocess
import sys
from pathlib import Path

import pytest

from a2s_drake.views.graph import (
    FORMATS,
    read_graph,
)
from diagrams import BUILDERS
from scripts import show_diagram
from tests.support.graphs import DISTURBED, build


@pytest.mark.parametrize("name", BUILDERS)
@pytest.mark.parametrize("form", FORMATS)
def test_script_writes_every_format_of_every_diagram(name: str, form: str, tmp_path: Path, capsys) -> None:
    file = tmp_path / "folder" / f"{name}.{form}"
    assert show_diagram.main([name, "--format", form, "--out", str(file)]) == 0
    assert capsys.readouterr().out == f"written to {file}\n"
    assert file.read_text(encoding="utf-8") == FORMATS[form](read_graph(build(name)))


def test_script_prints_the_same_in_every_process() -> None:
    command = [sys.executable, "-m", "scripts.show_diagram", "closed_loop", "--format", "dot"]
    printed = {subprocess.run(command, capture_output=True, text=True, check=True).stdout for _ in range(2)}
    assert len(printed) == 1


def test_script_lists_the_diagrams(capsys) -> None:
    assert show_diagram.main(["--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(BUILDERS)
    assert all(len(line.split()) > 3 for line in lines)


def test_script_shows_what_a_scenario_adds(capsys) -> None:
    assert show_diagram.main(["closed_loop", "--depth", "2", "--set", *DISTURBED]) == 0
    assert "input_delay  (InputDelay)" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ([], "no NAME; there are closed_loop, link_only, airframe_only"),
        (["loop"], "no diagram named 'loop'; there are closed_loop, link_only, airframe_only"),
        (["closed_loop", "--depth", "-1"], "--depth -1: must be at least 0"),
        (["closed_loop", "--format", "pdf"], "invalid choice: 'pdf'"),
        (["closed_loop", "--scenario", "papper"], "no scenario named 'papper'"),
        (["closed_loop", "--set", "mpc.horizon=0"], "mpc.horizon = 0"),
        (["closed_loop", "--out", "tests"], "--out tests: cannot be written"),
    ],
)
def test_script_refuses_in_one_line(arguments: list[str], reason: str, capsys) -> None:
    assert show_diagram.main(arguments) == 2
    printed = capsys.readouterr()
    assert reason in printed.err
    assert printed.err.count("\n") == 1
    assert printed.out == ""
