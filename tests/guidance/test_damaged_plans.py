"""Kept plans that are damaged or tampered with: they are certified anew, and flown as they were or not at all."""

import dataclasses
import shutil
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Flight, Scenario
from a2s_drake.common.files import DamagedFileError
from a2s_drake.guidance.plan import cache
from a2s_drake.guidance.plan.cache import find_plan, kept_plan, load_plan, plan_file, save_plan
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.study.pool import worker_processes
from diagrams import load_scenario
from scripts import flying, simulate
from tests.guidance.test_plan_block import SMALL
from tests.support.damage import FLIPS, content, encrypted, flip_many, rewrite
from tests.support.flights import made_up_flight


@pytest.fixture(scope="module")
def small() -> Scenario:
    """Three seconds of a small circle, which take a second to plan."""
    return load_scenario("planned").with_overrides(SMALL).validate()


@pytest.fixture
def plan(small: Scenario, tmp_path: Path) -> Path:
    """The file of that scenario's plan."""
    kept = kept_plan(small)
    save_plan(kept, tmp_path / "plan.npz", small)
    return tmp_path / "plan.npz"


def test_a_bit_turned_over_in_a_kept_plan_changes_no_number(
    plan: Path, small: Scenario, rng: np.random.Generator
) -> None:
    def load() -> list[np.ndarray]:
        spline = load_plan(plan, small)
        return [np.array(spline.duration), spline.control]

    same, refused = flip_many(plan, rng, load)
    assert same > 0
    assert refused > FLIPS // 2


@pytest.mark.parametrize("share", np.linspace(0.0, 0.999, 12))
def test_the_beginning_of_a_plan_is_refused(share: float, plan: Path, small: Scenario) -> None:
    plan.write_bytes(plan.read_bytes()[: int(share * plan.stat().st_size)])
    with pytest.raises(DamagedFileError, match=f"^{plan}"):
        load_plan(plan, small)


def test_a_folder_in_the_place_of_a_plan_is_an_error_of_the_system(plan: Path, small: Scenario) -> None:
    plan.unlink()
    plan.mkdir()
    with pytest.raises(IsADirectoryError, match=r"plan\.npz"):
        load_plan(plan, small)


def test_a_plan_off_its_limits_is_not_flown(plan: Path, small: Scenario) -> None:
    rewrite(plan, control=1.5 * content(plan)["control"])
    with pytest.raises(DamagedFileError, match=rf"^{plan}: this plan breaks a limit: .*attitude by"):
        load_plan(plan, small)


def test_a_plan_that_does_not_start_at_rest_is_not_flown(plan: Path, small: Scenario) -> None:
    control = content(plan)["control"]
    control[0] += 1e-3
    rewrite(plan, control=control)
    with pytest.raises(DamagedFileError, match=r"breaks a limit: .*rest at the start"):
        load_plan(plan, small)


@pytest.mark.parametrize(
    "factor",
    [
        0.9,  # within all limits, but not the plan that was certified
        pytest.param(1e300, id="overflows"),
    ],
)
def test_a_plan_changed_after_it_was_certified_is_not_flown(factor: float, plan: Path, small: Scenario) -> None:
    rewrite(plan, control=factor * content(plan)["control"])
    with pytest.raises(DamagedFileError, match=r"not as it was certified|must be finite and at most 100 rad"):
        load_plan(plan, small)


def test_a_certificate_of_another_plan_is_not_believed(plan: Path, small: Scenario) -> None:
    for name, value in content(plan).items():
        if name.startswith("certificate_"):
            save_plan(kept_plan(small), plan, small)
            rewrite(plan, **{name: value + 1e-3})
            with pytest.raises(DamagedFileError, match=f"not as it was certified: {name}"):
                load_plan(plan, small)
            rewrite(plan, **{name: None})
            with pytest.raises(DamagedFileError, match=f"no whole certificate: {name} is missing"):
                load_plan(plan, small)


def test_the_certificate_is_kept_with_the_plan(plan: Path, small: Scenario) -> None:
    """The largest angle over a grid of one's own, and the airframe's and controller's limits as they stand."""
    kept = content(plan)
    eta = load_plan(plan, small).eta(np.linspace(0.0, 3.0, 20001))
    assert kept["certificate_attitude_max_deg"] == pytest.approx(np.rad2deg(np.abs(eta).max()), rel=1e-4)
    np.testing.assert_array_equal(kept["certificate_rotor_speed_range"], [16.0, 100.0])
    assert kept["certificate_attitude_limit_deg"] == 15.0
    assert kept["certificate_angular_velocity_limit"] == 1.0
    assert kept["certificate_rotor_speed_min"] > 16.0
    assert kept["certificate_rotor_speed_max"] < 100.0


def without_certificate(plan: Path) -> None:
    rewrite(plan, **{name: None for name in content(plan) if name.startswith("certificate")})


def test_a_plan_of_former_times_is_certified_and_accepted(plan: Path, small: Scenario) -> None:
    without_certificate(plan)
    np.testing.assert_array_equal(load_plan(plan, small).control, kept_plan(small).control)
    rewrite(plan, control=1.5 * content(plan)["control"])
    with pytest.raises(DamagedFileError, match="breaks a limit"):
        load_plan(plan, small)


def damage(plan: Path) -> None:
    rewrite(plan, control=1.5 * content(plan)["control"])


def garble(plan: Path) -> None:
    plan.write_bytes(encrypted())


@pytest.mark.parametrize("harm", [damage, garble, without_certificate])
def test_a_kept_plan_is_found_or_made_again(harm: Callable[[Path], None], small: Scenario, tmp_path: Path) -> None:
    first = kept_plan(small)
    file = plan_file(small, tmp_path)
    shutil.copy(plan_file(small), file)
    harm(file)
    if harm is without_certificate:
        again = find_plan(small, tmp_path)
    else:
        with pytest.warns(UserWarning, match=rf"^a kept plan is damaged and is made again: {file}: .+$") as warned:
            again = kept_plan(small, folder=tmp_path)
        assert len(warned) == 1
        assert find_plan(small, tmp_path) is not None
    assert again is not None
    np.testing.assert_array_equal(again.control, first.control)


def test_a_plan_that_breaks_a_limit_is_flown_but_not_kept(
    small: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = cache.plan_attitude(small)
    broken = dataclasses.replace(plan, certificate=dataclasses.replace(plan.certificate, attitude_max_deg=15.3))
    monkeypatch.setattr(cache, "plan_attitude", lambda *_: broken)
    with pytest.warns(UserWarning, match=r"the plan breaks a limit and is not kept: attitude by 2 %"):
        kept_plan(small, folder=tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("harm", [damage, garble, without_certificate])
def test_a_plan_beside_its_scenario_is_flown_as_it_was_or_made_again(
    harm: Callable[[Path], None], tmp_path: Path
) -> None:
    first, again = tmp_path / "first", tmp_path / "again"
    assert simulate.main(["planned", "--set", *SMALL, "--duration", "0.2", "--out", str(first)]) == 0
    harm(first / "plan.npz")
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        assert simulate.main([str(first / "scenario.yaml"), "--out", str(again)]) == 0
    expected = f"the plan beside the scenario is damaged and is not flown: {first / 'plan.npz'}: "
    assert [str(warning.message)[: len(expected)] for warning in warned] == [expected][harm is without_certificate :]
    # The plan made again is the one that was kept.
    assert (again / "flight.npz").read_bytes() == (first / "flight.npz").read_bytes()
    assert load_plan(again / "plan.npz", load_scenario(str(again / "scenario.yaml"))) is not None


def test_a_campaign_makes_a_damaged_plan_once(small: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    file, made = plan_file(small), []
    file.parent.mkdir(parents=True)
    save_plan(AttitudeSpline(3.0, np.zeros((33, 3))), file, small)
    rewrite(file, control=np.full((33, 3), 0.3))

    def fly(scenario: Scenario, _place: int) -> Flight:
        return dataclasses.replace(made_up_flight(), scenario=scenario)

    monkeypatch.setattr(flying, "plan_quietly", lambda scenario, _: made.append(scenario))
    monkeypatch.setattr(flying, "fly_quietly", fly)
    monkeypatch.setattr(flying, "worker_processes", ThreadPoolExecutor)
    monkeypatch.setattr(flying, "show_warnings", lambda: None)
    both = {name: small.with_overrides([f"mpc.position_weight={weight}"]) for name, weight in (("a", 1), ("b", 2))}
    with pytest.warns(UserWarning, match=f"a kept plan is damaged and is made again: {file}"):
        assert set(flying.fly_campaign(both, tmp_path / "flights", 1)) == {"a", "b"}
    assert len(made) == 1


def test_a_worker_process_warns_on_one_line(
    small: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with worker_processes(1) as workers:
        workers.submit(flying.plan_quietly, small, 0).result()
        workers.submit(flying.fly_quietly, small.with_value("simulation.duration", 0.02), 0).result()
    folder = tmp_path / "file" / "a2s_drake" / "plans"
    assert capfd.readouterr().err == 2 * f"warning: the plan cannot be kept in {folder}: Not a directory\n"
