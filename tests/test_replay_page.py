"""The page that a replay is, read back from the browser that plays it."""

import dataclasses
import io
from collections.abc import Iterator
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from playwright.sync_api import Browser, Page
from scipy.spatial.transform import Rotation

from a2s_drake import Flight, rotor_table, run_flight, wrench_map
from a2s_drake.flight import array_names
from a2s_drake.replay import Scene, start_meshcat, write_replay
from a2s_drake.replay.gauge import BOTTOM, CHART, TOP, gauge_scale
from a2s_drake.rotations import rotation_matrix
from a2s_drake.two_ray import antenna_position
from diagrams import build_link_only, load_scenario

WORLD = "/drake/world_seen_from_vehicle"
VEHICLE = f"{WORLD}/vehicle"
RAYS = f"{WORLD}/rays_widened_with_distance"
SHIP = f"{WORLD}/ship_sized_by_its_antenna"
GAUGE = "/drake/gauge/size"
BAR = f"{GAUGE}/bar"
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


def test_the_file_of_a_mission_is_small_and_the_same_again(flight: Flight, replay: Path, tmp_path: Path) -> None:
    page = replay.read_text()
    assert len(page) < 6e6
    assert "<title>a2s_drake: three_axis, 40 s</title>" in page
    write_replay(flight, tmp_path / "again.html")
    assert (tmp_path / "again.html").read_text() == page


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


ROWS = (0, 300, 1101, 1998)


def test_the_antennas_stand_where_the_link_has_them(flight: Flight, paused: Page) -> None:
    r_a = [0.39, 0.39, 0.195]  # Table I
    assert flight.scenario.link.antenna_offset == r_a
    for row in ROWS:
        seek(paused, row * 0.02)
        roll, pitch, yaw = flight.attitude[row]
        p_BA_W = Rotation.from_euler("ZYX", [yaw, pitch, roll]).apply(r_a)
        np.testing.assert_allclose(pose(paused, f"{VEHICLE}/antenna")[:3, 3], flight.position[row] + p_BA_W, atol=1e-5)
        on_ship = pose(paused, f"{SHIP}/antenna")[:3, 3]
        np.testing.assert_allclose(on_ship, flight.ship_position[row] + [0.0, 0.0, 10.0], atol=1e-4)


def test_the_ship_is_under_way_along_its_track(flight: Flight, paused: Page) -> None:
    track = flight.ship_position[-1] - flight.ship_position[0]
    for row in ROWS:
        seek(paused, row * 0.02)
        X_WS = pose(paused, SHIP)
        np.testing.assert_allclose(X_WS[:3, 3], flight.ship_position[row], atol=1e-4)
        np.testing.assert_allclose(X_WS[:3, 0], track / np.linalg.norm(track), atol=1e-6)
        np.testing.assert_allclose(X_WS[:3, 2], [0.0, 0.0, 1.0], atol=1e-6)


def test_the_reflection_is_marked_on_the_sea(paused: Page) -> None:
    np.testing.assert_allclose(pose(paused, f"{WORLD}/sea")[2, 2:], [1.0, -20.0], atol=1e-5)
    for row in ROWS:
        seek(paused, row * 0.02)
        antenna, mast = (pose(paused, f"{place}/antenna")[:3, 3] for place in (VEHICLE, SHIP))
        mark = pose(paused, f"{RAYS}/specular_point")[:3, 3]
        # By similar triangles: as far from either antenna as it stands high.
        share = (antenna[2] + 20.0) / (antenna[2] + 20.0 + mast[2] + 20.0)
        np.testing.assert_allclose(mark[:2], antenna[:2] + share * (mast - antenna)[:2], atol=1e-3)
        assert mark[2] == pytest.approx(-20.0, abs=1e-4)


def test_the_eye_travels_with_the_vehicle(flight: Flight, paused: Page) -> None:
    for row in ROWS:
        seek(paused, row * 0.02)
        np.testing.assert_allclose(pose(paused, VEHICLE, "/drake")[:3, 3], np.zeros(3), atol=1e-5)
        np.testing.assert_allclose(pose(paused, WORLD, "/drake")[:3, 3], -flight.position[row], atol=1e-5)


def test_the_needle_stands_at_the_snr(flight: Flight, paused: Page) -> None:
    for row in ROWS:
        seek(paused, row * 0.02)
        height = pose(paused, f"{GAUGE}/needle", GAUGE)[1, 3]
        assert on_scale(flight, height) == pytest.approx(flight.snr_db[row], abs=0.01)


def on_scale(flight: Flight, height: np.ndarray) -> np.ndarray:
    """What a height on the gauge reads, dB."""
    scale = gauge_scale(flight.scenario)
    return scale.low_db + (height - BOTTOM) / (TOP - BOTTOM) * (scale.high_db - scale.low_db)


def middles(page: Page, path: str) -> np.ndarray:
    """The middle of each of the pieces that a line is drawn in, in their order, in the line's frame."""
    script = """path => {
        const pieces = viewer.scene_tree.find(path.split('/').slice(1)).children;
        return Object.keys(pieces).sort().map(name => {
            let points;
            pieces[name].object.traverse(thing => points ??= thing.geometry?.attributes.position);
            const sum = [0, 0, 0];
            for (let i = 0; i < points.count; ++i)
                [points.getX(i), points.getY(i), points.getZ(i)].forEach((value, axis) => sum[axis] += value);
            return sum.map(value => value / points.count);
        });
    }"""
    return np.array(page.evaluate(script, path))


def test_the_path_is_drawn_where_it_was_flown(flight: Flight, paused: Page) -> None:
    pieces = middles(paused, f"{WORLD}/path_so_far")
    assert len(pieces) > 200
    away = np.linalg.norm(pieces[:, np.newaxis] - flight.position, axis=-1)
    assert away.min(axis=1).max() < 0.02
    assert np.all(np.diff(away.argmin(axis=1)) > 0)


def test_the_curve_is_the_snr_over_time(flight: Flight, paused: Page) -> None:
    across, height, _ = middles(paused, f"{GAUGE}/curve").T
    time = 40.0 * (across - CHART[0]) / (CHART[1] - CHART[0])
    assert time[0] < 0.2
    assert time[-1] > 39.8
    off = np.abs(on_scale(flight, height) - np.interp(time, flight.time, flight.snr_db))
    assert np.median(off) < 0.02
    assert off.max() < 2.5  # a chord of 0.16 s across a fade


def test_a_long_flight_makes_no_larger_file(flight: Flight, tmp_path: Path) -> None:
    often = np.tile(np.arange(2001), 15)
    arrays = {name: getattr(flight, name)[often] for name in array_names()} | {"time": 0.02 * np.arange(len(often))}
    scenario = flight.scenario.with_value("simulation.duration", 600.0)
    write_replay(dataclasses.replace(flight, scenario=scenario, **arrays), tmp_path / "long.html")
    assert (tmp_path / "long.html").stat().st_size < 6e6


def test_the_path_grows_with_time(paused: Page) -> None:
    script = """path => Object.values(viewer.scene_tree.find(path.split('/').slice(1)).children)
        .filter(child => child.object.visible).length"""
    counts = []
    for time in (0.0, 10.0, 20.0, 39.9, 40.0):
        seek(paused, time)
        counts.append([paused.evaluate(script, path) for path in (f"{WORLD}/path_so_far", f"{GAUGE}/curve")])
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
