from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from a2s_drake import Airframe, Flight, Scenario, run_flight
from a2s_drake.flight.metrics import gain_percent
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.study.ceiling import is_hoverable
from a2s_drake.study.paper.attribution import attribution, rate_limited, turned_back, without_rate_bound
from a2s_drake.study.paper.readings import under_law
from diagrams import build_link_only


def test_a_slow_reference_is_followed_exactly() -> None:
    time = np.arange(50.0)
    reference = 0.1 * np.stack([np.sin(0.1 * time), 1.0 - np.cos(0.1 * time), 0.0 * time], axis=-1)
    np.testing.assert_allclose(rate_limited(reference, 0.02), reference, atol=1e-15)


def test_a_jump_is_followed_at_the_limit_from_level() -> None:
    reference = np.tile([0.25, -0.1, 0.0], (5, 1))
    expected = [[0, 0, 0], [0.1, -0.1, 0], [0.2, -0.1, 0], [0.25, -0.1, 0], [0.25, -0.1, 0]]
    np.testing.assert_allclose(rate_limited(reference, 0.1), expected)


def test_what_can_be_hovered_at_is_left_alone(rng: np.random.Generator) -> None:
    eta = rng.uniform(-0.05, 0.05, (20, 3))
    np.testing.assert_array_equal(turned_back(eta, Airframe()), eta)


def test_what_cannot_is_turned_back_to_the_edge(rng: np.random.Generator) -> None:
    eta = np.column_stack([np.zeros(20), rng.uniform(0.21, 0.26, 20), rng.uniform(-0.2, 0.2, 20)])
    assert not is_hoverable(eta, Airframe()).any()
    dut = turned_back(eta, Airframe())
    assert is_hoverable(dut, Airframe()).all()
    share = np.linalg.norm(dut, axis=1) / np.linalg.norm(eta, axis=1)
    np.testing.assert_allclose(dut, share[:, np.newaxis] * eta)
    assert not is_hoverable((share[:, np.newaxis] + 0.006) * eta, Airframe()).any()


def test_without_its_bound_the_rate_hardly_matters(scenario: Scenario) -> None:
    free = without_rate_bound(scenario).validate()
    assert (free.attitude_law.name, free.mpc.angular_velocity_limit) == ("planned", 10.0)
    assert free.mission == scenario.mission


@pytest.fixture(scope="module")
def flights() -> dict[str, Flight]:
    """Two seconds, ideally tracked; the plan is made up."""
    scenario = Scenario().with_value("simulation.duration", 2.0)
    flown = {
        law: run_flight(build_link_only(under_law(scenario, law)), under_law(scenario, law))
        for law in ("three_axis", "level")
    }
    plan = np.tile([0.0, 0.05, 0.0], (len(flown["level"].time), 1))
    planned = replace(
        flown["three_axis"], attitude_reference=plan, attitude=plan, scenario=under_law(scenario, "planned")
    )
    return flown | {"planned": planned}


def test_both_ways_lead_from_the_best_to_what_is_flown(flights: dict[str, Flight]) -> None:
    steps = attribution(flights, AttitudeSpline(40.0, np.full((13, 3), 0.05)))
    ways = {law: [step for step in steps if step.law == law] for law in ("three_axis", "planned")}
    assert [step.effect for step in ways["three_axis"]] == [
        *("", "candidates", "fallback", "rate", "rotors", "tracking", "position")
    ]
    assert [step.effect for step in ways["planned"]] == [
        *("", "rotors at rest", "rotors in motion", "rate", "tracking", "position")
    ]
    for law, way in ways.items():
        assert way[0].gain_percent == ways["planned"][0].gain_percent
        assert way[-1].gain_percent == pytest.approx(gain_percent(flights[law], flights["level"]))
        assert sum(step.cost for step in way) == pytest.approx(way[0].gain_percent - way[-1].gain_percent)
        for higher, step in pairwise(way):
            assert step.share == (step.gain_percent / higher.gain_percent if higher.gain_percent > 0.0 else None)


def test_an_attitude_that_is_tracked_ideally_loses_nothing_by_tracking(flights: dict[str, Flight]) -> None:
    steps = {(step.law, step.effect): step for step in attribution(flights, AttitudeSpline(40.0, np.zeros((13, 3))))}
    assert steps["planned", "tracking"].cost == pytest.approx(0.0, abs=1e-9)
    # Flown ideally, the paper's law is where it asks to be, its path and attitude both.
    flown, asked = steps["three_axis", "position"], steps["three_axis", "fallback"]
    assert flown.gain_percent == pytest.approx(asked.gain_percent)
    assert steps["planned", "rotors in motion"].gain_percent == pytest.approx(0.0)  # That plan is level.
    for effect in ("candidates", "fallback"):
        assert steps["three_axis", effect].cost >= -1e-9
