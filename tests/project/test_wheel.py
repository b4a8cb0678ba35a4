"""What `pip install` of the wheel brings: the library and the drawings, under one name."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.support.markdown import ROOT

pytest.importorskip("hatchling", reason="hatchling builds the wheel")

USE = """
import sys
from pathlib import Path

import a2s_drake
from a2s_drake.diagrams import BUILDERS, SCENARIOS, Blocks, build_closed_loop, load_scenario

scenario = load_scenario("paper").with_value("simulation.duration", 0.04)
assert len(a2s_drake.run_flight(build_closed_loop(scenario, blocks=Blocks()), scenario).time) == 3
assert "diagrams" not in sys.modules
assert all(Path(file).is_relative_to(sys.argv[1]) for file in (a2s_drake.__file__, SCENARIOS))
"""


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that the wheel's content is unpacked in."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


def test_the_wheel_brings_one_package_and_its_drawings(unpacked: Path) -> None:
    assert {path.name for path in unpacked.iterdir() if path.suffix != ".dist-info"} == {"a2s_drake"}
    drawings = {path.name for path in (ROOT / "diagrams").iterdir() if path.suffix in (".py", ".yaml")}
    assert {path.name for path in (unpacked / "a2s_drake" / "diagrams").iterdir()} == drawings
    assert not (unpacked / "a2s_drake" / "diagrams.py").exists()


def test_the_drawings_of_the_wheel_fly(unpacked: Path, tmp_path: Path) -> None:
    environment = os.environ | {"PYTHONPATH": str(unpacked)}
    command = [sys.executable, "-c", USE, str(unpacked)]
    run = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120.0)
    assert run.returncode == 0, run.stderr


def test_in_a_clone_both_names_give_the_same_drawings() -> None:
    import a2s_drake.diagrams
    import diagrams

    assert all(getattr(a2s_drake.diagrams, name) is getattr(diagrams, name) for name in diagrams.__all__)
