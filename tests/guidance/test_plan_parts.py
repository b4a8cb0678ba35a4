import itertools

import numpy as np
import pytest
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff

from a2s_drake import Link, Scenario
from a2s_drake.guidance.path import uav_path
from a2s_drake.guidance.plan.certificate import certify
from a2s_drake.guidance.plan.limits import Limits
from a2s_drake.guidance.plan.search import AttitudeGrid, Caution, _advance, rounded, search
from a2s_drake.guidance.plan.segment import Segment, Task
from a2s_drake.guidance.plan.spline import AttitudeSpline, SplineGrid
from a2s_drake.link.throughput import efficiency_derivatives
from a2s_drake.link.two_ray import antenna_position, channel_gain, path_lengths, spectral_efficiency
from a2s_drake.study.ceiling import is_hoverable, throughput_of
from a2s_drake.world.ship import ship_track


@pytest.fixture
def task() -> Task:
    """Three seconds of a small circle."""
    scenario = Scenario().with_overrides(["mission.duration=3.0", "mission.radius=0.05"]).validate()
    return Task.of(scenario)


@pytest.fixture
def control(task: Task, rng: np.random.Generator) -> np.ndarray:
    return task.grid.rested(0.1 * rng.standard_normal((task.grid.controls, 3)).cumsum(axis=0) / 3.0)


def test_efficiency_derivatives(rng: np.random.Generator) -> None:
    position, ship = rng.uniform(-3.0, 3.0, (8, 3)), np.tile([90.0, 5.0, -20.0], (8, 1))
    eta = rng.uniform(-0.3, 0.3, (8, 3))
    value, gradient, hessian = efficiency_derivatives(position, ship, eta, Link())
    for row in range(8):
        taped = InitializeAutoDiff(eta[row]).ravel()
        lengths = path_lengths(antenna_position(position[row], taped, Link()), ship[row], Link())
        efficiency = spectral_efficiency(channel_gain(*lengths, Link()), Link())
        assert value[row] == pytest.approx(efficiency.value())
        np.testing.assert_allclose(gradient[row], ExtractGradient(np.array([efficiency])).ravel(), rtol=1e-7, atol=1e-7)
    for axis, step in enumerate(1e-6 * np.eye(3)):
        after, before = (efficiency_derivatives(position, ship, eta + sign * step, Link())[1] for sign in (1, -1))
        difference = (after - before) / 2e-6
        np.testing.assert_allclose(hessian[:, axis], difference, atol=1e-6 * np.abs(hessian).max())


def test_grid_and_spline_agree(rng: np.random.Generator) -> None:
    grid = SplineGrid.of(7.0, 0.3)
    assert grid.intervals == 24
    spline = AttitudeSpline(7.0, rng.standard_normal((grid.controls, 3)))
    time = np.append(rng.uniform(0.0, 7.0, 50), [0.0, grid.spacing, 7.0])
    for order, values in enumerate((spline.eta, spline.rate, spline.acceleration)):
        np.testing.assert_allclose(grid.matrix(time, order) @ spline.control, values(time), atol=1e-9)
    step = 1e-5
    np.testing.assert_allclose(
        (spline.eta(time[:-3] + step) - spline.eta(time[:-3] - step)) / (2.0 * step), spline.rate(time[:-3]), atol=1e-5
    )


def test_rested_control_points_start_level_and_start_and_end_at_rest(control: np.ndarray, task: Task) -> None:
    spline = AttitudeSpline(task.grid.duration, control)
    np.testing.assert_allclose(spline.eta(np.array(0.0)), 0.0, atol=1e-12)
    np.testing.assert_allclose(spline.rate(np.array([0.0, 3.0])), 0.0, atol=1e-12)


def test_bending_is_the_integral_of_the_squared_acceleration(control: np.ndarray, task: Task) -> None:
    spline, grid = AttitudeSpline(task.grid.duration, control), task.grid
    shape = control[np.arange(grid.intervals)[:, None] + np.arange(4)]
    time = (np.arange(60_000) + 0.5) * 3.0 / 60_000
    expected = (spline.acceleration(time) ** 2).sum() * 3.0 / 60_000
    assert np.einsum("kid,ij,kjd->", shape, grid.bending(), shape) == pytest.approx(expected, rel=1e-6)


def test_throughput_is_that_of_the_channel(control: np.ndarray, task: Task) -> None:
    mission, time = task.scenario.mission, task.scenario.samples_until(task.grid.duration)
    eta = AttitudeSpline(task.grid.duration, control).eta(time)
    expected = throughput_of(uav_path(mission).position(time), eta, ship_track(mission).position(time), Link(), 0.02)
    assert Segment(task).throughput(control) == pytest.approx(expected)


def test_cost_gradient_and_limit_slopes(control: np.ndarray, task: Task, rng: np.random.Generator) -> None:
    dut, step = Segment(task), 1e-6
    cost, gradient = dut.cost_gradient(control)
    assert cost == pytest.approx(dut.cost(control))
    slopes = dut.use_slopes(control)
    for direction in rng.standard_normal((5, *control.shape)):
        after, before = control + step * direction, control - step * direction
        assert (dut.cost(after) - dut.cost(before)) / (2.0 * step) == pytest.approx((gradient * direction).sum())
        shape = direction[dut.shape_of_limit].reshape(-1, 12, 1)
        difference = (dut.use(after) - dut.use(before)) / (2.0 * step)
        np.testing.assert_allclose((slopes @ shape)[..., 0], difference, atol=1e-5)


def test_segments_add_up_to_the_whole(control: np.ndarray, task: Task) -> None:
    whole = Segment(task)
    parts = [Segment(task, first, min(first + 7, task.grid.intervals)) for first in range(0, task.grid.intervals, 7)]
    pieces = [control[part.first : part.last + 3] for part in parts]
    total = sum(part.cost(piece) for part, piece in zip(parts, pieces, strict=True))
    assert total == pytest.approx(whole.cost(control))
    used = np.vstack([part.use(piece) for part, piece in zip(parts, pieces, strict=True)])
    np.testing.assert_allclose(used, whole.use(control))


def test_one_stage_of_the_search_is_the_best_of_all_moves(rng: np.random.Generator) -> None:
    value = rng.standard_normal((4, 4, 4))
    moves, prices = [0, -1, 1, -2, 2], [0.0, 0.3, 0.3, 0.9, 0.9]
    best, origin = _advance(value, moves, prices)
    for place in itertools.product(range(4), repeat=3):
        offers = {}
        for turn in itertools.product(range(5), repeat=3):
            start = tuple(here - moves[index] for here, index in zip(place, turn, strict=True))
            if all(0 <= there < 4 for there in start):
                offers[start] = value[start] - sum(prices[index] for index in turn)
        assert best[place] == pytest.approx(max(offers.values()))
        assert offers[tuple(map(int, np.unravel_index(origin[place], value.shape)))] == pytest.approx(best[place])


def test_search_keeps_to_rates_and_hoverable_attitudes(task: Task) -> None:
    time, path = search(task, Caution())
    assert not path[0].any()
    assert is_hoverable(path, task.scenario.airframe).all()
    assert np.abs(np.diff(path, axis=0)).max() <= task.limits.rate * (time[1] - time[0]) * (1.0 + 1e-9)
    assert np.abs(path).max() <= task.limits.angle


def test_no_random_walk_beats_the_search(task: Task, rng: np.random.Generator) -> None:
    scenario, limits = task.scenario, task.limits
    time, path = search(task, Caution(turning_price=0.0))
    position, ship = uav_path(scenario.mission).position(time), ship_track(scenario.mission).position(time)
    won = throughput_of(position[1:], path[1:], ship[1:], Link(), 1.0)
    step = limits.rate * (time[1] - time[0]) / task.planning.search_reach
    for _ in range(200):
        walk = np.cumsum(step * rng.integers(-2, 3, path.shape), axis=0)
        walk -= walk[0]
        near = np.clip(walk, -8.0 * step, 8.0 * step)
        if is_hoverable(near, scenario.airframe).all():
            assert throughput_of(position[1:], near[1:], ship[1:], Link(), 1.0) <= won


def test_rounding_stays_close_to_a_gentle_path(task: Task) -> None:
    time = np.linspace(0.0, 3.0, 61)
    path = 0.05 * np.stack([1.0 - np.cos(np.pi * time / 3.0)] * 3, axis=-1)
    spline = AttitudeSpline(3.0, rounded(task.grid, time, path))
    np.testing.assert_allclose(spline.eta(time), path, atol=2e-3)
    np.testing.assert_allclose(spline.rate(np.array([0.0, 3.0])), 0.0, atol=1e-9)


def test_margins_come_off_the_scenarios_limits() -> None:
    limits = Limits.of(Scenario())
    assert (np.sqrt(limits.input_low), np.sqrt(limits.input_high)) == (16.5, 99.5)
    assert np.degrees(limits.angle) == pytest.approx(0.995 * 15.0)
    assert limits.rate == pytest.approx(0.99)
    with pytest.raises(ValueError, match=r"rotor_speed_min_margin = 50\.0"):
        Limits.of(Scenario().with_value("planning.rotor_speed_min_margin", 50.0))


def test_certificate_of_level_hover() -> None:
    dut = certify(AttitudeSpline(3.0, np.zeros((33, 3))), Scenario().with_value("mission.radius", 0.0), 200.0)
    assert dut.holds
    assert dut.rotor_speed_min == pytest.approx(61.69, abs=0.01)
    assert dut.rotor_speed_max == pytest.approx(61.69, abs=0.01)
    assert dut.angular_velocity_max == dut.attitude_max_deg == dut.rest_error == 0.0


@pytest.mark.parametrize(
    ("limit", "angle", "period"),
    [
        ("attitude", [0.0, 0.0, 0.28], 6.0),
        ("angular_velocity", [0.0, 0.0, 0.2], 0.5),
        ("rotor_speed_min", [0.0, 0.24, 0.0], 6.0),
        ("rotor_speed_max", [0.0, 0.25, 0.0], 0.3),
    ],
)
def test_certificate_catches_each_limit(task: Task, limit: str, angle: list[float], period: float) -> None:
    time = np.linspace(0.0, 3.0, 61)
    path = np.sin(np.pi * time / period)[:, np.newaxis] ** 2 * np.array(angle)
    grid = SplineGrid.of(3.0, 0.05)
    control = grid.rested(np.asarray(np.linalg.lstsq(grid.matrix(time).toarray(), path, rcond=None)[0]))
    dut = certify(AttitudeSpline(3.0, control), task.scenario, 200.0)
    assert not dut.holds
    assert dut.margins[limit] < 0.0


def test_certificate_and_planner_agree_on_what_is_used(control: np.ndarray, task: Task) -> None:
    # By finite differences and Drake's inverse dynamics on one side, by the flat map on the other.
    dut = certify(AttitudeSpline(3.0, 0.3 * control), task.scenario, 2000.0)
    use = Segment(task).use(0.3 * control)
    middle, half = (99.5**2 + 16.5**2) / 2.0, (99.5**2 - 16.5**2) / 2.0
    assert dut.rotor_speed_max**2 == pytest.approx(middle + half * use[:, 6:].max(), rel=5e-3)
    assert dut.angular_velocity_max == pytest.approx(0.99 * np.abs(use[:, 3:6]).max(), rel=5e-3)
    assert dut.attitude_max_deg == pytest.approx(0.995 * 15.0 * np.abs(use[:, :3]).max(), rel=5e-3)


@pytest.mark.parametrize("limit", [1.0, 0.3, 0.05])
def test_the_slower_the_vehicle_may_turn_the_longer_the_stages(limit: float) -> None:
    task = Task.of(Scenario().with_overrides([f"mpc.angular_velocity_limit={limit}"]))
    dut = AttitudeGrid(task, Caution())
    assert dut.side <= 20
    assert dut.step * dut.reach <= 0.99 * limit * dut.period * (1.0 + 1e-9)
    assert dut.stages * dut.period == pytest.approx(40.0)
    assert (dut.stages == 800) == (limit == 1.0)
