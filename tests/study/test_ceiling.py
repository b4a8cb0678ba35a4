import math

import numpy as np
import pytest

from a2s_drake import Airframe, Link, Scenario, wrench_map
from a2s_drake.link.two_ray import antenna_position, channel_gain, path_lengths
from a2s_drake.study import ceiling
from a2s_drake.study.ceiling import affine_phase_error, best_attitude, is_hoverable, throughput_of

BOX = math.radians(15.0)


def gain_of(position: np.ndarray, eta: np.ndarray, ship: np.ndarray) -> np.ndarray:
    return channel_gain(*path_lengths(antenna_position(position, eta, Link()), ship, Link()), Link())


def share_won(reference_geometry, eta: np.ndarray) -> float:
    position, ship = reference_geometry
    mine, level = (throughput_of(position, e, ship, Link(), 0.02) for e in (eta, np.zeros_like(eta)))
    return 100.0 * (mine / level - 1.0)


def test_exact_best_attitude_in_the_box_of_table_i(reference_geometry) -> None:
    position, ship = reference_geometry
    best = best_attitude(position, ship, Link(), BOX)
    assert np.abs(best).max() <= BOX
    assert share_won(reference_geometry, best) == pytest.approx(45.6, abs=0.1)


@pytest.mark.parametrize(("refinements", "gain"), [(0, 42.9), (12, 43.24)])
def test_best_hoverable_attitude_of_table_i(refinements: int, gain: float, reference_geometry, monkeypatch) -> None:
    # An independent search gave +42.9 %, which is what a grid of 1.5 deg finds. The optimum lies between its points.
    monkeypatch.setattr(ceiling, "_REFINEMENTS", refinements)
    position, ship = reference_geometry

    def allowed(eta: np.ndarray) -> np.ndarray:
        return is_hoverable(eta, Airframe())

    best = best_attitude(position, ship, Link(), BOX, allowed)
    assert allowed(best).all()
    assert share_won(reference_geometry, best) == pytest.approx(gain, abs=0.02)


def test_no_random_attitude_beats_the_best(reference_geometry, rng: np.random.Generator) -> None:
    position, ship = (rows[::100] for rows in reference_geometry)
    best = gain_of(position, best_attitude(position, ship, Link(), BOX), ship)
    for _ in range(300):
        assert (gain_of(position, rng.uniform(-BOX, BOX, position.shape), ship) <= best * (1.0 + 1e-9)).all()


def test_no_random_hoverable_attitude_beats_the_best_one(reference_geometry, rng: np.random.Generator) -> None:
    position, ship = (rows[::100] for rows in reference_geometry)
    best = best_attitude(position, ship, Link(), BOX, lambda eta: is_hoverable(eta, Airframe()))
    ceiling = gain_of(position, best, ship)
    for _ in range(1000):
        eta = rng.uniform(-BOX, BOX, position.shape)
        gain = np.where(is_hoverable(eta, Airframe()), gain_of(position, eta, ship), 0.0)
        assert (gain <= ceiling * (1.0 + 1e-3)).all()


def test_hover_is_limited_by_the_lower_rotor_bound_at_eleven_degrees_of_pitch() -> None:
    pitch = np.deg2rad(np.array([0.0, 5.0, 11.0, 11.5, 15.0]))
    eta = np.stack([np.zeros(5), pitch, np.zeros(5)], axis=-1)
    assert is_hoverable(eta, Airframe()).tolist() == [True, True, True, False, False]
    assert is_hoverable(eta, Airframe(rotor_speed_min=0.0)).tolist() == [True, True, True, True, False]


def test_hoverable_means_a_wrench_balance_within_the_rotor_speeds(rng: np.random.Generator) -> None:
    # The balance solved by least squares with a plain rotation matrix, at random attitudes.
    for eta in rng.uniform(-0.4, 0.4, (50, 3)):
        (cr, cp), (sr, sp) = np.cos(eta[:2]), np.sin(eta[:2])
        up_B = np.array([-sp, sr * cp, cr * cp])
        wrench = np.concatenate([2.57 * 9.81 * up_B, np.zeros(3)])
        u = np.linalg.lstsq(wrench_map(Airframe()), wrench, rcond=None)[0]
        assert is_hoverable(eta, Airframe()) == ((u >= 256.0) & (u <= 1e4)).all()


def test_affine_error_vanishes_with_the_box(reference_geometry) -> None:
    position, ship = (rows[:3] for rows in reference_geometry)
    antenna = position + np.array([0.39, 0.39, 0.195])
    heights = (np.array([0.0, 0.0, 10.0]), np.array([0.0, 0.0, -10.0]))
    d_los, d_ref = (np.linalg.norm(ship + height - antenna, axis=1) for height in heights)
    level = 2.0 * np.pi / Link().wavelength * (d_ref - d_los)
    error = affine_phase_error(position, ship, Link(), 1e-9, lambda eta: np.tile(level[:, None], (1, eta.shape[1])))
    assert error.shape == (3, 26)
    assert np.abs(error).max() < 1e-6


def test_throughput_is_the_sum_over_samples() -> None:
    position, ship = np.zeros((3, 3)), np.tile([90.0, 0.0, -20.0], (3, 1))
    once = throughput_of(position[:1], position[:1], ship[:1], Link(), 0.02)
    assert throughput_of(position, position, ship, Link(), 0.02) == pytest.approx(3.0 * once)
    assert once == pytest.approx(0.02 * math.log2(1.0 + 1e9 * 1.199032629e-8))


def test_default_box_is_the_scenarios() -> None:
    assert Scenario().mpc.attitude_limit == pytest.approx(BOX)
