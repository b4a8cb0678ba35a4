import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from a2s_drake import Flight, Scenario, run_flight
from a2s_drake.guidance.path import uav_path
from a2s_drake.guidance.plan.cache import plan_for_law
from a2s_drake.study.ideal_tracking import IdealTracking, measure_ideal_tracking
from a2s_drake.world.ship import ship_track
from diagrams import build_closed_loop, load_scenario
from tests.support.browser import browser, open_page

__all__ = ["browser", "open_page"]

with contextlib.suppress(ModuleNotFoundError):  # Many tests need no Hypothesis.
    from hypothesis import settings

    # The same examples on every machine and every run.
    settings.register_profile("reproducible", derandomize=True, deadline=None)
    settings.load_profile("reproducible")


@pytest.fixture(scope="session", autouse=True)
def _cache_of_its_own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Plans that tests make are kept for the session alone."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture
def scenario() -> Scenario:
    """Table I as printed."""
    return load_scenario("paper").validate()


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20261122)


@pytest.fixture(scope="session")
def reference_geometry() -> tuple[np.ndarray, np.ndarray]:
    """Where UAV and ship are meant to be in the mission of Table I at its 2001 samples."""
    scenario = load_scenario("paper")
    times = scenario.sample_times()
    return uav_path(scenario.mission).position(times), ship_track(scenario.mission).position(times)


@pytest.fixture(scope="session")
def fly() -> Callable[..., Flight]:
    """Flies a named scenario in closed loop, each set of overrides once a session."""
    flown: dict[tuple[str, ...], Flight] = {}

    def fly_once(name: str, *overrides: str) -> Flight:
        key = (name, *overrides)
        if key not in flown:
            scenario = load_scenario(name).with_overrides(overrides).validate()
            flown[key] = run_flight(build_closed_loop(scenario, plan=plan_for_law(scenario)), scenario)
        return flown[key]

    return fly_once


@pytest.fixture(scope="session", autouse=True)
def _ideal_tracking_is_measured_once() -> Iterator[None]:
    """Many tests write a report. Its study of ideal tracking depends on the scenario alone and takes seconds."""
    made: dict[str, IdealTracking] = {}

    def study(scenario: Scenario) -> IdealTracking:
        key = scenario.to_yaml()
        if key not in made:
            made[key] = measure_ideal_tracking(scenario)
        return made[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("a2s_drake.study.paper.reproduction.measure_ideal_tracking", study)
        yield


@pytest.fixture
def refuses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Callable[[Any, list[str], str], None]:
    """Has a script refuse arguments: exit code 2, one line of error that gives the reason, and nothing written."""

    def check(script: Any, arguments: list[str], reason: str) -> None:
        out = tmp_path / "out"
        assert script.main([*arguments, "--out", str(out)]) == 2
        printed = capsys.readouterr()
        assert reason in printed.err
        assert printed.err.count("\n") == 1
        assert printed.out == ""
        assert not out.exists()

    return check
