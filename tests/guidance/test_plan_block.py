import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Flight, Mpc, Scenario, ScenarioError, attitude_reference, compute_metrics, run_flight
from a2s_drake.common.wiring import find_block
from a2s_drake.flight.feasible import check
from a2s_drake.flight.metrics import position_error
from a2s_drake.guidance.path import uav_path
from a2s_drake.guidance.plan import cache
from a2s_drake.guidance.plan.block import PlannedReference
from a2s_drake.guidance.plan.cache import SOURCES, kept_plan, load_plan, plan_file, plan_key
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.vehicle.rigid_body import RigidBodyModel
from diagrams import build_closed_loop, build_link_only, load_scenario
from scripts import simulate
from tests.support.markdown import ROOT

SMALL = ["mission.duration=3.0", "mission.radius=0.05", "planning.ipopt_iterations=0"]


@pytest.fixture(scope="module")
def small() -> Scenario:
    """Three seconds of a small circle, which take a second to plan."""
    return load_scenario("planned").with_overrides(SMALL).validate()


@pytest.fixture
def spline(rng: np.random.Generator) -> AttitudeSpline:
    return AttitudeSpline(2.0, 0.1 * rng.standard_normal((13, 3)))


@pytest.mark.parametrize("time", [0.0, 0.37, 1.7, 5.0])
def test_block_serves_the_plan_along_the_preview(time: float, spline: AttitudeSpline, scenario: Scenario) -> None:
    dut = PlannedReference(spline, scenario.airframe, scenario.mission, scenario.mpc)
    context = dut.CreateDefaultContext()
    context.SetTime(time)
    ahead = dut.GetOutputPort("attitude_preview").Eval(context).reshape(-1, 3)
    assert len(ahead) == 31
    for k in (0, 1, 30):
        np.testing.assert_array_equal(ahead[k], spline.eta(np.array(time + 0.02 * k)))
    np.testing.assert_array_equal(dut.GetOutputPort("attitude_reference").Eval(context), ahead[0])


@pytest.mark.parametrize("time", [0.0, 0.37, 1.1])
def test_what_the_block_previews_belongs_together(time: float, spline: AttitudeSpline, scenario: Scenario) -> None:
    """The controller's model of the vehicle, fed the previewed inputs, flies what else is previewed."""
    mission = replace(scenario.mission, duration=2.0, radius=0.05)
    gentle = AttitudeSpline(2.0, 0.3 * spline.control)
    dut = PlannedReference(gentle, scenario.airframe, mission, scenario.mpc)
    context = dut.CreateDefaultContext()
    context.SetTime(time)
    names = ("attitude_preview", "velocity_preview", "angular_velocity_preview")
    attitude, velocity, rate = (dut.GetOutputPort(name).Eval(context).reshape(-1, 3) for name in names)
    inputs = dut.GetOutputPort("rotor_speed_squared_preview").Eval(context).reshape(-1, 6)
    position = uav_path(mission).position(time + 0.02 * np.arange(31))
    start = np.concatenate([position[0], attitude[0], velocity[0], rate[0]])
    x = RigidBodyModel.of(scenario.airframe).rollout(start, inputs, 0.02)
    np.testing.assert_allclose(x[:, 3:6], attitude, atol=2e-3)
    np.testing.assert_allclose(x[:, 9:], rate, atol=2e-2)
    np.testing.assert_allclose(x[:, 6:9], velocity, atol=1e-2)
    np.testing.assert_allclose(x[:, :3], position, atol=3e-3)


def test_block_depends_on_time_alone(spline: AttitudeSpline, scenario: Scenario) -> None:
    dut = PlannedReference(spline, scenario.airframe, scenario.mission, scenario.mpc)
    assert not dut.HasAnyDirectFeedthrough()


def test_a_plan_is_made_once(small: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = kept_plan(small, folder=tmp_path)
    monkeypatch.setattr(cache, "plan_attitude", lambda *_: pytest.fail("planned again"))
    again = kept_plan(small, folder=tmp_path)
    assert again.duration == first.duration
    np.testing.assert_array_equal(again.control, first.control)


def test_a_damaged_plan_is_made_again(small: Scenario, tmp_path: Path) -> None:
    first = kept_plan(small, folder=tmp_path)
    plan_file(small, tmp_path).write_bytes(b"damaged")
    with pytest.warns(UserWarning, match="is damaged and is made again"):
        again = kept_plan(small, folder=tmp_path)
    np.testing.assert_array_equal(again.control, first.control)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ({"control": np.zeros((33, 2))}, r"control points are float64 of shape \(33, 2\)"),
        ({"control": np.full((33, 3), np.nan)}, "must be finite"),
        ({"duration": 2.0}, "holds no plan for 3 s, but for 2 s"),
        ({"key": "another"}, "holds a plan for another scenario"),
        ({}, "holds no plan: key is missing"),
    ],
)
def test_a_file_without_the_plan_is_refused(content: dict, reason: str, small: Scenario, tmp_path: Path) -> None:
    right = {"key": plan_key(small), "duration": 3.0, "control": np.zeros((33, 3))}
    np.savez(tmp_path / "plan.npz", **(right | content if content else {"control": right["control"]}))
    with pytest.raises(ValueError, match=reason):
        load_plan(tmp_path / "plan.npz", small)


def imports(module: Path) -> set[Path]:
    """The modules of this package that a module imports."""
    found = set()
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("a2s_drake"):
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            found |= {ROOT / f"{name.replace('.', '/')}.py" for name in names}
    return {path for path in found if path.exists()}


def test_a_plan_goes_by_every_module_that_makes_it() -> None:
    todo, seen = {ROOT / "a2s_drake" / "guidance" / "plan" / "plan.py"}, set()
    while todo:
        seen |= todo
        todo = set().union(*map(imports, todo)) - seen
    assert len(seen) > 20
    assert seen <= set(SOURCES)


def test_a_plan_that_cannot_be_kept_is_flown_all_the_same(small: Scenario, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.warns(UserWarning, match="cannot be kept"):
        assert kept_plan(small, folder=tmp_path / "file").duration == 3.0


def test_a_plan_cut_short_is_flown_but_not_kept(small: Scenario, tmp_path: Path) -> None:
    with pytest.warns(UserWarning, match=r"cut short after 0 s, with \+0.00 % over level; this plan is not kept"):
        spline = kept_plan(small, folder=tmp_path, time_limit=0.0)
    assert not spline.control.any()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("override", "same"),
    [
        ("mpc.position_weight=7", True),
        ("attitude_law.fallback=zero", True),
        ("disturbance.mass_factor=1.1", True),
        ("link.carrier_hz=1e9", False),
        ("airframe.mass=2.5", False),
        ("mission.radius=0.04", False),
        ("planning.knot_spacing=0.2", False),
        ("mpc.attitude_limit_deg=14", False),
        ("mpc.angular_velocity_limit=2", False),
        ("mpc.period=0.01", False),
        ("mpc.feedforward=false", True),
    ],
)
def test_a_plan_is_found_by_all_that_it_depends_on(override: str, same: bool, small: Scenario) -> None:
    assert (plan_file(small.with_overrides([override])) == plan_file(small)) == same


def test_plans_are_kept_in_the_users_cache(small: Scenario, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert plan_file(small).parent == tmp_path / "a2s_drake" / "plans"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert plan_file(small).parent == Path.home() / ".cache" / "a2s_drake" / "plans"


def test_ideal_tracking_of_the_plan_is_the_plan(small: Scenario) -> None:
    flight = run_flight(build_link_only(small, plan=kept_plan(small)), small)
    np.testing.assert_array_equal(flight.attitude, kept_plan(small).eta(flight.time))


def attitude_off(flight: Flight) -> float:
    """Largest deviation from the plan on any axis, deg."""
    return float(np.rad2deg(np.abs(flight.attitude - kept_plan(flight.scenario).eta(flight.time)).max()))


def test_closed_loop_follows_the_plan_under_the_papers_weights(small: Scenario) -> None:
    assert small.mpc == Mpc()
    flight = run_flight(build_closed_loop(small, plan=kept_plan(small)), small)
    assert attitude_off(flight) < 0.15
    assert position_error(flight).max() < 1e-3
    assert flight.solver_success.all()


def test_without_feedforward_rates_and_inputs_are_pulled_to_zero(small: Scenario) -> None:
    scenario = small.with_overrides(["mpc.feedforward=false"]).validate()
    dut = build_closed_loop(scenario, plan=kept_plan(scenario))
    assert find_block(dut, "mpc").num_input_ports() == 3
    flight = run_flight(dut, scenario)
    assert attitude_off(flight) > 1.0
    assert position_error(flight).max() > 0.01


def test_the_papers_law_is_not_asked_for_a_plan(scenario: Scenario) -> None:
    law = scenario.with_value("attitude_law.name", "planned").attitude_law
    with pytest.raises(ValueError, match="a plan depends on time"):
        attitude_reference(np.zeros(3), np.array([90.0, 0.0, -20.0]), scenario.link, law, scenario.mpc.attitude_limit)


def test_a_planned_mission_needs_no_window_of_fringes() -> None:
    far = ["attitude_law.index_max=10"]
    assert check(load_scenario("planned").with_overrides(far))
    with pytest.raises(ScenarioError, match="index_max"):
        check(load_scenario("paper").with_overrides(far))


def test_simulate_plans_and_flies(tmp_path: Path, capsys) -> None:
    assert simulate.main(["planned", "--set", *SMALL, "--duration", "0.2", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().out.startswith("planned: ")


def test_simulate_settles_for_the_best_plan_in_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    asked = ["planned", "--set", *SMALL, "--duration", "0.2", "--out", str(tmp_path), "--plan-within", "0"]
    with pytest.warns(UserWarning, match="cut short"):
        assert simulate.main(asked) == 0
    assert not Flight.load(tmp_path).attitude_reference.any()
    assert not (tmp_path / "cache").exists()


def test_a_flight_to_a_plan_cut_short_is_flown_again_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    first, again = tmp_path / "first", tmp_path / "again"
    with pytest.warns(UserWarning, match="cut short"):
        simulate.main(["planned", "--set", *SMALL, "--duration", "0.2", "--out", str(first), "--plan-within", "0.4"])
    assert simulate.main([str(first / "scenario.yaml"), "--out", str(again)]) == 0
    assert (again / "flight.npz").read_bytes() == (first / "flight.npz").read_bytes()
    assert not (tmp_path / "cache").exists()
    # Another mission than the plan beside the scenario is for gets a plan of its own.
    other = ["--set", "mission.radius=0.04", "--plan-within", "0", "--out", str(tmp_path / "other")]
    with pytest.warns(UserWarning, match="cut short after 0 s"):
        assert simulate.main([str(first / "scenario.yaml"), *other]) == 0


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["planned", "--plan-within", "-1"], "--plan-within -1.0: must be at least 0"),
        (["planned", "--plan-within", "nan"], "--plan-within nan: must be at least 0"),
        (["planned", "--set", "planning.rotor_speed_min_margin=60"], "planning.rotor_speed_min_margin = 60"),
        (["paper", "--plan-within", "5"], "--plan-within: the law three_axis makes no plan"),
        (["planned", "--set", "mpc.feedforward=maybe"], "mpc.feedforward = 'maybe': must be true or false"),
        (
            ["planned", "--set", "airframe.tilt_deg=0.0"],
            "airframe.tilt_deg = 0.0: these rotors cannot make every wrench",
        ),
        (
            ["planned", "--set", "planning.search_period=0.01", "mission.duration=5000"],
            "planning.search_period = 0.01: ",
        ),
    ],
)
def test_simulate_refuses_in_one_line(arguments: list[str], reason: str, refuses) -> None:
    refuses(simulate, arguments, reason)


@pytest.mark.slow
def test_table_i_flown_to_its_plan(fly) -> None:
    flight, level = fly("planned"), fly("paper", "attitude_law.name=level")
    metrics = compute_metrics(flight)
    gain = metrics["throughput_bit_per_hz"] / compute_metrics(level)["throughput_bit_per_hz"] - 1.0
    assert 100.0 * gain == pytest.approx(39.0, abs=0.1)
    assert metrics["position_error_max_m"] < 1e-3
    assert metrics["solver"]["failures"] == 0
    assert all(bound["worst_excess"] == 0.0 for bound in metrics["bounds"].values())
