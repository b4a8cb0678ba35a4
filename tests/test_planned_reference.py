from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Scenario, ScenarioError, attitude_reference, compute_metrics, run_flight
from a2s_drake.planned import keep
from a2s_drake.planned.keep import kept_plan, plan_file
from a2s_drake.planned.reference import PlannedReference
from a2s_drake.planned.spline import AttitudeSpline
from diagrams import build_closed_loop, build_link_only, load_scenario
from scripts import simulate

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
    dut = PlannedReference(spline, scenario.mpc)
    context = dut.CreateDefaultContext()
    context.SetTime(time)
    ahead = dut.GetOutputPort("attitude_preview").Eval(context).reshape(-1, 3)
    assert len(ahead) == 31
    for k in (0, 1, 30):
        np.testing.assert_array_equal(ahead[k], spline.eta(np.array(time + 0.02 * k)))
    np.testing.assert_array_equal(dut.GetOutputPort("attitude_reference").Eval(context), ahead[0])


def test_block_hangs_on_time_alone(spline: AttitudeSpline, scenario: Scenario) -> None:
    dut = PlannedReference(spline, scenario.mpc)
    assert not dut.HasAnyDirectFeedthrough()


def test_a_plan_is_made_once(small: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = kept_plan(small, folder=tmp_path)
    monkeypatch.setattr(keep, "plan_attitude", lambda *_: pytest.fail("planned again"))
    again = kept_plan(small, folder=tmp_path)
    assert again.duration == first.duration
    np.testing.assert_array_equal(again.control, first.control)


def test_a_damaged_plan_is_made_again(small: Scenario, tmp_path: Path) -> None:
    first = kept_plan(small, folder=tmp_path)
    plan_file(small, tmp_path).write_bytes(b"damaged")
    with pytest.warns(UserWarning, match="is damaged and is made again"):
        again = kept_plan(small, folder=tmp_path)
    np.testing.assert_array_equal(again.control, first.control)


def test_a_plan_that_cannot_be_kept_is_flown_all_the_same(small: Scenario, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.warns(UserWarning, match="cannot be kept"):
        assert kept_plan(small, folder=tmp_path / "file").duration == 3.0


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
    ],
)
def test_a_plan_goes_by_all_that_it_hangs_on(override: str, same: bool, small: Scenario) -> None:
    assert (plan_file(small.with_overrides([override])) == plan_file(small)) == same


def test_plans_are_kept_in_the_users_cache(small: Scenario, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert plan_file(small).parent == tmp_path / "a2s_drake" / "plans"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert plan_file(small).parent == Path.home() / ".cache" / "a2s_drake" / "plans"


def test_ideal_tracking_of_the_plan_is_the_plan(small: Scenario) -> None:
    flight = run_flight(build_link_only(small), small)
    np.testing.assert_array_equal(flight.attitude, kept_plan(small).eta(flight.time))


def test_closed_loop_follows_the_plan(small: Scenario) -> None:
    flight = run_flight(build_closed_loop(small), small)
    off = np.abs(flight.attitude - kept_plan(small).eta(flight.time))
    assert np.rad2deg(off.max()) < 0.3
    assert flight.solver_success.all()


def test_the_papers_law_is_not_asked_for_a_plan(scenario: Scenario) -> None:
    law = scenario.with_value("attitude_law.name", "planned").attitude_law
    with pytest.raises(ValueError, match="a plan hangs on time"):
        attitude_reference(np.zeros(3), np.array([90.0, 0.0, -20.0]), scenario.link, law, scenario.mpc.attitude_limit)


def test_a_planned_mission_needs_no_window_of_fringes() -> None:
    far = ["attitude_law.index_max=10"]
    assert load_scenario("planned").with_overrides(far).validate()
    with pytest.raises(ScenarioError, match="index_max"):
        load_scenario("paper").with_overrides(far).validate()


def test_simulate_plans_and_flies(tmp_path: Path, capsys) -> None:
    assert simulate.main(["planned", "--set", *SMALL, "--duration", "0.2", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().out.startswith("planned: ")


def test_simulate_refuses_what_cannot_be_planned(tmp_path: Path, capsys) -> None:
    out = tmp_path / "out"
    margin = "planning.rotor_speed_min_margin=60"
    assert simulate.main(["planned", "--set", margin, "--out", str(out)]) == 2
    error = capsys.readouterr().err
    assert "planning.rotor_speed_min_margin = 60" in error
    assert error.count("\n") == 1
    assert not out.exists()


@pytest.mark.slow
def test_table_i_flown_to_its_plan(fly) -> None:
    flight, level = fly("planned"), fly("paper", "attitude_law.name=level")
    metrics = compute_metrics(flight)
    gain = metrics["throughput_bit_per_hz"] / compute_metrics(level)["throughput_bit_per_hz"] - 1.0
    assert 100.0 * gain == pytest.approx(38.7, abs=0.1)
    assert metrics["position_error_max_m"] < 0.01
    assert metrics["solver"]["failures"] == 0
    assert all(bound["worst_excess"] == 0.0 for bound in metrics["bounds"].values())
