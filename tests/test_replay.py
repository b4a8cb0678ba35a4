import dataclasses
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from time import perf_counter, sleep

import numpy as np
import pytest

from a2s_drake import Flight, FlightEnded, Scenario, run_flight
from a2s_drake.flight import array_names
from a2s_drake.replay import write_replay
from a2s_drake.replay.gauge import gauge_scale, time_ticks
from a2s_drake.replay.recording import shown_frames
from a2s_drake.replay.shapes import GLYPHS, prism, strokes, text, tube
from a2s_drake.two_ray import path_lengths, specular_point
from diagrams import build_link_only, load_scenario
from scripts import common, simulate
from tests.flights import made_up_flight

WORLD = "/drake/world_seen_from_vehicle"
VEHICLE = f"{WORLD}/vehicle"
RAYS = f"{WORLD}/rays_widened_with_distance"
SHIP = f"{WORLD}/ship_sized_by_its_antenna"
GAUGE = "/drake/gauge/size"
BAR = f"{GAUGE}/bar"
SHORT = ["--duration", "0.2", "--set", "mpc.horizon=8"]


def test_the_sea_reflects_at_the_angle_of_incidence(scenario: Scenario, rng: np.random.Generator) -> None:
    antenna = rng.uniform([-5.0, -5.0, -5.0], [5.0, 5.0, 5.0], (50, 3))
    ship = np.array([95.0, 3.0, -20.0])
    point = specular_point(antenna, ship, scenario.link)
    np.testing.assert_allclose(point[:, 2], -20.0, atol=1e-12)
    down, up = point - antenna, ship + np.array([0.0, 0.0, 10.0]) - point
    into = down / np.linalg.norm(down, axis=1, keepdims=True)
    out = up / np.linalg.norm(up, axis=1, keepdims=True)
    np.testing.assert_allclose(out, into * [1.0, 1.0, -1.0], atol=1e-12)
    length = np.linalg.norm(down, axis=1) + np.linalg.norm(up, axis=1)
    np.testing.assert_allclose(length, path_lengths(antenna, ship, scenario.link)[1], rtol=1e-13)


@pytest.mark.parametrize("name", ["paper", "tilt35", "hover"])
def test_the_gauge_holds_every_snr_of_the_mission(name: str) -> None:
    scenario = load_scenario(name).with_value("simulation.duration", 40.0)
    scale = gauge_scale(scenario)
    flown = run_flight(build_link_only(scenario), scenario.with_value("simulation.duration", 4.0))
    assert scale.low_db <= flown.snr_db.min()
    assert flown.snr_db.max() <= scale.high_db
    assert scale.high_db - scale.low_db <= 25.0


def test_the_gauge_rises_with_the_snr_and_stops_at_its_ends(scenario: Scenario) -> None:
    scale = gauge_scale(scenario)
    levels = np.linspace(scale.low_db, scale.high_db, 50)
    np.testing.assert_allclose([scale.fraction(level) for level in levels], np.linspace(0.0, 1.0, 50), atol=1e-12)
    assert [scale.fraction(level) for level in (-np.inf, np.nan, np.inf, 1e3)] == [0.0, 0.0, 1.0, 1.0]


def test_a_perfect_mirror_leaves_the_gauge_a_lower_end(scenario: Scenario) -> None:
    mirror = scenario.with_overrides(["link.reflection_magnitude=1", "mission.ship_start=[1e5, 0]"])
    scale = gauge_scale(mirror.with_overrides(["mission.ship_end=[1e5, 0]"]))
    assert 40.0 <= scale.high_db - scale.low_db <= 50.0


@pytest.mark.parametrize("end", [1e-4, 0.02, 0.2, 1.0, 3.3, 40.0, 99.9, 86400.0])
def test_the_time_axis_has_a_few_round_ticks(end: float) -> None:
    ticks = time_ticks(end)
    assert ticks[0] == 0.0
    assert end * 0.6 < ticks[-1] <= end * (1.0 + 1e-9)
    assert 3 <= len(ticks) <= 6
    assert float(f"{ticks[1]:.6e}"[:8].rstrip("e")) in (1.0, 2.0, 5.0)


def test_no_two_characters_look_alike() -> None:
    drawn = {character: frozenset(segments) for character, segments in GLYPHS.items()}
    drawn.pop("S")  # which every seven-segment display writes as a 5
    assert len(set(drawn.values())) == len(drawn)


def test_text_stands_where_it_is_anchored() -> None:
    for align, (left, right) in {0.0: (5.0, 7.7), 0.5: (3.65, 6.35), 1.0: (2.3, 5.0)}.items():
        segments = text("20", 2.0, (5.0, 1.0), align)
        np.testing.assert_allclose([segments[..., 0].min(), segments[..., 0].max()], [left, right])
        np.testing.assert_allclose([segments[..., 1].min(), segments[..., 1].max()], [1.0, 3.0])


def volume(mesh: tuple[np.ndarray, np.ndarray]) -> float:
    """Of a closed mesh whose faces look outward, by the divergence theorem."""
    a, b, c = (mesh[0][:, corner].T for corner in mesh[1])
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def test_meshes_face_outward() -> None:
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 3.0], [0.0, 3.0]])
    assert volume(prism(square, 1.0, 5.0)) == pytest.approx(24.0)
    flat = strokes(np.array([[[0.0, 0.0], [4.0, 0.0]]]), 2.0)
    first, second, third = (flat.vertices[:, corner].T for corner in flat.faces)
    normals = np.cross(second - first, third - first)
    np.testing.assert_allclose(normals.sum(axis=0) / 2.0, [0.0, 0.0, 6.0 * 2.0])
    pipe = tube(np.zeros(3), np.array([0.0, 0.0, 2.0]), 1.0, 0.5, sides=60)
    middle = pipe.vertices[:, pipe.faces].mean(axis=1).T * [1.0, 1.0, 0.0]
    first, second, third = (pipe.vertices[:, corner].T for corner in pipe.faces)
    assert np.all(np.einsum("ij,ij->i", np.cross(second - first, third - first), middle) > 0.0)


def test_a_replay_shows_the_first_sample_the_last_and_twenty_a_second() -> None:
    assert shown_frames(1, 0.02) == [0]
    assert shown_frames(5, 0.02) == [0, 3, 4]
    assert shown_frames(9, 0.05) == list(range(9))
    assert shown_frames(9, 10.0) == list(range(9))
    assert len(shown_frames(864_001, 0.1)) <= 1201


def test_replays_can_be_written_at_the_same_time(tmp_path: Path) -> None:
    paths = [tmp_path / f"{number}.html" for number in range(4)]
    with ThreadPoolExecutor(4) as threads:
        list(threads.map(lambda path: write_replay(made_up_flight(), path), paths))
    assert len({path.read_bytes() for path in paths}) == 1


@pytest.mark.skipif(sys.platform != "linux", reason="counts threads where Linux lists them")
def test_no_server_outlives_the_writing(tmp_path: Path) -> None:
    def count() -> int:
        return len(list(Path("/proc/self/task").iterdir()))

    threads = count()
    write_replay(made_up_flight(), tmp_path / "replay.html")
    with pytest.raises(ValueError, match="no sample"):
        write_replay(made_up_flight(**{name: np.empty(0) for name in array_names()}), tmp_path / "empty.html")
    deadline = perf_counter() + 5.0
    while count() > threads and perf_counter() < deadline:
        sleep(0.01)
    assert count() <= threads
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
        ["mission.ship_start=[0, -500]", "airframe.arm_length=2", "airframe.tilt_deg=0"],
        ["mpc.period=0.03", "mission.duration=0.001", "link.antenna_offset=[0, 0, 0]"],
    ],
)
def test_any_scenario_can_be_replayed(overrides: list[str], tmp_path: Path) -> None:
    made_up = made_up_flight()
    flight = dataclasses.replace(made_up, scenario=made_up.scenario.with_overrides(overrides))
    write_replay(flight, tmp_path / "a.html")
    assert (tmp_path / "a.html").stat().st_size > 2e6


def test_an_observer_sees_each_sample_and_changes_nothing() -> None:
    scenario = load_scenario("paper").with_value("simulation.duration", 0.3)
    diagram, seen = build_link_only(scenario), []
    watched = run_flight(diagram, scenario, observer=seen.append, target_realtime_rate=1.0)
    unwatched = run_flight(diagram, scenario)
    assert watched.wall_clock.total >= 0.29
    assert len(seen) == len(watched.time)
    for name in array_names():
        np.testing.assert_array_equal(getattr(watched, name), getattr(unwatched, name))
        for row, sample in enumerate(seen):
            np.testing.assert_array_equal(sample[name], watched.sample(row)[name])


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
    def end(*_: object) -> None:
        raise FlightEnded("it broke", made_up_flight())

    monkeypatch.setattr(common, "fly", end)
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
    common.keep_serving()
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
