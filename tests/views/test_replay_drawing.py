"""The gauge's scale and the meshes that the replay is drawn with."""

import numpy as np
import pytest
from pydrake.math import RollPitchYaw

from a2s_drake import Scenario, run_flight
from a2s_drake.views.replay.gauge import gauge_scale, time_ticks
from a2s_drake.views.replay.shapes import GLYPHS, prism, strokes, text, tube
from diagrams import build_link_only, load_scenario


@pytest.mark.parametrize("name", ["paper", "tilt35", "hover"])
def test_the_gauge_holds_every_snr_of_the_mission(name: str) -> None:
    scenario = load_scenario(name).with_value("simulation.duration", 40.0)
    scale = gauge_scale(scenario)
    flown = run_flight(build_link_only(scenario), scenario.with_value("simulation.duration", 4.0))
    assert scale.low_db <= flown.snr_db.min()
    assert flown.snr_db.max() <= scale.high_db
    assert scale.high_db - scale.low_db <= 25.0


@pytest.mark.parametrize("gamma", [0.0, 0.8, 1.0])
@pytest.mark.parametrize("ship", ["[2, 0]", "[-3, 1.5]", "[40, 20]"])
def test_the_gauge_holds_every_snr_whatever_the_attitude(
    ship: str, gamma: float, scenario: Scenario, rng: np.random.Generator
) -> None:
    overrides = [f"mission.ship_start={ship}", f"mission.ship_end={ship}", f"link.reflection_magnitude={gamma}"]
    close = scenario.with_overrides([*overrides, "mission.sea_level=-11"])
    scale, link = gauge_scale(close), close.link
    # Path, rays and SNR by hand, at attitudes of every kind, with the rays in phase and in antiphase.
    n = 5000
    angle = np.pi * (1.0 - np.cos(np.pi * np.linspace(0.0, 1.0, n)))
    centre = 2.65 * np.stack([np.cos(angle) - 1.0, np.sin(angle), 0.0 * angle], axis=1)
    attitudes = (RollPitchYaw(eta).ToRotationMatrix().matrix() for eta in rng.uniform(-np.pi, np.pi, (n, 3)))
    antenna = centre + np.array([R_WB @ link.antenna_offset for R_WB in attitudes])
    foot, mast = np.array([*close.mission.ship_start, -11.0]), np.array([0.0, 0.0, 10.0])
    direct = 1.0 / np.linalg.norm(antenna - foot - mast, axis=1)
    reflected = gamma / np.linalg.norm(antenna - foot + mast, axis=1)
    loudest, faintest = (
        20.0 * np.log10(np.abs(direct + sign * reflected) * link.wavelength / (4.0 * np.pi)) + 90.0  # 10 over -80 dBm
        for sign in (1.0, -1.0)
    )
    assert loudest.max() <= scale.high_db
    assert faintest.min() >= scale.low_db or scale.high_db - scale.low_db >= 40.0  # only fades deeper than 40 dB


def test_the_gauge_ends_where_the_antennas_could_touch(scenario: Scenario) -> None:
    ship = ["mission.ship_start=[0.3, 0]", "mission.ship_end=[0.3, 0]", "mission.sea_level=-10"]
    # One wavelength apart the direct ray has 90 dB - 20 log10(4 pi) = 68.0 dB; the other, of 20 m, adds 0.03 dB.
    assert gauge_scale(scenario.with_overrides(ship)).high_db == 70.0


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
