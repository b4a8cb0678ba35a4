"""Ideal tracking where the UAV is wrong: laws see what it believes, the channel is the truth."""

from dataclasses import fields, replace

import numpy as np
import pytest

from a2s_drake import Flight, Scenario, run_flight
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.scenario.parts import Knowledge
from a2s_drake.study.ideal_tracking import (
    Geometry,
    best_measured_attitude,
    held_gain,
    held_throughput,
    law_attitude,
    measured_attitude,
)
from a2s_drake.study.missions import flight_name, outcome
from a2s_drake.study.paper.attribution import attribution
from a2s_drake.study.paper.readings import under_law
from diagrams import build_link_only

COARSE = Scenario().with_overrides(["mpc.period=0.4", "mpc.horizon=2"])
# One error for each setting of the section; a new setting needs one too.
ERRORS = {
    "ship_antenna_height_error": "0.31",
    "position_bias": "[0.3, -0.2, 0.1]",
    "attitude_bias_deg": "[1, -1, 0.5]",
    "transmit_power_error_db": "-2",
    "ship_latency": "1.3",
}


def flown(scenario: Scenario, law: str = "three_axis") -> Flight:
    """A flight of the drawing that holds the reference exactly; it shares no code with ideal tracking but the law's."""
    scenario = under_law(scenario, law)
    return run_flight(build_link_only(scenario), scenario)


def throughput(flight: Flight) -> float:
    return 0.4 * float(flight.spectral_efficiency.sum())


@pytest.mark.parametrize("key", [entry.name for entry in fields(Knowledge)])
def test_ideal_tracking_is_the_drawing_flown_for_every_error(key: str) -> None:
    scenario = COARSE.with_overrides([f"knowledge.{key}={ERRORS[key]}"])
    flight = flown(scenario)
    for geometry in (Geometry.of(scenario), Geometry.of_flight(flight)):
        eta = law_attitude(scenario, geometry, "three_axis", "nearest")
        np.testing.assert_allclose(eta, flight.attitude_reference, rtol=0.0, atol=1e-12)
        assert held_throughput(scenario, geometry, eta) == pytest.approx(throughput(flight), rel=1e-12)
        np.testing.assert_allclose(measured_attitude(flight), eta, rtol=0.0, atol=1e-12)
    # The error is large enough to be seen.
    assert throughput(flight) != pytest.approx(throughput(flown(COARSE)), rel=1e-4)


@pytest.fixture(scope="module")
def wrong() -> Scenario:
    return COARSE.with_overrides(["simulation.duration=8", *(f"knowledge.{key}={ERRORS[key]}" for key in ERRORS)])


@pytest.fixture(scope="module")
def flights(wrong: Scenario) -> dict[str, Flight]:
    """Held exactly; the plan is made up."""
    held = {law: flown(wrong, law) for law in ("three_axis", "level")}
    plan = np.tile([0.0, 0.05, 0.0], (len(held["level"].time), 1))
    true = plan + np.deg2rad(wrong.knowledge.attitude_bias_deg)
    planned = replace(held["level"], attitude_reference=plan, attitude=true, scenario=under_law(wrong, "planned"))
    return held | {"planned": planned}


def test_the_way_down_begins_at_the_best_in_truth_and_tracking_costs_nothing(flights: dict[str, Flight]) -> None:
    steps = {(step.law, step.effect): step for step in attribution(flights, AttitudeSpline(40.0, np.zeros((13, 3))))}
    best = steps["three_axis", ""].gain_percent
    assert all(step.gain_percent <= best + 1e-9 for step in steps.values())
    assert best > 40.0  # and it is far from what the laws win
    assert steps["planned", "rotors at rest"].gain_percent > 0.8 * best
    assert steps["planned", "tracking"].cost == pytest.approx(0.0, abs=1e-9)
    flown_gain = 100.0 * (throughput(flights["three_axis"]) / throughput(flights["level"]) - 1.0)
    assert steps["three_axis", "fallback"].gain_percent == pytest.approx(flown_gain, abs=1e-9)


def test_missions_are_measured_in_the_true_channel(wrong: Scenario, flights: dict[str, Flight]) -> None:
    names = {"level": "level", "nearest": "three_axis", "zero": "three_axis", "planned": "planned"}
    row = outcome({flight_name("mine", name): flights[law] for name, law in names.items()}, "mine")
    # Held exactly, the flown attitude on the reference path is the flight itself.
    assert row.path_gain["nearest"] == pytest.approx(row.flown_gain["nearest"], abs=1e-9)
    assert row.path_gain["planned"] == pytest.approx(row.plan_gain, abs=1e-9)
    geometry = Geometry.of_flight(flights["planned"])
    plan = held_throughput(wrong, geometry, flights["planned"].attitude_reference)
    assert row.plan_share == pytest.approx(throughput(flights["level"]) / plan)
    assert row.hover_gain > 0.8 * held_gain(wrong, geometry, best_measured_attitude(wrong, geometry))
