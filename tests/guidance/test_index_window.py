"""Which fringes the attitude law weighs: all of its window that lie in the box, and none else."""

import math
from dataclasses import replace

import numpy as np
import pytest

from a2s_drake import AttitudeLaw, Link, attitude_reference
from a2s_drake.guidance.soft_min import affine_phase, nearest_fringe

UAV, SHIP = np.zeros((1, 3)), np.array([[90.0, 0.0, -20.0]])  # between the fringes 42 and 44, next to 43
BOX = math.radians(15.0)


def law_by_the_book(position: np.ndarray, ship: np.ndarray, law: AttitudeLaw) -> np.ndarray | None:
    """Lemma 1 over every index of the window, one by one; None where no candidate is feasible."""
    phase, k = affine_phase(position, ship, Link())
    weighted, weights = np.zeros(3), 0.0
    for m in range(law.index_min, law.index_max + 1):
        candidate = ((2 * m + 1) * math.pi - float(phase)) * k / (k @ k)
        if np.abs(candidate).max() <= math.radians(law.candidate_limit_deg):
            weight = math.exp(-law.temperature * (candidate @ candidate))
            weighted, weights = weighted + weight * candidate, weights + weight
    return weighted / weights if weights else None


@pytest.mark.parametrize("limit_deg", [10.0, 25.0, 60.0, 170.0, math.inf])
@pytest.mark.parametrize("window", [(-50, 50), (42, 44), (43, 50), (44, 60), (0, 42), (41, 41)])
def test_the_law_weighs_the_feasible_fringes_of_its_window(window: tuple[int, int], limit_deg: float, rng) -> None:
    low, high = window
    law = AttitudeLaw(candidate_limit_deg=limit_deg, index_min=low, index_max=high, temperature=0.7, fallback="zero")
    # Several samples at once, since one range of indices serves them all.
    position = rng.uniform(-3.0, 3.0, (20, 3))
    ship = SHIP + rng.uniform(0.0, 10.0, (20, 1)) * [1.0, 0.0, 0.0]
    together = attitude_reference(position, ship, Link(), law, BOX)
    for row in range(20):
        expected = law_by_the_book(position[row], ship[row], law)
        np.testing.assert_allclose(together[row], 0.0 if expected is None else expected, atol=1e-12)


@pytest.mark.parametrize("outside", ["index_max", "index_min"])
def test_the_nearest_fringe_of_the_window_stands_in_where_none_is_feasible(outside: str) -> None:
    phase, k = affine_phase(UAV[0], SHIP[0], Link())
    nearest = int(nearest_fringe(phase))
    allowed = nearest - 3 if outside == "index_max" else nearest + 3
    window = {"index_min": allowed - 2, "index_max": allowed + 2, outside: allowed}
    eta = attitude_reference(UAV, SHIP, Link(), AttitudeLaw(candidate_limit_deg=1.0, **window), 10.0)[0]
    np.testing.assert_allclose(eta, ((2 * allowed + 1) * math.pi - phase) * k / (k @ k), rtol=1e-12)


def test_the_law_steers_down_to_a_billionth_of_phase_per_angle() -> None:
    _, k = affine_phase(UAV[0], SHIP[0], Link(antenna_offset=[1e-6, 1e-6, 0.0]))
    for norm, largest in ((0.9e-9, 0.0), (1.1e-9, BOX)):
        offset = 1e-6 * norm / np.linalg.norm(k)
        link = Link(antenna_offset=[offset, offset, 0.0])
        eta = attitude_reference(UAV, SHIP, link, AttitudeLaw(), BOX)
        assert np.abs(eta).max() == pytest.approx(largest)


@pytest.mark.parametrize("name", ["three_axis", "pitch_only", "level"])
def test_one_position_may_meet_many_ships(name: str) -> None:
    ships = SHIP + np.outer(np.linspace(0.0, 1.0, 4), [1.0, 0.0, 0.0])
    law = replace(AttitudeLaw(), name=name)
    many = attitude_reference(UAV[0], ships, Link(), law, BOX)
    assert many.shape == (4, 3)
    for row, ship in enumerate(ships):
        np.testing.assert_allclose(many[row], attitude_reference(UAV[0], ship, Link(), law, BOX), atol=1e-14)
