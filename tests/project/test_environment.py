"""`make` finds a Python that runs, says which, and remakes an environment of another version.

The Pythons here are shell scripts that answer what `scripts/environment.sh` asks of a Python.
"""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.support.markdown import ROOT

# What a Python is asked: its version, whether it has pip, to make an environment, and to install into it.
FAKE = """#!/bin/sh
case "$1 $2" in
"-c import ensurepip"*) echo {version} ;;
"-c import pip") ;;
"-m venv") mkdir -p "$3/bin" && cp "$0" "$3/bin/python" ;;
"-m pip") echo "pip $*" >>pip.log ;;
esac
"""
BROKEN = "#!/bin/sh\necho 'pyenv: command not found' >&2\nexit 127\n"


class Clone:
    """A folder with the Makefile, its script, and a PATH that holds the given Pythons and the ordinary tools."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.programs = folder / "the clone", folder / "bin"
        (self.folder / "scripts").mkdir(parents=True)
        self.programs.mkdir()
        for name in ("Makefile", "pyproject.toml", "scripts/environment.sh"):
            shutil.copy2(ROOT / name, self.folder / name)
        for tool in ("sh", "dirname", "head", "sort", "awk", "sed", "rm", "cp", "mkdir", "touch", "make"):
            found = shutil.which(tool)
            assert found
            (self.programs / tool).symlink_to(found)

    def add_python(self, name: str, version: str | None, folder: Path | None = None) -> Path:
        program = (folder or self.programs) / name
        program.parent.mkdir(parents=True, exist_ok=True)
        program.write_text(BROKEN if version is None else FAKE.format(version=version))
        program.chmod(0o755)
        return program

    def make(self, *words: str, path: str = "") -> subprocess.CompletedProcess[str]:
        environment = {"PATH": path + str(self.programs)}
        return subprocess.run(
            ["make", "core", *words], cwd=self.folder, env=environment, capture_output=True, text=True, timeout=60
        )

    def version(self) -> str:
        asked = [str(self.folder / ".venv/bin/python"), "-c", "import ensurepip"]
        return subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip()


@pytest.fixture
def clone(tmp_path: Path) -> Clone:
    return Clone(tmp_path)


def test_newest_python_that_runs_is_taken_and_named(clone: Clone) -> None:
    for name, version in (("python3.11", "3.11"), ("python3.12", "3.12"), ("python3.13", None), ("python3", "3.9")):
        clone.add_python(name, version)
    printed = clone.make().stdout
    assert "making .venv with" in printed
    assert "python3.12 (Python 3.12)" in printed
    assert clone.version() == "3.12"


def test_name_that_fails_in_one_folder_is_sought_in_the_next(clone: Clone, tmp_path: Path) -> None:
    clone.add_python("python3.13", None, tmp_path / "shims")
    clone.add_python("python3.13", "3.13")
    assert "Python 3.13" in clone.make(path=f"{tmp_path / 'shims'}{os.pathsep}").stdout


def test_python3_that_is_newest_is_taken(clone: Clone) -> None:
    clone.add_python("python3.11", "3.11")
    clone.add_python("python3", "3.14")
    clone.make()
    assert clone.version() == "3.14"


def test_says_so_where_no_python_runs(clone: Clone) -> None:
    clone.add_python("python3.13", None)
    clone.add_python("python3", "3.10")
    done = clone.make()
    assert done.returncode != 0
    assert "no Python from 3.11 to 3.14 runs here" in done.stderr
    assert not (clone.folder / ".venv").exists()


@pytest.mark.parametrize(
    ("version", "reason"), [(None, "does not run"), ("3.10", "is Python 3.10; it must be 3.11 or newer")]
)
def test_python_asked_for_is_refused_with_the_true_reason(clone: Clone, version: str | None, reason: str) -> None:
    clone.add_python("python3.12", "3.12")
    clone.add_python("python3.13", version)
    done = clone.make("PYTHON=python3.13")
    assert done.returncode != 0
    assert reason in done.stderr
    assert "older" not in done.stderr
    assert not (clone.folder / ".venv").exists()


def test_python_asked_for_may_be_a_path_with_a_blank(clone: Clone, tmp_path: Path) -> None:
    clone.add_python("python3.13", "3.13")
    python = clone.add_python("python", "3.11", tmp_path / "my pythons")
    assert clone.make(f"PYTHON={python}").returncode == 0
    assert clone.version() == "3.11"


def test_environment_of_another_version_is_remade_and_said(clone: Clone) -> None:
    clone.add_python("python3.11", "3.11")
    clone.add_python("python3.13", "3.13")
    clone.make("PYTHON=python3.11")
    (clone.folder / ".venv" / "left over").touch()
    assert "remaking .venv" in clone.make("PYTHON=python3.13").stdout
    assert clone.version() == "3.13"
    assert not (clone.folder / ".venv" / "left over").exists()


def test_environment_that_works_is_kept_and_installed_once(clone: Clone) -> None:
    clone.add_python("python3.11", "3.11")
    clone.add_python("python3.13", "3.13")
    clone.make("PYTHON=python3.11")
    assert clone.make().stdout == ""
    assert clone.version() == "3.11"
    assert len((clone.folder / "pip.log").read_text().splitlines()) == 1


def test_environment_whose_python_is_gone_is_remade(clone: Clone) -> None:
    clone.add_python("python3.13", "3.13")
    (clone.folder / ".venv/bin").mkdir(parents=True)
    assert "a Python that does not run" in clone.make().stdout
    assert clone.version() == "3.13"


def test_flying_installs_no_development_extras(clone: Clone) -> None:
    clone.add_python("python3.13", "3.13")
    clone.make()
    assert "[dev]" not in (clone.folder / "pip.log").read_text()
    assert "\nrun: core\n" in (clone.folder / "Makefile").read_text()
