"""The file of a replay, and the commands that write one or show a flight live."""

import dataclasses
import socket
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Meshcat

from a2s_drake import Flight, FlightEnded, run_flight
from a2s_drake.flight.log import array_names
from a2s_drake.views.replay import recording, start_meshcat, write_replay
from a2s_drake.views.replay.recording import shown_frames
from diagrams import build_link_only, load_scenario
from scripts import common, flying, simulate
from tests.support.flights import made_up_flight

SHORT = ["--duration", "0.2", "--set", "mpc.horizon=8"]


def test_a_replay_shows_the_first_sample_the_last_and_twenty_a_second() -> None:
    assert shown_frames(1, 0.02) == [0]
    assert shown_frames(5, 0.02) == [0, 3, 4]
    assert shown_frames(9, 0.05) == list(range(9))
    assert shown_frames(9, 10.0) == list(range(9))
    assert len(shown_frames(4_320_001, 0.02)) <= 1001


@pytest.mark.parametrize(("minutes", "rotor_speed"), [(0.84, 58.0), (10, 58.0), (10, np.nan), (24 * 60, 58.0)])
def test_no_file_is_larger_than_6_mb(minutes: float, rotor_speed: float, tmp_path: Path) -> None:
    # Around a circle, while the ship makes 5 m/s; both rays in and out of phase.
    t = np.arange(0.0, 60.0 * minutes, 0.05)
    n, turn = len(t), 2.0 * np.pi * t / t[-1]
    arrays = dict.fromkeys(array_names(), np.zeros(n)) | {
        "time": t,
        "position": 20.0 * np.stack([np.cos(turn) - 1.0, np.sin(turn), 0.0 * turn], axis=1),
        "attitude": 0.2 * np.sin(np.outer(t, [0.7, 0.9, 0.2])),
        "rotor_speed": np.full((n, 6), rotor_speed),
        "ship_position": np.stack([90.0 + 5.0 * t, 0.0 * t, 0.0 * t - 20.0], axis=1),
        "snr_db": 5.0 + 8.0 * np.sin(t),
    }
    flown = made_up_flight(**arrays)
    end = f"mission.ship_end=[{90.0 + 300.0 * minutes}, 0]"
    overrides = [f"mission.duration={60.0 * minutes}", "mission.radius=20", "mpc.period=0.05", end]
    write_replay(dataclasses.replace(flown, scenario=flown.scenario.with_overrides(overrides)), tmp_path / "long.html")
    assert (tmp_path / "long.html").stat().st_size <= 6_000_000


def test_the_file_of_a_mission_is_named_and_the_same_again(tmp_path: Path) -> None:
    scenario = load_scenario("paper").validate()
    flight = run_flight(build_link_only(scenario), scenario)
    for name in ("once.html", "again.html"):
        write_replay(flight, tmp_path / name)
    page = (tmp_path / "once.html").read_text()
    assert 4.4e6 < len(page) < 4.8e6
    assert "<title>a2s_drake: three_axis, 40 s</title>" in page
    assert (tmp_path / "again.html").read_text() == page


def test_replays_can_be_written_at_the_same_time(tmp_path: Path) -> None:
    paths = [tmp_path / f"{number}.html" for number in range(4)]
    with ThreadPoolExecutor(4) as threads:
        list(threads.map(lambda path: write_replay(made_up_flight(), path), paths))
    assert len({path.read_bytes() for path in paths}) == 1


def answers(port: int) -> bool:
    """Whether anything listens on a port of this machine."""
    with socket.socket() as client:
        return client.connect_ex(("127.0.0.1", port)) == 0


def test_no_server_outlives_the_writing(tmp_path: Path, monkeypatch) -> None:
    ports, served = [], []

    def start(port: int | None = None) -> Meshcat:
        meshcat = start_meshcat(port)
        ports.append(meshcat.port())
        served.append(answers(ports[-1]))
        return meshcat

    monkeypatch.setattr(recording, "start_meshcat", start)
    write_replay(made_up_flight(), tmp_path / "replay.html")
    with pytest.raises(ValueError, match="no sample"):
        write_replay(made_up_flight(**{name: np.empty(0) for name in array_names()}), tmp_path / "empty.html")
    assert served == [True]
    deadline = time.monotonic() + 10.0
    while answers(ports[0]) and time.monotonic() < deadline:
        time.sleep(0.01)
    assert not answers(ports[0])
    assert [path.name for path in tmp_path.iterdir()] == ["replay.html"]


def test_an_environment_that_forbids_meshcat_is_named(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("DRAKE_ALLOW_NETWORK", "none")
    with pytest.raises(OSError, match="DRAKE_ALLOW_NETWORK"):
        write_replay(made_up_flight(), tmp_path / "replay.html")


@pytest.mark.parametrize(
    "overrides",
    [
        ["mission.radius=0", "mission.ship_end=[90, 0]"],
        ["mission.sea_level=-2", "link.ship_antenna_height=30"],
        ["mission.ship_start=[-2.65, 0]", "mission.ship_end=[-2.65, 0]", "mission.radius=2.65"],
        ["mission.ship_start=[1e6, 0]", "mission.ship_end=[-1e6, 0]"],
        ["mission.ship_start=[0, -500]", "airframe.arm_length=2", "airframe.tilt_deg=0"],
        ["mpc.period=0.03", "mission.duration=0.001", "link.antenna_offset=[0, 0, 0]"],
    ],
)
def test_any_scenario_can_be_replayed(overrides: list[str], tmp_path: Path) -> None:
    made_up = made_up_flight()
    flight = dataclasses.replace(made_up, scenario=made_up.scenario.with_overrides(overrides))
    write_replay(flight, tmp_path / "a.html")
    assert 2e6 < (tmp_path / "a.html").stat().st_size < 6e6


def test_simulate_writes_a_replay_where_asked(tmp_path: Path, capsys) -> None:
    assert simulate.main(["paper", *SHORT, "--replay", "--out", str(tmp_path)]) == 0
    assert "<title>a2s_drake: three_axis, 0.2 s</title>" in (tmp_path / "replay.html").read_text()
    printed = capsys.readouterr()
    assert f"open {tmp_path / 'replay.html'}" in printed.out
    assert printed.err == ""


def test_simulate_watched_gives_the_same_flight(tmp_path: Path, capsys) -> None:
    assert simulate.main(["paper", *SHORT, "--out", str(tmp_path / "unwatched")]) == 0
    capsys.readouterr()
    assert simulate.main(["paper", *SHORT, "--meshcat", "--out", str(tmp_path / "watched")]) == 0
    printed = capsys.readouterr()
    assert printed.out.splitlines()[0].startswith("live view: http://localhost:")
    assert "until you press Enter" not in printed.out  # nobody is there to press it
    assert printed.err == ""
    for name in ("flight.npz", "scenario.yaml"):
        assert (tmp_path / "watched" / name).read_bytes() == (tmp_path / "unwatched" / name).read_bytes()


def test_a_flight_that_ends_early_keeps_its_replay(tmp_path: Path, monkeypatch) -> None:
    def end(*_: object, **__: object) -> None:
        raise FlightEnded("it broke", made_up_flight())

    monkeypatch.setattr(flying, "fly", end)
    assert simulate.main(["paper", "--replay", "--out", str(tmp_path)]) == 1
    assert (tmp_path / "replay.html").exists()


@pytest.mark.parametrize("answer", ["", KeyboardInterrupt(), EOFError()])
def test_the_live_view_stays_until_its_watcher_leaves(answer: object, monkeypatch, capsys) -> None:
    asked = []

    def press() -> str:
        asked.append(True)
        if isinstance(answer, BaseException):
            raise answer
        return ""

    monkeypatch.setattr("builtins.input", press)
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True, raising=False)
    common.serve_until_enter()
    assert asked == [True]
    assert "until you press Enter" in capsys.readouterr().out


def test_a_live_view_that_cannot_be_served_is_refused_before_the_flight(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.setenv("DRAKE_ALLOW_NETWORK", "none")
    assert simulate.main(["paper", "--meshcat", "--out", str(tmp_path)]) == 2
    assert "--meshcat: no Meshcat server can be started" in capsys.readouterr().err


def test_a_replay_that_cannot_be_made_is_named_after_the_flight_is_kept(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.setenv("DRAKE_ALLOW_NETWORK", "none")
    assert simulate.main(["paper", *SHORT, "--replay", "--out", str(tmp_path)]) == 1
    assert capsys.readouterr().err.startswith("error: no Meshcat server can be started: ")
    assert len(Flight.load(tmp_path).time) == 11
