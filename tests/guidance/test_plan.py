import time

import numpy as np
import pytest

from a2s_drake import Scenario
from a2s_drake.guidance.path import uav_path
from a2s_drake.guidance.plan.plan import PlannedAttitude, Progress, plan_attitude
from a2s_drake.guidance.plan.polish import PlanProgram
from a2s_drake.guidance.plan.search import Caution, rounded, search
from a2s_drake.guidance.plan.segment import Segment, Task
from a2s_drake.scenario.checks import ScenarioError
from a2s_drake.study.ceiling import best_attitude, is_hoverable, throughput_of
from a2s_drake.study.ideal_tracking import Geometry, held_gain
from a2s_drake.vehicle.flatness import FlatMap
from a2s_drake.vehicle.rigid_body import RigidBodyModel

QUICK = "planning.ipopt_iterations=0"


def short(*overrides: str) -> Scenario:
    """Eight seconds of a circle small enough for that."""
    window = ["attitude_law.index_min=-500", "attitude_law.index_max=500"]
    base = ["mission.duration=8.0", "mission.radius=0.4", *window]
    return Scenario().with_overrides([*base, *overrides]).validate()


@pytest.fixture(scope="module")
def planned() -> PlannedAttitude:
    return plan_attitude(short(QUICK))


def test_plan_lies_between_level_and_the_best_hoverable_attitude(planned: PlannedAttitude) -> None:
    scenario = short()
    geometry = Geometry.of(scenario)
    best = best_attitude(
        geometry.position, geometry.ship, scenario.link, scenario.mpc.attitude_limit,
        lambda eta: is_hoverable(eta, scenario.airframe),
    )  # fmt: skip
    ceiling = throughput_of(geometry.position, best, geometry.ship, scenario.link, scenario.mpc.period)
    assert planned.level_throughput < planned.throughput < ceiling
    # Of what any hoverable attitude could win, most: the rest is the start from level and the turns between fringes.
    won = planned.throughput - planned.level_throughput
    assert won > 0.7 * (ceiling - planned.level_throughput)


def test_throughput_is_what_it_says(planned: PlannedAttitude) -> None:
    scenario = short()
    geometry = Geometry.of(scenario)
    assert held_gain(scenario, geometry, planned.eta(geometry.time)) == pytest.approx(planned.gain_percent)


def test_plan_is_certified(planned: PlannedAttitude) -> None:
    assert planned.certificate.holds
    assert planned.certificate.samples > 1600
    assert not planned.truncated


def test_the_model_of_the_mpc_follows_the_plan(planned: PlannedAttitude) -> None:
    """Rotor speeds of the flat map, fed to the prediction model without feedback, fly the plan."""
    scenario, period = short(), 0.005
    time = period * np.arange(int(8.0 / period) + 1)
    motion = [planned.spline.eta(time), planned.spline.rate(time), planned.spline.acceleration(time)]
    acceleration = uav_path(scenario.mission).acceleration(time)
    _, u = FlatMap.of(scenario.airframe).needs(np.hstack(motion), acceleration)
    start = np.concatenate([uav_path(scenario.mission).position(time[:1])[0], np.zeros(9)])
    held = (u[1:] + u[:-1]) / 2.0
    x = RigidBodyModel.of(scenario.airframe).rollout(start, held, period)
    np.testing.assert_allclose(x[:, 3:6], planned.eta(time), atol=2e-3)
    np.testing.assert_allclose(x[:, 9:12], planned.angular_velocity(time), atol=2e-2)
    # Nothing holds the position, to which errors of attitude add up twice over.
    np.testing.assert_allclose(x[:, 6:9], uav_path(scenario.mission).velocity(time), atol=3e-2)
    np.testing.assert_allclose(x[:, 0:3], uav_path(scenario.mission).position(time), atol=1e-1)


def test_planning_is_deterministic(planned: PlannedAttitude) -> None:
    np.testing.assert_array_equal(plan_attitude(short(QUICK)).spline.control, planned.spline.control)


def test_ipopt_takes_nothing_away(planned: PlannedAttitude) -> None:
    polished = plan_attitude(short("planning.ipopt_iterations=10"))
    assert polished.iterations["ipopt"] >= 10
    assert polished.throughput >= planned.throughput - 1e-3
    assert polished.certificate.holds


@pytest.mark.slow
def test_ipopt_alone_finds_no_better_plan(planned: PlannedAttitude, monkeypatch: pytest.MonkeyPatch) -> None:
    # Another solver, from the search's own path: the sequential QPs have not settled for a poor local optimum.
    task = Task.of(short(QUICK))
    whole = Segment(task)
    start = rounded(task.grid, *search(task, Caution()))
    monkeypatch.setattr("a2s_drake.guidance.plan.polish._OPTIONS", {})
    alone = PlanProgram(task).solve(start, 100, None, lambda _: None)
    assert whole.excess(alone).max() < 1e-3
    assert 0.99 * planned.throughput < whole.throughput(alone) < 1.001 * planned.throughput


def test_progress_names_every_phase() -> None:
    told: list[Progress] = []
    plan = plan_attitude(short("planning.ipopt_iterations=2"), told.append)
    assert list(dict.fromkeys(step.phase for step in told)) == ["search", "sqp", "ipopt", "certify"]
    throughput = [step.throughput for step in told]
    # The best is that of least cost, in which acceleration has a price of some hundredths of a percent.
    assert np.diff(throughput).min() > -1e-3 * plan.throughput
    assert throughput[-1] > 0.999 * max(throughput)
    assert throughput[0] == plan.level_throughput


def test_without_time_the_plan_is_level() -> None:
    plan = plan_attitude(short(QUICK), time_limit=0.0)
    assert plan.truncated
    assert plan.certificate.holds
    assert plan.throughput == plan.level_throughput
    assert not plan.eta(np.linspace(0.0, 9.0, 10)).any()


def test_cut_short_the_plan_is_the_best_so_far(monkeypatch: pytest.MonkeyPatch) -> None:
    ticks = iter(range(100_000))
    monkeypatch.setattr("a2s_drake.guidance.plan.plan.time.monotonic", lambda: float(next(ticks)))
    plan = plan_attitude(short(QUICK), time_limit=164.0)  # A tick a stage: four steps into the sequential QPs.
    assert plan.truncated
    assert plan.iterations["sqp"] > 0
    assert plan.certificate.holds
    assert plan.throughput > plan.level_throughput


@pytest.mark.slow
def test_time_that_ends_while_certifying_costs_a_share_of_the_plan_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    margins = ["attitude_margin", "angular_velocity_margin", "rotor_speed_min_margin", "rotor_speed_max_margin"]
    scenario = short(QUICK, "planning.limit_spacing=0.1", *(f"planning.{margin}=0.0" for margin in margins))
    told: list[Progress] = []
    whole = plan_attitude(scenario, told.append)
    phases = [step.phase for step in told]
    assert "sqp" in phases[phases.index("certify") :]  # The limits are broken between the instants, at first.
    ticks = iter(range(100_000))
    monkeypatch.setattr("a2s_drake.guidance.plan.plan.time.monotonic", lambda: float(next(ticks)))
    cut = plan_attitude(scenario, time_limit=phases.index("certify") + 2.0)
    assert cut.truncated
    assert cut.certificate.holds
    won = whole.throughput - whole.level_throughput
    assert cut.throughput - cut.level_throughput > 0.5 * won


@pytest.mark.slow
@pytest.mark.parametrize(
    "overrides",
    [
        ["link.carrier_hz=5.8e9"],
        ["mission.ship_start=[1000.0, 0.0]", "mission.ship_end=[1002.0, 0.0]"],
        ["mission.sea_level=-60.0"],
        ["airframe.tilt_deg=35.0", "airframe.thrust_coefficient=9.9e-4", "airframe.drag_to_thrust=0.019"],
        ["link.reflection_magnitude=0.0"],
    ],
)
def test_other_missions_are_certified_and_never_worse_than_level(overrides: list[str]) -> None:
    plan = plan_attitude(short(*overrides, QUICK))
    assert plan.certificate.holds
    assert plan.throughput >= plan.level_throughput


@pytest.mark.slow
def test_margins_of_nothing_are_kept_between_the_instants_too() -> None:
    margins = ["attitude_margin", "angular_velocity_margin", "rotor_speed_min_margin", "rotor_speed_max_margin"]
    none = [f"planning.{margin}=0.0" for margin in margins]
    plan = plan_attitude(short(QUICK, "planning.limit_spacing=0.1", *none))
    assert plan.certificate.holds
    assert plan.throughput > plan.level_throughput


def test_a_path_beyond_the_level_vehicle_is_refused() -> None:
    with pytest.raises(ScenarioError, match=r"mission\.duration = 3\.0"):
        plan_attitude(short("mission.duration=3.0", "mission.radius=0.25", QUICK))


@pytest.mark.slow
def test_plan_of_table_i() -> None:
    began = time.process_time()
    plan = plan_attitude(Scenario())
    assert time.process_time() - began < 60.0  # on one core; about 20
    assert plan.level_throughput == pytest.approx(122.387, abs=1e-3)
    assert plan.gain_percent > 39.5
    assert plan.certificate.holds
    assert min(plan.certificate.margins.values()) > 0.0005
