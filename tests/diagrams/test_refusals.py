"""What a builder refuses: blocks that do not fit, motions that cannot be flown, plans made for something else."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.primitives import ConstantVectorSource
from pydrake.trajectories import PiecewisePolynomial

from a2s_drake import (
    Scenario,
    ScenarioError,
    ShipTrajectory,
    UavPath,
    WiringError,
)
from a2s_drake.guidance.plan.spline import AttitudeSpline
from diagrams import Blocks, build_closed_loop, build_link_only
from tests.support.blocks import Block, level, resting_at

ROLES = {
    "path": ("uav_path", "position_reference, which must have size 3"),
    "ship": ("ship", "ship_position"),
    "ship_motion": ("ship_motion", "ship_antenna_position"),
    "channel": ("channel", "channel_gain"),
    "navigation": ("navigation_sensor", "measured_state, which must have size 12"),
    "ship_report": ("ship_report", "ship_preview, which must have size 93"),
    "receiver": ("snr_receiver", "snr_measurement, which must have size 2"),
    "law": ("attitude_reference", "attitude_preview, which must have size 93"),
    "controller": ("mpc", "rotor_speed_squared, which must have size 6"),
    "airframe": ("airframe", "vehicle_state, which must have size 12"),
}


@pytest.mark.parametrize("role", ROLES)
def test_a_block_without_the_ports_of_its_role_is_refused(role: str, short: Scenario) -> None:
    name, missing = ROLES[role]
    blocks = Blocks(**{role: lambda _: ConstantVectorSource([0.0])})
    with pytest.raises(WiringError, match=rf"^{name} \(ConstantVectorSource\): .*no output {missing}"):
        build_closed_loop(short, blocks=blocks)


def test_an_input_of_another_size_is_refused_with_both_sizes(short: Scenario) -> None:
    blocks = Blocks(controller=lambda _: Block({"measured_state": 6}, {"rotor_speed_squared": np.zeros(6)}))
    with pytest.raises(WiringError, match=r"input measured_state has size 6, must have 12"):
        build_closed_loop(short, blocks=blocks)


def line(start: list[float], end: list[float]) -> PiecewisePolynomial:
    return PiecewisePolynomial.FirstOrderHold([0.0, 40.0], np.array([start, end]).T)


def test_what_a_block_of_ones_own_takes_over_is_not_asked_of_the_scenario(short: Scenario) -> None:
    near = short.with_overrides(["mission.ship_start=[30, 0]", "mission.ship_end=[30, 0]"])
    with pytest.raises(ScenarioError, match=r"attitude_law\.index_max = 50: the nearest fringe"):
        build_closed_loop(near)
    build_closed_loop(near, blocks=Blocks(law=level))
    wide = short.with_value("mission.radius", 20.0)
    with pytest.raises(ScenarioError, match="operating region"):
        build_closed_loop(wide)
    build_closed_loop(wide, blocks=Blocks(path=resting_at([0.0, 0.0, 0.0])))


@pytest.mark.parametrize(
    ("blocks", "reason"),
    [
        (
            Blocks(path=lambda s: UavPath(line([0.0, 0.0, -25.0], [1.0, 0.0, -25.0]), s.mpc)),
            r"mission\.sea_level = -20\.0: must be below -25 m, the lowest height of the path of Blocks\.path",
        ),
        (
            Blocks(path=lambda s: UavPath(line([0.0, 0.0, 0.0], [9.0, 90.0, 0.0]), s.mpc)),
            r"mpc\.position_upper",
        ),
        (
            Blocks(path=lambda s: UavPath(line([0.0, -9.0, 0.0], [0.0, 9.0, 0.0]), replace(s.mpc, velocity_limit=0.1))),
            None,
        ),
        (
            Blocks(ship=lambda _: ShipTrajectory(line([20.0, 0.0, -20.0], [21.0, 0.0, -20.0]))),
            r"attitude_law\.index_max = 50: the nearest fringe has index 1\d\d",
        ),
    ],
)
def test_an_own_motion_is_checked_as_the_scenarios_is(blocks: Blocks, reason: str | None, short: Scenario) -> None:
    for build in (build_closed_loop, build_link_only):
        if reason is None:
            build(short, blocks=blocks)
            continue
        with pytest.raises(ScenarioError, match=reason):
            build(short, blocks=blocks)


def test_a_plan_is_flown_where_it_was_made_for_and_nowhere_else(short: Scenario) -> None:
    planned = short.with_value("attitude_law.name", "planned")
    plan = AttitudeSpline(40.0, np.zeros((50, 3)))
    build_closed_loop(planned, plan=plan)
    with pytest.raises(ScenarioError, match=r"'planned': a plan is made for the scenario's own path and ship"):
        build_closed_loop(planned, plan=plan, blocks=Blocks(path=resting_at([0.0, 0.0, 0.0])))
    with pytest.raises(ScenarioError, match=r"plan: is for 10 s, must be for mission\.duration = 40\.0 s"):
        build_closed_loop(planned, plan=AttitudeSpline(10.0, np.zeros((50, 3))))
    with pytest.raises(ScenarioError, match=r"plan: reaches 171\.9 deg"):
        build_closed_loop(planned, plan=AttitudeSpline(40.0, np.full((50, 3), 3.0)))
    for scenario, blocks in ((short, None), (planned, Blocks(law=level))):
        with pytest.raises(ScenarioError, match="plan: nothing in this diagram flies a plan"):
            build_link_only(scenario, plan=plan, blocks=blocks)


@pytest.mark.parametrize("given", ["position_command", "position_command_preview"])
def test_a_law_that_moves_the_position_says_both_where_now_and_where_to(given: str, short: Scenario) -> None:
    size = 3 if given == "position_command" else 93
    law = {"attitude_reference": np.zeros(3), "attitude_preview": np.zeros(93), given: np.zeros(size)}
    with pytest.raises(WiringError, match=r"attitude_reference \(Block\): no output position_command"):
        build_closed_loop(short, blocks=Blocks(law=lambda _: Block({}, law)))


@pytest.mark.parametrize(
    ("blocks", "reason"),
    [
        (Blocks(law=level(Scenario())), r"Blocks\.law must be a function that makes a block, is a Block"),
        (Blocks(law=lambda _: None), r"Blocks\.law must make a Drake System, made a NoneType"),
    ],
)
def test_what_makes_no_block_is_refused(blocks: Blocks, reason: str, short: Scenario) -> None:
    with pytest.raises(WiringError, match=reason):
        build_closed_loop(short, blocks=blocks)


def test_one_block_cannot_stand_in_two_drawings(short: Scenario) -> None:
    once = level(short)
    build_closed_loop(short, blocks=Blocks(law=lambda _: once))
    with pytest.raises(WiringError, match="cannot be built"):
        build_closed_loop(short, blocks=Blocks(law=lambda _: once))


def test_a_law_in_a_circle_is_refused_in_ideal_tracking(short: Scenario) -> None:
    loop = {
        "attitude_reference": lambda state: state[3:6],
        "attitude_preview": lambda state: np.tile(state[3:6], 31),
    }
    with pytest.raises(WiringError, match="algebraic loop"):
        build_link_only(short, blocks=Blocks(law=lambda _: Block({"vehicle_state": 12}, loop)))


def test_a_report_of_the_ships_own_cannot_be_late(short: Scenario) -> None:
    where = {"ship_position": np.array([80.0, 5.0, -20.0]), "ship_preview": np.zeros(93)}
    with pytest.raises(ScenarioError, match=r"knowledge\.ship_latency = 5\.0: must be 0"):
        build_closed_loop(
            short.with_value("knowledge.ship_latency", 5.0), blocks=Blocks(ship=lambda _: Block({}, where))
        )


def test_a_drawing_refuses_blocks_that_it_has_no_place_for(short: Scenario) -> None:
    with pytest.raises(WiringError, match="link_only has no place for: navigation, controller"):
        build_link_only(short, blocks=Blocks(controller=level, navigation=level))


def test_a_block_cannot_give_the_signal_of_another_role(short: Scenario) -> None:
    gain = dict.fromkeys(("channel_gain", "snr_db", "spectral_efficiency", "phase_difference"), np.zeros(1))
    channel = Blocks(channel=lambda _: Block({}, gain | {"measured_state": np.zeros(12)}))
    with pytest.raises(WiringError, match=r"channel \(Block\): output measured_state is a signal of another role"):
        build_closed_loop(short, blocks=channel)
    attitude = {"attitude_reference": np.zeros(3), "attitude_preview": np.zeros(93), "debug": np.zeros(1)}
    both = Blocks(
        law=lambda _: Block({}, attitude),
        controller=lambda _: Block({}, {"rotor_speed_squared": np.zeros(6), "debug": np.zeros(1)}),
    )
    with pytest.raises(WiringError, match=r"mpc \(Block\): attitude_reference has an output debug too"):
        build_closed_loop(short, blocks=both)
