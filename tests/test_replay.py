import dataclasses
import io
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from playwright.sync_api import Browser, Page

from a2s_drake import Flight, FlightEnded, Scenario, rotor_table, run_flight, wrench_map
from a2s_drake.flight import array_names
from a2s_drake.replay import Scene, start_meshcat, write_replay
from a2s_drake.replay.gauge import BOTTOM, TOP, gauge_scale, time_ticks
from a2s_drake.replay.recording import shown_frames
from a2s_drake.replay.shapes import GLYPHS, prism, strokes, text, tube
from a2s_drake.rotations import rotation_matrix
from a2s_drake.two_ray import antenna_position, path_lengths, specular_point
from diagrams import build_link_only, load_scenario
from scripts import common, simulate
from tests.flights import made_up_flight

WORLD = "/drake/world_seen_from_vehicle"
VEHICLE = f"{WORLD}/vehicle"
RAYS = f"{WORLD}/rays_widened_with_distance"
BAR = "/drake/gauge/size/bar"
SHORT = ["--duration", "0.2", "--set", "mpc.horizon=8"]


@pytest.fixture(scope="module")
def flight() -> Flight:
    """The whole mission held exactly, with rotors that turn at a made-up speed."""
    scenario = load_scenario("paper").validate()
    ideal = run_flight(build_link_only(scenario), scenario)
    return dataclasses.replace(ideal, rotor_speed=np.full((len(ideal.time), 6), 60.0))


@pytest.fixture(scope="module")
def replay(flight: Flight, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("replay") / "replay.html"
    write_replay(flight, path)
    return path


@pytest.fixture(scope="module")
def paused(replay: Path, browser: Browser) -> Iterator[Page]:
    """The replay's page, opened once for all tests that move its clock to and fro."""
    page = browser.new_page(viewport={"width": 300, "height": 200})
    page.goto(replay.as_uri())
    page.evaluate("viewer.animator.pause()")
    yield page
    page.close()


def seek(page: Page, time: float) -> None:
    page.evaluate("time => viewer.animator.seek(time)", time)


def pose(page: Page, path: str, base: str = WORLD) -> np.ndarray:
    """The 4x4 transform from an object of the page to another, `base`; both by their paths."""
    script = """path => {
        const thing = viewer.scene_tree.find(path.split('/').slice(1)).object;
        thing.updateWorldMatrix(true, false);
        return thing.matrixWorld.elements;
    }"""
    of_base, of_path = (np.reshape(page.evaluate(script, place), (4, 4)).T for place in (base, path))
    return np.linalg.inv(of_base) @ of_path


def colors(picture: bytes) -> int:
    """How many colours a PNG shows."""
    pixels = matplotlib.image.imread(io.BytesIO(picture), format="png")
    return len(np.unique(pixels.reshape(-1, pixels.shape[-1]), axis=0))


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
    assert len(shown_frames(864_001, 0.1)) <= 5001


def test_the_file_of_a_mission_is_small_and_the_same_again(flight: Flight, replay: Path, tmp_path: Path) -> None:
    page = replay.read_text()
    assert len(page) < 6e6
    assert "<title>a2s_drake: three_axis, 40 s</title>" in page
    write_replay(flight, tmp_path / "again.html")
    assert (tmp_path / "again.html").read_text() == page


def test_replays_can_be_written_at_the_same_time(tmp_path: Path) -> None:
    paths = [tmp_path / f"{number}.html" for number in range(4)]
    with ThreadPoolExecutor(4) as threads:
        list(threads.map(lambda path: write_replay(made_up_flight(), path), paths))
    assert len({path.read_bytes() for path in paths}) == 1


@pytest.mark.skipif(sys.platform != "linux", reason="counts threads where Linux lists them")
def test_no_server_outlives_the_writing(tmp_path: Path) -> None:
    threads = len(list(Path("/proc/self/task").iterdir()))
    write_replay(made_up_flight(), tmp_path / "replay.html")
    with pytest.raises(ValueError, match="no sample"):
        write_replay(made_up_flight(**{name: np.empty(0) for name in array_names()}), tmp_path / "empty.html")
    assert len(list(Path("/proc/self/task").iterdir())) == threads
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


def test_the_page_plays_and_is_not_blank(replay: Path, open_page) -> None:
    page = open_page(replay, 400, 300)
    page.wait_for_function("viewer.animator.playing && viewer.animator.time > 0.2")
    early = page.evaluate("viewer.animator.time")
    page.wait_for_function("early => viewer.animator.time > early + 0.2", arg=early)
    assert page.evaluate("viewer.animator.duration") == pytest.approx(40.0)
    assert colors(page.screenshot()) > 300


def test_the_page_shows_the_flight(flight: Flight, paused: Page) -> None:
    link, scale = flight.scenario.link, gauge_scale(flight.scenario)
    for row in (0, 300, 1101, 1998, 2000):
        seek(paused, row * 0.02)
        position, eta, ship = (getattr(flight, name)[row] for name in ("position", "attitude", "ship_position"))
        X_WB = pose(paused, VEHICLE)
        np.testing.assert_allclose(X_WB[:3, 3], position, atol=1e-5)
        np.testing.assert_allclose(X_WB[:3, :3], rotation_matrix(eta), atol=1e-5)
        # The ends of each ray's drawing, which is one long before it is stretched.
        ends = np.array([[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]]).T
        drawn = {name: (pose(paused, f"{RAYS}/{name}/length") @ ends)[:3].T for name in ("direct", "down_to_sea")}
        drawn["up_from_sea"] = (pose(paused, f"{RAYS}/up_from_sea/length") @ ends)[:3].T
        antenna = antenna_position(position, eta, link)
        mast = ship + np.array([0.0, 0.0, link.ship_antenna_height])
        np.testing.assert_allclose(drawn["direct"], [antenna, mast], atol=2e-4)
        np.testing.assert_allclose([drawn["down_to_sea"][0], drawn["up_from_sea"][1]], [antenna, mast], atol=2e-4)
        np.testing.assert_allclose(drawn["down_to_sea"][1], drawn["up_from_sea"][0], atol=2e-4)
        assert drawn["down_to_sea"][1, 2] == pytest.approx(-20.0, abs=2e-4)
        height = pose(paused, f"{BAR}/height", BAR)[1, 1] / (TOP - BOTTOM)
        read = scale.low_db + height * (scale.high_db - scale.low_db)
        assert read == pytest.approx(flight.snr_db[row], abs=0.01)


def test_the_rotors_lean_as_they_push(flight: Flight, paused: Page) -> None:
    seek(paused, 12.0)
    forces = wrench_map(flight.scenario.airframe)[:3]
    blades = []
    for i in range(6):
        X_BP = pose(paused, f"{VEHICLE}/rotor_{i}", VEHICLE)
        np.testing.assert_allclose(X_BP[:3, 2], forces[:, i] / np.linalg.norm(forces[:, i]), atol=1e-6)
        turned = pose(paused, f"{VEHICLE}/rotor_{i}/blades_slowed_down", f"{VEHICLE}/rotor_{i}")
        blades.append(np.arctan2(turned[1, 0], turned[0, 0]))
    # 12 s at 60 Hz, a hundred times slower, against the sense of the drag torque.
    sense = -np.sign([rotor.moment_ratio for rotor in rotor_table(flight.scenario.airframe)])
    expected = np.exp(1j * 2.0 * np.pi * 12.0 * 0.6 * sense)
    np.testing.assert_allclose(np.exp(1j * np.array(blades)), expected, atol=0.02)


def test_the_path_grows_with_time(paused: Page) -> None:
    script = """path => Object.values(viewer.scene_tree.find(path.split('/').slice(1)).children)
        .filter(child => child.object.visible).length"""
    counts = []
    for time in (0.0, 10.0, 20.0, 39.9, 40.0):
        seek(paused, time)
        counts.append([paused.evaluate(script, path) for path in (f"{WORLD}/path_so_far", "/drake/gauge/size/curve")])
    counted = np.array(counts)
    assert list(counted[0]) == [0, 0]
    assert np.all(np.diff(counted, axis=0) >= 0)
    assert np.all(counted[1:4] > np.array([[50], [100], [210]]))
    assert np.all(counted[-1] <= 251)


def test_one_sample_without_rotors_makes_a_still_picture(tmp_path: Path, open_page) -> None:
    scenario = load_scenario("paper").with_value("simulation.duration", 1e-4)
    one = run_flight(build_link_only(scenario), scenario)
    assert len(one.time) == 1
    write_replay(one, tmp_path / "one.html")
    page = open_page(tmp_path / "one.html", 400, 300)
    page.wait_for_timeout(300)
    assert colors(page.screenshot()) > 300
    np.testing.assert_allclose(pose(page, VEHICLE)[:3, 3], one.position[0], atol=1e-6)


def test_a_scene_can_be_live(flight: Flight) -> None:
    meshcat = start_meshcat(port=0)
    scene = Scene(meshcat, flight.scenario)
    for row in (0, 500, 1000):
        scene.show(flight.sample(row))
    assert meshcat.HasPath(f"{WORLD}/path_so_far/0001")
    assert not meshcat.HasPath(f"{WORLD}/path_so_far/0002")


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
