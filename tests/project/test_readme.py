"""What the documentation tells a reader to type works, and what it says is printed is what is printed.

The Python and the links of the pages in docs/ are tested with the site that they make, in test_docs.py.
"""

import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

from scripts import show_diagram
from tests.support.markdown import PAGES, ROOT, CodeBlock, code_blocks, commands, inline_commands

BLOCKS = [block for page in PAGES for block in code_blocks(page)]
TYPED = [block for block in BLOCKS if block.language == "sh"]
PYTHON = [block for block in BLOCKS if block.language == "python" and block.page == "README.md"]
DRAWN = [block for block in BLOCKS if block.comment.startswith("show_diagram ")]
EVERY_COMMAND = [command for block in TYPED for command in commands(block)]
EVERY_INLINE_COMMAND = list(dict.fromkeys(command for page in PAGES for command in inline_commands(page)))

# The suite cannot run itself; these are what .ci/run calls. `make clean` has a test of its own.
NOT_TYPED = ("make test", "make test-slow", "make clean")
LONG = ("make run", "make reproduce", "make robustness", "make bench")
LONG += ("scripts/reproduce.py", "scripts/benchmark.py", "results/mine", "simulate.py planned", "compare.py planned")
LONG += ("scripts/robustness.py", "make check")


def marked(block: CodeBlock) -> object:
    """The block, marked slow where one of its commands is."""
    slow = any(name in command for command in commands(block) for name in LONG)
    name = f"{block.page}: {commands(block)[0]}"
    return pytest.param(block, id=name, marks=[pytest.mark.slow] if slow else [])


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The working tree as a clone would have it, with this environment for its own."""
    folder = tmp_path_factory.mktemp("clone")
    listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    names = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\0")
    for name in filter(None, names):
        if (ROOT / name).exists():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    (folder / ".venv").symlink_to(ROOT / ".venv")
    subprocess.run(["git", "init", "--quiet"], cwd=folder, check=True)
    return folder


def type_in(command: str, clone: Path) -> str:
    """Runs a command in the clone, whose modules come before the installed ones; returns what it printed."""
    environment = os.environ | {"PYTHONPATH": str(clone)}
    process = subprocess.run(command, shell=True, cwd=clone, env=environment, capture_output=True, text=True)
    assert process.returncode == 0, process.stdout + process.stderr
    return process.stdout


@pytest.mark.skipif(not (ROOT / ".venv").is_dir(), reason="the commands are typed into an environment made by make")
@pytest.mark.parametrize("block", [marked(block) for block in TYPED])
def test_commands_work_one_after_another(block: CodeBlock, clone: Path) -> None:
    for command in commands(block):
        if command in NOT_TYPED:
            continue
        printed = type_in(command, clone)
        if command == "make run":
            documented = next(
                b.text for b in BLOCKS if b.page == "README.md" and b.text.lstrip().startswith("throughput")
            )
            assert tables_agree(printed, documented)


def tables_agree(printed: str, documented: str) -> bool:
    """Whether two comparison tables agree but for the last three columns, which are the machine's."""

    def numbers(text: str) -> list[list[str]]:
        rows = [line for line in text.splitlines() if line.startswith(("three_axis", "pitch_only", "level"))]
        return [re.split(r"\s{2,}", row)[:-3] for row in rows]

    assert len(numbers(printed)) == 3
    return numbers(printed) == numbers(documented)


def test_commands_of_the_suite_are_those_of_ci() -> None:
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()
    assert {"make test", "make test-slow"} <= {line.strip().split(" PYTHON=")[0] for line in script}


def test_clean_leaves_what_is_under_version_control(clone: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(clone, copy, symlinks=True)
    before = {path for path in copy.rglob("*") if ".git" not in path.parts and ".venv" not in path.parts}
    (copy / "results").mkdir(exist_ok=True)
    type_in("make clean", copy)
    gone = {path.relative_to(copy).parts[0] for path in before if not path.exists()}
    assert gone <= {"results", "site", ".pytest_cache", ".mypy_cache", ".ruff_cache", ".hypothesis"}
    assert not (copy / ".venv").exists()


@pytest.mark.parametrize("command", EVERY_INLINE_COMMAND)
def test_command_in_the_text_is_one_that_is_tried(command: str) -> None:
    words = shlex.split(command.removeprefix(".venv/bin/python "))
    tried = [shlex.split(other.removeprefix(".venv/bin/python ")) for other in EVERY_COMMAND]
    drawn = [["scripts/show_diagram.py", *shlex.split(block.comment)[1:]] for block in DRAWN]
    assert any(words == other[: len(words)] for other in [*tried, *drawn])


@pytest.mark.parametrize("block", DRAWN, ids=lambda block: block.comment)
def test_diagram_in_the_text_is_what_the_script_draws(block: CodeBlock, capsys) -> None:
    assert show_diagram.main(shlex.split(block.comment)[1:]) == 0
    assert block.text == capsys.readouterr().out


def test_readme_shows_the_closed_loop_as_picture_and_as_table() -> None:
    drawn = [block.comment for block in DRAWN if block.page == "README.md"]
    assert drawn == ["show_diagram closed_loop --depth 2 --format mermaid", "show_diagram closed_loop --depth 1"]


@pytest.mark.parametrize("block", PYTHON, ids=lambda block: block.text.splitlines()[0])
def test_python_in_the_text_runs(block: CodeBlock, tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(block.text, block.page, "exec"), {"__name__": "__main__"})
    printed = capsys.readouterr().out.splitlines()
    promised = [
        line.split("  # ")[1] for line in block.text.splitlines() if line.startswith("print") and "  # " in line
    ]
    assert set(promised) <= set(printed)


@pytest.mark.parametrize("page", [ROOT / "README.md", ROOT / "CONTRIBUTING.md"], ids=lambda page: page.name)
def test_links_and_pictures_lead_to_files(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#\s]+)", page.read_text(encoding="utf-8")):
        if "://" not in target:
            assert (page.parent / target).exists(), target
