"""Tracking problems of a scenario, for tests that solve them."""

import numpy as np

from a2s_drake import Scenario, attitude_reference
from a2s_drake.control.horizon import Plan, Reference, hold
from a2s_drake.guidance.path import uav_path
from a2s_drake.vehicle.airframe import hover_input
from a2s_drake.vehicle.rigid_body import RigidBodyModel
from a2s_drake.world.ship import ship_track

ROTOR_RANGE = 100.0**2 - 16.0**2  # Hz^2


def reference_at(scenario: Scenario, sample: int) -> Reference:
    times = scenario.mpc.period * (sample + np.arange(scenario.mpc.horizon + 1))
    position, ship = uav_path(scenario.mission).position(times), ship_track(scenario.mission).position(times)
    limit = scenario.mpc.attitude_limit
    return Reference.of_pose(position, attitude_reference(position, ship, scenario.link, scenario.attitude_law, limit))


def model_of(scenario: Scenario) -> RigidBodyModel:
    return RigidBodyModel.of(scenario.airframe)


def hover_from(scenario: Scenario, x0: np.ndarray) -> Plan:
    hover = hover_input(scenario.airframe)
    return hold(x0, hover, scenario.mpc.horizon, model_of(scenario), scenario.mpc.period)
