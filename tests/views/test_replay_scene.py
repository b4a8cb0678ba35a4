"""What stands where on the replay's page: read back from the page, and compared with the flight's log."""

import dataclasses
import io
from collections.abc import Iterator
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from playwright.sync_api import Browser, Page
from pydrake.math import RollPitchYaw

from a2s_drake import Flight, rotor_table, run_flight, wrench_map
from a2s_drake.views.replay import Scene, start_meshcat, write_replay
from a2s_drake.views.replay.gauge import LETTER, gauge_scale
from diagrams import build_link_only, load_scenario

ROOT = ""
WORLD = "/drake/world_seen_from_vehicle"
VEHICLE = f"{WORLD}/vehicle"
SHIP = f"{WORLD}/ship_sized_by_its_antenna"
SEA = f"{WORLD}/sea"
RAYS = f"{WORLD}/rays_widened_with_distance"
PATH = f"{WORLD}/path_so_far"
GAUGE = "/drake/gauge/size"

# Nothing stands at zero or runs along an axis, so that no sign and no order of coordinates can be wrong unnoticed.
ASKEW = ["mission.start=[3, -2, 5]", "mission.sea_level=-12", "mission.ship_start=[90, 10]"]
ASKEW += ["mission.ship_end=[75, 30]", "link.antenna_offset=[0.39, 0.2, 0.3]", "link.ship_antenna_height=7"]
SEA_LEVEL, OFFSET, MAST = -12.0, np.array([0.39, 0.2, 0.3]), np.array([0.0, 0.0, 7.0])


@pytest.fixture(scope="module")
def flight() -> Flight:
    """A whole mission held exactly, with rotors that turn at a made-up speed."""
    scenario = load_scenario("paper").with_overrides(ASKEW).validate()
    held = run_flight(build_link_only(scenario), scenario)
    return dataclasses.replace(held, rotor_speed=np.full((len(held.time), 6), 60.0))


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


@pytest.fixture(params=[0, 300, 1101, 1998, 2000])
def row(paused: Page, request: pytest.FixtureRequest) -> int:
    """A row of the flight, at whose time the page stands."""
    seek(paused, request.param * 0.02)
    return request.param


def seek(page: Page, time: float) -> None:
    page.evaluate("time => viewer.animator.seek(time)", time)


def world_matrices(page: Page, *paths: str) -> list[np.ndarray]:
    """The 4x4 transforms from objects of the page, by their paths, to the page."""
    script = """paths => paths.map(path => {
        const thing = viewer.scene_tree.find(path.split('/').slice(1)).object;
        thing.updateWorldMatrix(true, false);
        return thing.matrixWorld.elements;
    })"""
    return [np.reshape(elements, (4, 4)).T for elements in page.evaluate(script, paths)]


def pose(page: Page, path: str, base: str = WORLD) -> np.ndarray:
    """The 4x4 transform from an object of the page to another, `base`; both by their paths."""
    of_base, of_path = world_matrices(page, base, path)
    return np.linalg.inv(of_base) @ of_path


def all_vertices(page: Page, paths: list[str], base: str) -> list[np.ndarray]:
    """The vertices, each of shape (n, 3), of the meshes and lines put at some paths, in the frame of `base`."""
    script = """paths => paths.map(path => Array.from(
        viewer.scene_tree.find(path.split('/').slice(1)).object.geometry.attributes.position.array))"""
    objects = [f"{path}/<object>" for path in paths]
    of_base, *of_objects = world_matrices(page, base, *objects)
    numbers = page.evaluate(script, objects)
    transforms = [np.linalg.inv(of_base) @ X for X in of_objects]
    return [np.reshape(p, (-1, 3)) @ X[:3, :3].T + X[:3, 3] for p, X in zip(numbers, transforms, strict=True)]


def vertices(page: Page, path: str, base: str = WORLD) -> np.ndarray:
    return all_vertices(page, [path], base)[0]


def pieces(page: Page, path: str, base: str) -> list[np.ndarray]:
    """The vertices of each object right under a path, in the order of their names."""
    names = page.evaluate("path => Object.keys(viewer.scene_tree.find(path.split('/').slice(1)).children)", path)
    return all_vertices(page, [f"{path}/{name}" for name in sorted(names) if name != "<object>"], base)


def attitude(flight: Flight, row: int) -> np.ndarray:
    return RollPitchYaw(flight.attitude[row]).ToRotationMatrix().matrix()


def antennas(flight: Flight, row: int) -> tuple[np.ndarray, np.ndarray]:
    """Where the vehicle's antenna and the ship's are in W, by the log."""
    return flight.position[row] + attitude(flight, row) @ OFFSET, flight.ship_position[row] + MAST


def tick_heights(page: Page) -> np.ndarray:
    """The heights of the ticks beside the gauge's bar, which reach farthest to the left of all that frames it."""
    frame = vertices(page, f"{GAUGE}/frame", GAUGE)
    tips = np.sort(frame[np.isclose(frame[:, 0], frame[:, 0].min(), atol=1e-6), 1])
    return tips.reshape(-1, 2).mean(axis=1)


def grid_times(page: Page) -> np.ndarray:
    """Where on the gauge's chart the lines of 0, 10, 20, 30 and 40 s stand."""
    lines = vertices(page, f"{GAUGE}/faint", GAUGE).reshape(-1, 4, 3)
    upright = lines[np.ptp(lines[..., 0], axis=1) < np.ptp(lines[..., 1], axis=1)]
    return np.sort(upright[..., 0].mean(axis=1))


def colors(picture: bytes) -> int:
    """How many colours a PNG shows."""
    pixels = matplotlib.image.imread(io.BytesIO(picture), format="png")
    return len(np.unique(pixels.reshape(-1, pixels.shape[-1]), axis=0))


def test_the_page_plays_and_is_not_blank(replay: Path, open_page) -> None:
    page = open_page(replay, 400, 300)
    page.wait_for_function("viewer.animator.playing && viewer.animator.time > 0.2")
    early = page.evaluate("viewer.animator.time")
    page.wait_for_function("early => viewer.animator.time > early + 0.2", arg=early)
    assert page.evaluate("viewer.animator.duration") == pytest.approx(40.0)
    assert colors(page.screenshot()) > 300


def test_the_vehicle_is_where_it_flew(flight: Flight, paused: Page, row: int) -> None:
    X_WB = pose(paused, VEHICLE)
    np.testing.assert_allclose(X_WB[:3, 3], flight.position[row], atol=1e-5)
    np.testing.assert_allclose(X_WB[:3, :3], attitude(flight, row), atol=1e-5)


def test_the_eye_travels_with_the_vehicle_and_does_not_turn(flight: Flight, paused: Page, row: int) -> None:
    # The camera stands still on the page: so must the vehicle's centre, and the directions of W.
    np.testing.assert_allclose(pose(paused, VEHICLE, ROOT)[:3, 3], np.zeros(3), atol=1e-5)
    np.testing.assert_allclose(pose(paused, WORLD, "/drake")[:3, :3], np.eye(3), atol=1e-12)
    np.testing.assert_allclose(pose(paused, WORLD, "/drake")[:3, 3], -flight.position[row], atol=1e-5)


def test_both_antennas_are_where_the_link_has_them(flight: Flight, paused: Page, row: int) -> None:
    antenna, mast = antennas(flight, row)
    np.testing.assert_allclose(pose(paused, f"{VEHICLE}/antenna/shape")[:3, 3], antenna, atol=1e-5)
    np.testing.assert_allclose(pose(paused, f"{SHIP}/antenna/shape")[:3, 3], mast, atol=1e-4)


def test_the_ship_is_where_it_sailed_bow_first(flight: Flight, paused: Page, row: int) -> None:
    X_WS = pose(paused, SHIP)
    np.testing.assert_allclose(X_WS[:3, 3], flight.ship_position[row], atol=1e-4)
    # From (90, 10) to (75, 30): three steps back for four to the left.
    np.testing.assert_allclose(X_WS[:3, :3], [[-0.6, -0.8, 0.0], [0.8, -0.6, 0.0], [0.0, 0.0, 1.0]], atol=1e-6)
    bow, wake = vertices(paused, f"{SHIP}/hull", SHIP)[:, 0].max(), vertices(paused, f"{SHIP}/wake_port", SHIP)
    assert bow > 0.0 > wake[:, 0].max()


@pytest.mark.usefixtures("row")
def test_the_sea_is_at_its_level(paused: Page) -> None:
    surface = vertices(paused, f"{SEA}/surface")
    assert surface[:, 2].max() == pytest.approx(SEA_LEVEL, abs=1e-4)
    assert surface[:, :2].min() < -1000.0
    assert surface[:, :2].max() > 1000.0
    grid = vertices(paused, f"{SEA}/grid_of_10_m")
    np.testing.assert_allclose(grid[:, 2], SEA_LEVEL + 0.2, atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(np.diff(grid.reshape(-1, 2, 3), axis=1), axis=-1), 10.0, atol=1e-4)


def test_the_rays_join_the_antennas_by_the_law_of_reflection(flight: Flight, paused: Page, row: int) -> None:
    # The ends of each ray's drawing, which is one long before it is scaled.
    ends = np.array([[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]]).T
    rays = ("direct", "down_to_sea", "up_from_sea")
    direct, down, up = ((pose(paused, f"{RAYS}/{name}/length") @ ends)[:3].T for name in rays)
    antenna, mast = antennas(flight, row)
    mark = pose(paused, f"{RAYS}/specular_point")[:3, 3]
    np.testing.assert_allclose(direct, [antenna, mast], atol=2e-4)
    np.testing.assert_allclose(down, [antenna, mark], atol=2e-4)
    np.testing.assert_allclose(up, [mark, mast], atol=2e-4)
    assert mark[2] == pytest.approx(SEA_LEVEL, abs=2e-4)
    into, out = (ray / np.linalg.norm(ray) for ray in (mark - antenna, mast - mark))
    np.testing.assert_allclose(out, into * [1.0, 1.0, -1.0], atol=2e-5)


def test_needle_and_bar_read_the_snr_by_the_gauges_own_ticks(flight: Flight, paused: Page, row: int) -> None:
    ticks_db = gauge_scale(flight.scenario).ticks_db()
    needle, bar = (vertices(paused, f"{GAUGE}/{name}", GAUGE) for name in ("needle", "bar/height"))
    tip = needle[np.argmin(needle[:, 0])]
    for height in (tip[1], bar[:, 1].max()):
        assert np.interp(height, tick_heights(paused), ticks_db) == pytest.approx(flight.snr_db[row], abs=2e-3)
    assert bar[:, 1].min() == pytest.approx(tick_heights(paused)[0], abs=1e-6)


def test_the_curve_is_the_snr_over_time(flight: Flight, paused: Page) -> None:
    ticks_db, x_of_time = gauge_scale(flight.scenario).ticks_db(), grid_times(paused)
    points = []
    for corners in pieces(paused, f"{GAUGE}/curve", GAUGE):
        # A stroke's corners go around it, and it runs on past both of its ends by half its width.
        start, end = (corners[0] + corners[3]) / 2.0, (corners[1] + corners[2]) / 2.0
        past = np.linalg.norm(corners[3] - corners[0]) / 2.0 * (end - start) / np.linalg.norm(end - start)
        points.append([start + past, end - past])
    x, height = np.array(points)[..., 0], np.array(points)[..., 1]
    time = np.interp(x, x_of_time, [0.0, 10.0, 20.0, 30.0, 40.0])
    snr_db = np.interp(height, tick_heights(paused), ticks_db)
    assert 200 < len(points) <= 250
    assert (time[0, 0], time[-1, 1]) == (pytest.approx(0.0, abs=1e-3), pytest.approx(40.0, abs=1e-3))
    np.testing.assert_allclose(time[1:, 0], time[:-1, 1], atol=1e-3)
    rows = np.rint(time / 0.02).astype(int)
    np.testing.assert_allclose(snr_db, flight.snr_db[rows], atol=2e-3)


def test_the_path_so_far_is_the_path_flown(flight: Flight, paused: Page) -> None:
    rings = np.array(pieces(paused, PATH, WORLD)).reshape(-1, 2, 5, 3)
    ends = rings.mean(axis=2)
    assert 200 < len(ends) <= 250
    np.testing.assert_allclose(ends[0, 0], flight.position[0], atol=1e-5)
    np.testing.assert_allclose(ends[-1, 1], flight.position[-1], atol=1e-5)
    np.testing.assert_allclose(ends[1:, 0], ends[:-1, 1], atol=1e-5)
    off = np.linalg.norm(ends[:, 1, np.newaxis] - flight.position, axis=-1).min(axis=1)
    np.testing.assert_allclose(off, 0.0, atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(rings - ends[:, :, np.newaxis], axis=-1), 0.01, atol=1e-5)


def test_the_reference_path_is_the_circle_of_the_mission(paused: Page) -> None:
    line = vertices(paused, f"{WORLD}/reference_path")
    from_centre = line - np.array([3.0 - 2.65, -2.0, 5.0])
    np.testing.assert_allclose(np.linalg.norm(from_centre[:, :2], axis=1), 2.65, atol=1e-5)
    np.testing.assert_allclose(from_centre[:, 2], 0.0, atol=1e-5)
    around = np.unwrap(np.arctan2(from_centre[:, 1], from_centre[:, 0]))
    assert np.ptp(around) == pytest.approx(2.0 * np.pi, abs=1e-4)


def test_path_and_curve_grow_with_time(paused: Page) -> None:
    script = """path => Object.values(viewer.scene_tree.find(path.split('/').slice(1)).children)
        .filter(child => child.object.visible).length"""
    counts = []
    for time in (0.0, 10.0, 20.0, 39.9, 40.0):
        seek(paused, time)
        counts.append([paused.evaluate(script, path) for path in (PATH, f"{GAUGE}/curve")])
    counted = np.array(counts)
    assert list(counted[0]) == [0, 0]
    assert np.all(np.diff(counted, axis=0) >= 0)
    assert np.all(counted[1:4] > np.array([[50], [100], [210]]))
    assert np.all(counted[-1] <= 251)


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


def test_the_gauges_heading_stands_clear_of_its_topmost_label(paused: Page) -> None:
    words, top = vertices(paused, f"{GAUGE}/words", GAUGE)[:, 1], tick_heights(paused)[-1]
    rows = np.unique(words[words > top])  # of the label's upper half and of the heading; empty ones leave a step
    assert np.diff(rows).max() > LETTER / 2.0


def test_one_sample_without_rotors_makes_a_still_picture(tmp_path: Path, open_page) -> None:
    scenario = load_scenario("paper")
    one = run_flight(build_link_only(scenario), scenario.with_value("simulation.duration", 1e-4))
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
    assert meshcat.HasPath(f"{PATH}/0001")
    assert not meshcat.HasPath(f"{PATH}/0002")
