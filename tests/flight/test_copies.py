"""A flight keeps the track files that it flew, so that its folder alone flies it again."""

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Flight, Scenario, ScenarioError, run_flight
from a2s_drake.flight.log import array_names
from a2s_drake.views.replay.recording import replay_html
from diagrams import build_link_only
from scripts import simulate
from tests.support.flights import made_up_flight
from tests.support.markdown import ROOT
from tests.support.tracks import circle, write_track

TIME = np.linspace(0.0, 40.0, 201)


@pytest.fixture
def dut(tmp_path: Path) -> Scenario:
    """A short ideal flight on a path and to a ship from files in a folder of their own."""
    folder = tmp_path / "mine"
    folder.mkdir()
    path = write_track(folder / "my path.csv", TIME, circle(TIME, radius=2.0))
    ship = np.stack([90.0 + TIME / 5.0, np.sin(TIME / 3.0)], axis=-1)
    track = write_track(folder / "my ship.csv", TIME, ship, "time,x,y")
    names = [f"mission.path_file={path}", f"mission.ship_track_file={track}"]
    return Scenario().with_overrides([*names, "simulation.duration=0.2"])


def flown(scenario: Scenario) -> Flight:
    return run_flight(build_link_only(scenario), scenario)


def names_in(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.iterdir())


def assert_alike(one: Flight, other: Flight) -> None:
    for name in array_names():
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


def test_a_folder_alone_flies_the_flight_again(dut: Scenario, tmp_path: Path, monkeypatch) -> None:
    flight, path, track = flown(dut), Path(dut.mission.path_file), Path(dut.mission.ship_track_file)
    before = {"path.csv": path.read_bytes(), "ship_track.csv": track.read_bytes()}
    path.write_text("nonsense")  # The flight keeps what was in the files when its diagram was built.
    track.unlink()
    flight.save(tmp_path / "out")
    assert names_in(tmp_path / "out") == ["flight.npz", "path.csv", "scenario.yaml", "ship_track.csv"]
    assert {name: (tmp_path / "out" / name).read_bytes() for name in before} == before
    text = (tmp_path / "out" / "scenario.yaml").read_text()
    assert "path_file: path.csv\n" in text
    assert "ship_track_file: ship_track.csv\n" in text
    (tmp_path / "out").rename(tmp_path / "moved")
    monkeypatch.chdir(tmp_path / "mine")
    again = Flight.load(Path("..") / "moved")
    assert_alike(again, flight)
    assert again.files == flight.files
    assert_alike(flown(again.scenario), flight)


def test_a_loaded_flight_is_saved_elsewhere_with_its_files(dut: Scenario, tmp_path: Path) -> None:
    flown(dut).save(tmp_path / "out")
    loaded = Flight.load(tmp_path / "out")
    for file in (tmp_path / "out").iterdir():
        file.unlink()
    loaded.save(tmp_path / "other")
    assert_alike(Flight.load(tmp_path / "other"), loaded)
    loaded.save(tmp_path / "out")
    assert names_in(tmp_path / "out") == names_in(tmp_path / "other")


def test_a_later_flight_leaves_no_copy_of_an_earlier_one(dut: Scenario, tmp_path: Path) -> None:
    flown(dut).save(tmp_path / "out")
    flown(dut.with_value("mission.path_file", None)).save(tmp_path / "out")
    assert names_in(tmp_path / "out") == ["flight.npz", "scenario.yaml", "ship_track.csv"]
    flown(Scenario().with_value("simulation.duration", 0.1)).save(tmp_path / "out")
    assert names_in(tmp_path / "out") == ["flight.npz", "scenario.yaml"]
    assert Flight.load(tmp_path / "out").files == {}


def test_a_flight_made_by_hand_is_saved_with_the_files_of_now(dut: Scenario, tmp_path: Path) -> None:
    dataclasses.replace(made_up_flight(), scenario=dut).save(tmp_path / "out")
    assert (tmp_path / "out" / "path.csv").read_bytes() == Path(dut.mission.path_file).read_bytes()


@pytest.mark.parametrize("damage", ["lost", "a folder"])
def test_a_flight_without_its_copy_loads_without_that_file(dut: Scenario, tmp_path: Path, damage: str) -> None:
    flight = flown(dut)
    flight.save(tmp_path / "out")
    copy = tmp_path / "out" / "path.csv"
    copy.unlink()
    if damage == "a folder":
        copy.mkdir()
    with pytest.warns(
        UserWarning, match=r"^mission.path_file = '.*out/path.csv': [^\n]*; the flight is loaded"
    ) as told:
        loaded = Flight.load(tmp_path / "out")
    assert [Path(warning.filename).name for warning in told] == ["test_copies.py"]
    assert_alike(loaded, flight)
    assert loaded.files == {"ship_track_file": flight.files["ship_track_file"]}
    # Its folder would not fly it again, so that it is not saved as if it did.
    with pytest.raises(ScenarioError, match=r"^mission.path_file = "):
        loaded.save(tmp_path / "other")


def test_a_replay_shows_what_was_flown(dut: Scenario) -> None:
    flight = flown(dut)
    before = replay_html(flight)
    Path(dut.mission.path_file).write_text("nonsense")
    assert replay_html(flight) == before
    Path(dut.mission.path_file).unlink()
    assert replay_html(flight) == before


@pytest.mark.usefixtures("dut")
def test_simulate_flies_a_folder_again_from_anywhere(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path / "mine")
    # From the command line, names are relative to the working directory.
    names = ["mission.path_file=my path.csv", "mission.ship_track_file=my ship.csv"]
    assert simulate.main(["--set", *names, "--duration", "0.2", "--out", "../out"]) == 0
    before = Flight.load(tmp_path / "out")
    assert {"path.csv", "ship_track.csv", "metrics.json"} < set(names_in(tmp_path / "out"))
    np.testing.assert_allclose(before.position_reference, circle(before.time, radius=2.0), atol=1e-5)
    for file in (tmp_path / "mine").iterdir():
        file.unlink()
    command = [sys.executable, str(ROOT / "scripts" / "simulate.py"), str(tmp_path / "out" / "scenario.yaml")]
    subprocess.run([*command, "--out", str(tmp_path / "again")], cwd="/", check=True, capture_output=True)
    assert_alike(Flight.load(tmp_path / "again"), before)
    assert names_in(tmp_path / "again") == names_in(tmp_path / "out")
    # Into the same folder, from another one, it writes the same files.
    monkeypatch.chdir(tmp_path)
    assert simulate.main(["out/scenario.yaml", "--out", "out"]) == 0
    assert_alike(Flight.load(tmp_path / "out"), before)


def test_a_refused_file_is_told_in_one_line(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bad.csv").write_text("time,x,y,z\n0,0,0,0\n1,a,0,0\n")
    assert simulate.main(["--set", "mission.path_file=bad.csv", "--out", "out"]) == 2
    error = capsys.readouterr().err
    assert error == (
        "error: mission.path_file = 'bad.csv': line 3: x must be a number of at most 1e+06 in magnitude, is 'a'\n"
    )
    assert not Path("out").exists()
