"""A drawing opened by its user: blocks of one's own by role, wired by name, and what is refused."""

import time
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

from a2s_drake import (
    MpcController,
    Scenario,
    ScenarioError,
    TwoRayChannel,
    WiringError,
    hover_input,
    run_flight,
)
from a2s_drake.common.wiring import find_block, own_blocks
from diagrams import Blocks, build_closed_loop, build_link_only, load_scenario
from tests.support.blocks import Block, level


def test_a_drawing_of_ours_has_no_block_of_the_users(short: Scenario) -> None:
    assert own_blocks(build_closed_loop(short)) == {}


def test_only_sensors_stand_between_the_world_and_what_is_on_board(short: Scenario) -> None:
    dut = build_closed_loop(short)
    parts = {part.get_name(): part for part in dut.GetSystems()}
    assert set(parts) == {"world", "sensing", "onboard"}
    wired = {
        (source, target)
        for source in parts
        for target in parts
        for output in map(parts[source].get_output_port, range(parts[source].num_output_ports()))
        for entry in map(parts[target].get_input_port, range(parts[target].num_input_ports()))
        if dut.AreConnected(output, entry)
    }
    assert wired == {("world", "sensing"), ("sensing", "onboard"), ("onboard", "world")}


def test_the_truth_does_not_reach_what_is_on_board(short: Scenario) -> None:
    size = 3 * 31
    attitude = {"attitude_reference": np.zeros(3), "attitude_preview": np.zeros(size)}
    blocks = Blocks(law=lambda _: Block({"ship_antenna_position": 3}, attitude))
    with pytest.raises(
        WiringError, match=r"^attitude_reference \(Block\): input ship_antenna_position: no other block"
    ):
        build_closed_loop(short, blocks=blocks)


def test_an_own_sensor_stands_between_truth_and_controller(short: Scenario) -> None:
    def sensor(_: Scenario) -> Block:
        return Block({"vehicle_state": 12}, {"measured_state": lambda state: state + 0.25})

    dut = build_closed_loop(short, blocks=Blocks(navigation=sensor))
    context = dut.CreateDefaultContext()
    truth, believed = (dut.GetOutputPort(name).Eval(context) for name in ("vehicle_state", "measured_state"))
    np.testing.assert_allclose(believed, truth + 0.25)
    mpc = find_block(dut, "mpc")
    np.testing.assert_array_equal(mpc.GetInputPort("vehicle_state").Eval(mpc.GetMyContextFromRoot(context)), believed)
    assert own_blocks(dut) == {"navigation": "Block"}


def test_an_own_observer_takes_the_place_of_a_sensor_for_all_that_comes_after(short: Scenario) -> None:
    def observer(_: Scenario) -> Block:
        block = Block(
            {"measured_state": 12, "ship_preview": 93},
            {"measured_state": lambda known: 2.0 * known[:12], "ship_preview": lambda known: known[12:] + 7.0},
        )
        block.set_name("my_observer")
        return block

    dut = build_closed_loop(short, blocks=Blocks(observer=observer))
    context = dut.CreateDefaultContext()
    report, law = find_block(dut, "ship_report"), find_block(dut, "attitude_reference")
    told = report.GetOutputPort("ship_preview").Eval(report.GetMyContextFromRoot(context))
    read = law.GetInputPort("ship_preview").Eval(law.GetMyContextFromRoot(context))
    np.testing.assert_array_equal(read, told + 7.0)
    assert own_blocks(dut) == {"observer": "my_observer"}


def test_outputs_of_ones_own_are_exported_and_can_be_read_by_others(short: Scenario) -> None:
    def law(scenario: Scenario) -> Block:
        size = 3 * (scenario.mpc.horizon + 1)
        return Block(
            {"confidence": 1},
            {
                "attitude_reference": lambda known: np.full(3, 0.01 * known[0]),
                "attitude_preview": lambda known: np.full(size, 0.01 * known[0]),
            },
        )

    blocks = Blocks(
        receiver=lambda _: Block({"snr_db": 1}, {"snr_measurement": lambda snr: np.array([snr[0], 0.0])}),
        observer=lambda _: Block({"snr_measurement": 2}, {"confidence": lambda snr: snr[:1] / 10.0}),
        law=law,
    )
    dut = build_closed_loop(short, blocks=blocks)
    context = dut.CreateDefaultContext()
    snr, confidence, attitude = (
        dut.GetOutputPort(name).Eval(context) for name in ("snr_db", "confidence", "attitude_reference")
    )
    np.testing.assert_allclose(confidence, snr / 10.0)
    np.testing.assert_allclose(attitude, np.full(3, 0.01 * confidence[0]))


def test_a_controller_without_status_still_turns_the_rotors(short: Scenario) -> None:
    hover = hover_input(short.airframe)
    dut = build_closed_loop(short, blocks=Blocks(controller=lambda _: Block({}, {"rotor_speed_squared": hover})))
    assert not dut.HasOutputPort("solver_status")
    flight = run_flight(dut, short)
    np.testing.assert_allclose(flight.rotor_speed, np.tile(np.sqrt(hover), (6, 1)))
    assert flight.has_rotors


def test_a_ship_may_bring_a_report_of_its_own(short: Scenario) -> None:
    where, told = np.array([80.0, 5.0, -20.0]), np.arange(93.0)
    blocks = Blocks(ship=lambda _: Block({}, {"ship_position": where, "ship_preview": told}))
    for build in (build_closed_loop, build_link_only):
        dut = build(short, blocks=blocks)
        context = dut.CreateDefaultContext()
        np.testing.assert_array_equal(dut.GetOutputPort("ship_preview").Eval(context), told)
        np.testing.assert_array_equal(
            dut.GetOutputPort("ship_antenna_position").Eval(context), where + np.array([0.0, 0.0, 10.0])
        )


def test_a_ship_without_a_report_leaves_the_uav_with_the_scenarios_track(short: Scenario) -> None:
    blocks = Blocks(ship=lambda _: Block({}, {"ship_position": np.array([80.0, 5.0, -20.0])}))
    dut = build_closed_loop(short, blocks=blocks)
    told = dut.GetOutputPort("ship_preview").Eval(dut.CreateDefaultContext())
    np.testing.assert_allclose(told[:3], [90.0, 0.0, -20.0])


def test_the_vehicle_begins_where_an_own_path_begins(short: Scenario) -> None:
    start = np.array([1.0, -2.0, 0.5])
    path = {"position_reference": start, "position_preview": np.tile(start, 31)}
    dut = build_closed_loop(short, blocks=Blocks(path=lambda _: Block({}, path)))
    state = dut.GetOutputPort("vehicle_state").Eval(dut.CreateDefaultContext())
    np.testing.assert_allclose(state, [*start, *[0.0] * 9], atol=1e-15)


def test_a_law_that_moves_the_position_is_what_the_controller_follows(short: Scenario) -> None:
    moved = np.tile([0.1, 0.2, 0.3], 31)
    law = {
        "attitude_reference": np.zeros(3),
        "attitude_preview": np.zeros(93),
        "position_command": moved[:3],
        "position_command_preview": moved,
    }
    dut = build_closed_loop(short, blocks=Blocks(law=lambda _: Block({}, law)))
    context = dut.CreateDefaultContext()
    mpc = find_block(dut, "mpc")
    read = mpc.GetInputPort("position_preview").Eval(mpc.GetMyContextFromRoot(context))
    np.testing.assert_array_equal(read, moved)
    np.testing.assert_array_equal(dut.GetOutputPort("position_command").Eval(context), moved[:3])


def test_prebuild_opens_the_drawing(short: Scenario) -> None:
    loggers = []

    def prebuild(builder: DiagramBuilder) -> None:
        onboard = builder.GetSubsystemByName("onboard")
        loggers.append(LogVectorOutput(onboard.GetOutputPort("attitude_preview"), builder, short.mpc.period))
        builder.ExportOutput(onboard.GetOutputPort("position_preview"), "my_preview")

    dut = build_closed_loop(short, prebuild=prebuild)
    flight = run_flight(dut, short)
    assert dut.GetOutputPort("my_preview").size() == 93
    log = loggers[0].FindLog(dut.CreateDefaultContext())
    assert log.num_samples() == 0  # of a new context; the flight's own has its samples
    assert len(flight.time) == 6


def test_a_builder_makes_no_plan_and_touches_no_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    scenario = load_scenario("planned")
    begin = time.perf_counter()
    dut = build_closed_loop(scenario)
    assert time.perf_counter() - begin < 5.0  # planning takes four times as long
    assert not (tmp_path / "cache").exists()
    with pytest.raises(ScenarioError, match=r"'planned': this diagram was built without a plan; .*kept_plan"):
        run_flight(dut, scenario)


@pytest.mark.parametrize("build", [build_closed_loop, build_link_only])
def test_a_scenario_that_cannot_be_flown_is_refused_before_it_is_built(build, scenario: Scenario) -> None:
    with pytest.raises(ScenarioError, match=r"^mission\.duration = 20\.0"):
        build(scenario.with_value("mission.duration", 20.0))


def test_the_channel_is_told_the_truth(short: Scenario) -> None:
    louder = short.with_value("knowledge.transmit_power_error_db", 6.0)
    snr = [
        dut.GetOutputPort("snr_db").Eval(dut.CreateDefaultContext())[0]
        for dut in (build_closed_loop(short), build_closed_loop(louder))
    ]
    assert snr[1] - snr[0] == pytest.approx(6.0, abs=1e-9)
    own = build_closed_loop(short, blocks=Blocks(channel=lambda s: TwoRayChannel(s.true_link(), s.mission.sea_level)))
    assert own.GetOutputPort("snr_db").Eval(own.CreateDefaultContext())[0] == snr[0]


def test_ideal_tracking_is_off_by_the_bias_of_what_is_measured(short: Scenario) -> None:
    biased = short.with_overrides(["knowledge.position_bias=[0.1, 0, -0.2]", "knowledge.attitude_bias_deg=[1, 2, 3]"])
    states = [
        dut.GetOutputPort("vehicle_state").Eval(dut.CreateDefaultContext())
        for dut in (build_link_only(short), build_link_only(biased))
    ]
    bias = [0.1, 0.0, -0.2, *np.deg2rad([1.0, 2.0, 3.0]), *[0.0] * 6]
    np.testing.assert_allclose(states[1] - states[0], bias, atol=1e-12)


def test_a_flight_tracks_what_it_measures(scenario: Scenario) -> None:
    level = scenario.with_overrides(["attitude_law.name=level", "simulation.duration=6"])
    biased = level.with_value("knowledge.position_bias", [0.0, 0.0, 0.2])
    flights = [run_flight(build_closed_loop(one), one) for one in (level, biased)]
    off = flights[1].position[-1] - flights[0].position[-1]
    np.testing.assert_allclose(off, [0.0, 0.0, 0.2], atol=2e-3)


def test_an_own_planner_comes_in_a_controller(short: Scenario) -> None:
    dut = build_closed_loop(
        short, blocks=Blocks(controller=lambda s: MpcController(s.airframe, s.mpc, feedforward=False))
    )
    flight, ours = run_flight(dut, short), run_flight(build_closed_loop(short), short)
    np.testing.assert_array_equal(flight.rotor_speed, ours.rotor_speed)


def test_an_own_path_with_inputs_starts_where_the_scenarios_path_does(short: Scenario) -> None:
    short = short.with_value("mission.start", [1.0, 2.0, 0.0])
    here = {
        "position_reference": lambda state: state[:3],
        "position_preview": lambda state: np.tile(state[:3], 31),
    }
    dut = build_closed_loop(short, blocks=Blocks(path=lambda _: Block({"vehicle_state": 12}, here)))
    state = dut.GetOutputPort("vehicle_state").Eval(dut.CreateDefaultContext())
    np.testing.assert_allclose(state[:3], [1.0, 2.0, 0.0])


def test_whatever_opens_a_drawing_makes_it_the_users_own(short: Scenario) -> None:
    def mine(_: DiagramBuilder) -> None:
        pass

    assert own_blocks(build_closed_loop(short, prebuild=mine)) == {"prebuild": "mine"}
    builder = DiagramBuilder()
    inner = builder.AddSystem(build_link_only(short, blocks=Blocks(law=level)))
    builder.ExportOutput(inner.GetOutputPort("snr_db"), "snr_db")
    outer = builder.Build()
    outer.set_name("outer")
    assert own_blocks(outer) == {"law": "Block", "diagram": "outer"}


def test_the_uav_measures_itself_on_its_command_in_ideal_tracking(short: Scenario) -> None:
    biased = short.with_value("knowledge.position_bias", [0.3, 0.0, 0.0])
    flight = run_flight(build_link_only(biased), biased)
    np.testing.assert_allclose(flight.measured_state[:, :3], flight.position_reference, atol=1e-12)
    np.testing.assert_allclose(flight.position - flight.measured_state[:, :3], np.tile([0.3, 0.0, 0.0], (6, 1)))
