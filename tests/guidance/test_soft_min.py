import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff

from a2s_drake import AttitudeLaw, AttitudeReference, Link, attitude_reference
from a2s_drake.guidance.soft_min import affine_phase, nearest_fringe, soft_min
from a2s_drake.link.two_ray import antenna_position, channel_gain, path_lengths, phase_difference, spectral_efficiency

UAV, SHIP = np.zeros(3), np.array([90.0, 0.0, -20.0])
BOX = math.radians(15.0)

coordinates = st.tuples(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), st.floats(-3.0, 3.0)).map(np.array)
ships = st.tuples(st.floats(60.0, 300.0), st.floats(-100.0, 100.0)).map(lambda xy: np.array([*xy, -20.0]))
ranges = st.floats(0.02, 1.0)


def exact_phase(position: np.ndarray, eta: np.ndarray, ship: np.ndarray, link: Link) -> float:
    return float(phase_difference(*path_lengths(antenna_position(position, eta, link), ship, link), link))


def soft_min_by_the_book(offsets: list[float], norm: float, temperature: float) -> float:
    """Lemma 1 as a plain sum, in exact-enough arithmetic for moderate temperatures."""
    weights = [math.exp(-temperature * (offset / norm) ** 2) for offset in offsets]
    return math.fsum(w * c for w, c in zip(weights, offsets, strict=True)) / math.fsum(weights)


def test_golden_numbers_at_the_start_of_the_mission() -> None:
    phase, k = affine_phase(UAV, SHIP, Link())
    assert phase == pytest.approx(274.915520076, abs=5e-10)
    np.testing.assert_allclose(k, [5.060628505, -4.494897910, -1.131461190], atol=5e-10)
    assert nearest_fringe(phase) == 43
    assert 87.0 * math.pi - phase == pytest.approx(-1.596959214, abs=5e-10)
    eta = attitude_reference(UAV[np.newaxis], SHIP[np.newaxis], Link(), AttitudeLaw(), BOX)[0]
    np.testing.assert_allclose(np.rad2deg(eta), [-9.832248, 8.733095, 2.198305], atol=5e-7)


@given(coordinates, ships)
def test_sensitivity_is_the_gradient_of_the_exact_phase(position: np.ndarray, ship: np.ndarray) -> None:
    _, k = affine_phase(position, ship, Link())
    step = 1e-5
    expected = [
        (exact_phase(position, step * e, ship, Link()) - exact_phase(position, -step * e, ship, Link())) / (2.0 * step)
        for e in np.eye(3)
    ]
    np.testing.assert_allclose(k, expected, atol=2e-6)


@given(coordinates, ships)
def test_candidate_is_the_smallest_attitude_on_its_hyperplane(position: np.ndarray, ship: np.ndarray) -> None:
    # With an infinite temperature and a box that holds it, the law returns the nearest fringe's candidate (Theorem 1).
    law = AttitudeLaw(candidate_limit_deg=180.0, temperature=1e6, index_min=-200, index_max=200)
    phase, k = affine_phase(position, ship, Link())
    eta = attitude_reference(position[np.newaxis], ship[np.newaxis], Link(), law, BOX)[0]
    distance = (2 * nearest_fringe(phase) + 1) * math.pi - phase
    if abs(abs(distance) - math.pi) < 1e-3:
        return  # Half-way between two fringes the soft-min has no single winner.
    assert k @ eta == pytest.approx(distance, abs=1e-6)
    np.testing.assert_allclose(np.cross(k, eta), 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("law", "gain"),
    [("nearest", 44.9), ("index_zero", 44.5), ("zero", 16.2)],
)
def test_ideal_tracking_of_table_i(law: str, gain: float, reference_geometry) -> None:
    position, ship = reference_geometry

    def throughput(eta: np.ndarray) -> float:
        rays = path_lengths(antenna_position(position, eta, Link()), ship, Link())
        return 0.02 * float(spectral_efficiency(channel_gain(*rays, Link()), Link()).sum())

    level = throughput(np.zeros_like(position))
    assert level == pytest.approx(122.387, abs=5e-4)
    eta = attitude_reference(position, ship, Link(), AttitudeLaw(fallback=law), BOX)
    assert 100.0 * (throughput(eta) / level - 1.0) == pytest.approx(gain, abs=0.05)


@pytest.mark.parametrize(("name", "share"), [("three_axis", 0.285), ("pitch_only", 0.629)])
def test_feasible_set_of_table_i_is_often_empty(name: str, share: float, reference_geometry) -> None:
    # Where `zero` and `nearest` differ, no candidate was feasible.
    zero, nearest = (
        attitude_reference(*reference_geometry, Link(), AttitudeLaw(name=name, fallback=fallback), BOX)
        for fallback in ("zero", "nearest")
    )
    assert (zero != nearest).any(axis=1).mean() == pytest.approx(share, abs=0.001)


@given(st.lists(st.floats(-6.0, 6.0), min_size=1, max_size=8), st.floats(2.0, 10.0), st.floats(0.1, 20.0))
def test_soft_min_is_lemma_1(offsets: list[float], norm: float, temperature: float) -> None:
    dut = soft_min(np.array([offsets]), np.array([norm]), np.ones((1, len(offsets)), dtype=bool), temperature)
    assert dut[0] == pytest.approx(soft_min_by_the_book(offsets, norm, temperature), abs=1e-9)


@given(st.floats(0.1, 1.0), st.lists(st.floats(1.1, 6.0), max_size=5), st.sampled_from([-1.0, 1.0]))
def test_soft_min_tends_to_the_smallest_as_temperature_grows(smallest: float, others: list[float], sign: float) -> None:
    offsets = np.array([[*others, sign * smallest]])
    feasible = np.ones_like(offsets, dtype=bool)
    errors = [abs(soft_min(offsets, np.ones(1), feasible, tau)[0] - sign * smallest) for tau in (1.0, 1e2, 1e5)]
    assert errors[2] <= 1e-12
    assert errors[1] <= errors[0] + 1e-12


def test_soft_min_ignores_infeasible_candidates_at_any_temperature() -> None:
    offsets, feasible = np.array([[0.0, 3.0, 4.0]]), np.array([[False, True, True]])
    assert soft_min(offsets, np.ones(1), feasible, 1e5)[0] == pytest.approx(3.0)


def test_ties_give_the_centroid_of_the_minimisers() -> None:
    offsets = np.array([[-math.pi, math.pi, 3.0 * math.pi]])
    assert soft_min(offsets, np.ones(1), np.ones((1, 3), dtype=bool), 50.0)[0] == pytest.approx(0.0, abs=1e-12)


def empty_geometry() -> tuple[np.ndarray, np.ndarray]:
    """A geometry of the mission in which no candidate lies within 15 deg."""
    position, ship = np.array([[-1.0, 2.5, 0.0]]), np.array([[93.0, 0.0, -20.0]])
    for x in np.arange(93.0, 100.0, 0.05):
        ship[0, 0] = x
        zero = attitude_reference(position, ship, Link(), AttitudeLaw(fallback="zero"), BOX)
        if not zero.any():
            return position, ship
    raise AssertionError("no such geometry")


def test_empty_set_falls_back_to_level_under_zero() -> None:
    eta = attitude_reference(*empty_geometry(), Link(), AttitudeLaw(fallback="zero"), BOX)
    np.testing.assert_array_equal(eta, 0.0)


@pytest.mark.parametrize("fallback", ["nearest", "index_zero"])
def test_empty_set_falls_back_to_a_clipped_candidate(fallback: str) -> None:
    position, ship = empty_geometry()
    phase, k = affine_phase(position[0], ship[0], Link())
    index = int(nearest_fringe(phase)) if fallback == "nearest" else 0
    candidate = ((2 * index + 1) * math.pi - phase) * k / np.dot(k, k)
    eta = attitude_reference(position, ship, Link(), AttitudeLaw(fallback=fallback), BOX)[0]
    np.testing.assert_allclose(eta, np.clip(candidate, -BOX, BOX), atol=1e-12)
    assert np.abs(candidate).max() > BOX


def test_clip_uses_the_attitude_box_and_feasibility_the_candidate_box() -> None:
    position, ship = empty_geometry()
    wide = attitude_reference(position, ship, Link(), AttitudeLaw(candidate_limit_deg=30.0, temperature=1e5), BOX)
    narrow = attitude_reference(position, ship, Link(), AttitudeLaw(candidate_limit_deg=1.0), math.radians(5.0))
    assert np.abs(wide).max() > BOX  # a feasible candidate is not clipped
    assert np.abs(narrow).max() == pytest.approx(math.radians(5.0))


def test_a_little_sensitivity_is_enough() -> None:
    link = Link(antenna_offset=[1e-6, 1e-6, 0.0])
    eta = attitude_reference(UAV[np.newaxis], SHIP[np.newaxis], link, AttitudeLaw(), BOX)
    assert np.abs(eta).max() == pytest.approx(BOX)


@pytest.mark.parametrize("fallback", ["nearest", "zero", "index_zero"])
def test_without_sensitivity_the_law_stays_level(fallback: str) -> None:
    # An antenna at the centre of mass cannot be moved by turning.
    link = Link(antenna_offset=[0.0, 0.0, 0.0])
    eta = attitude_reference(UAV[np.newaxis], SHIP[np.newaxis], link, AttitudeLaw(fallback=fallback), BOX)
    np.testing.assert_array_equal(eta, 0.0)


def test_pitch_only_without_pitch_sensitivity_stays_level() -> None:
    # Rays in the y-z plane and an antenna on the roll axis: pitch moves the antenna across both rays.
    link, ship = Link(antenna_offset=[0.0, 0.4, 0.0]), np.array([[0.0, 90.0, -20.0]])
    eta = attitude_reference(UAV[np.newaxis], ship, link, AttitudeLaw(name="pitch_only"), BOX)
    np.testing.assert_array_equal(eta, 0.0)


@given(coordinates, ships)
def test_pitch_only_turns_nothing_but_pitch(position: np.ndarray, ship: np.ndarray) -> None:
    law = AttitudeLaw(name="pitch_only", candidate_limit_deg=180.0, temperature=1e6, index_min=-200, index_max=200)
    eta = attitude_reference(position[np.newaxis], ship[np.newaxis], Link(), law, BOX)[0]
    phase, k = affine_phase(position, ship, Link())
    distance = (2 * nearest_fringe(phase) + 1) * math.pi - phase
    assert eta[0] == eta[2] == 0.0
    if abs(abs(distance) - math.pi) > 1e-3 and abs(distance / k[1]) < math.pi:
        assert k[1] * eta[1] == pytest.approx(distance, abs=1e-6)


@given(coordinates, ships)
def test_level_is_level(position: np.ndarray, ship: np.ndarray) -> None:
    eta = attitude_reference(position[np.newaxis], ship[np.newaxis], Link(), AttitudeLaw(name="level"), BOX)
    np.testing.assert_array_equal(eta, 0.0)


def evaluate(dut: AttitudeReference, position: np.ndarray, ship: np.ndarray, port: str) -> np.ndarray:
    context = dut.CreateDefaultContext()
    dut.GetInputPort("position_preview").FixValue(context, position.ravel())
    dut.GetInputPort("ship_preview").FixValue(context, ship.ravel())
    return dut.GetOutputPort(port).Eval(context)


def test_block_on_the_reference_path_is_the_offline_reference(reference_geometry) -> None:
    position, ship = (rows[700:731] for rows in reference_geometry)
    dut = AttitudeReference(Link(), AttitudeLaw(), BOX, 30)
    expected = attitude_reference(position, ship, Link(), AttitudeLaw(), BOX)
    np.testing.assert_array_equal(evaluate(dut, position, ship, "attitude_preview").reshape(31, 3), expected)
    np.testing.assert_array_equal(evaluate(dut, position, ship, "attitude_reference"), expected[0])


def test_block_answers_to_either_input_alone(reference_geometry) -> None:
    position, ship = (rows[:2] for rows in reference_geometry)
    dut = AttitudeReference(Link(), AttitudeLaw(), BOX, 1)
    context = dut.CreateDefaultContext()
    ports = [dut.GetOutputPort(name) for name in ("attitude_reference", "attitude_preview")]
    seen = []
    for name, values in (("position_preview", position), ("ship_preview", ship), ("ship_preview", ship + 0.3)):
        dut.GetInputPort(name).FixValue(context, values.ravel())
        if name == "ship_preview":
            seen.append([port.Eval(context).copy() for port in ports])
    dut.GetInputPort("position_preview").FixValue(context, position.ravel() + 0.1)
    seen.append([port.Eval(context).copy() for port in ports])
    for before, after in pairwise(seen):
        assert all((b != a).any() for b, a in zip(before, after, strict=True))


GEOMETRIES = [("three_axis", "nearest", 0), ("three_axis", "zero", 300), ("pitch_only", "nearest", 0)]
GEOMETRIES += [("level", "zero", 0)] + [("three_axis", fallback, 545) for fallback in ("nearest", "zero", "index_zero")]


@pytest.mark.parametrize(("name", "fallback", "row"), GEOMETRIES)
def test_block_differentiates_by_both_inputs(name: str, fallback: str, row: int, reference_geometry) -> None:
    point = np.concatenate([rows[row : row + 2].ravel() for rows in reference_geometry])
    dut = AttitudeReference(Link(), AttitudeLaw(name=name, fallback=fallback), BOX, 1)

    def reference(block: AttitudeReference, inputs: np.ndarray) -> np.ndarray:
        return evaluate(block, inputs[:6], inputs[6:], "attitude_preview")

    step = 1e-6
    columns = [reference(dut, point + step * e) - reference(dut, point - step * e) for e in np.eye(12)]
    expected = np.column_stack(columns) / (2.0 * step)
    result = reference(dut.ToAutoDiffXd(), InitializeAutoDiff(point).ravel())
    np.testing.assert_allclose(ExtractValue(result).ravel(), reference(dut, point))
    gradient = ExtractGradient(result)
    if gradient.size == 0:  # constants (level, or clipped on every axis) carry no derivatives
        gradient = np.zeros((6, 12))
    np.testing.assert_allclose(gradient, expected, atol=1e-6 * max(1.0, np.abs(expected).max()))


@pytest.mark.parametrize("fallback", ["nearest", "zero", "index_zero"])
def test_block_differentiates_without_sensitivity(fallback: str, reference_geometry) -> None:
    position, ship = (rows[:2] for rows in reference_geometry)
    dut = AttitudeReference(Link(antenna_offset=[0.0, 0.0, 0.0]), AttitudeLaw(fallback=fallback), BOX, 1).ToAutoDiffXd()
    taped = InitializeAutoDiff(np.concatenate([position.ravel(), ship.ravel()])).ravel()
    assert (ExtractValue(evaluate(dut, taped[:6], taped[6:], "attitude_preview")) == 0.0).all()
