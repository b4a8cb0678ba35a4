from pathlib import Path

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, InitializeAutoDiff
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem
from pydrake.systems.primitives import PassThrough

from a2s_drake import (
    AttitudeLaw,
    AttitudeReference,
    Link,
    Scenario,
    ScenarioError,
    WiringError,
    attitude_reference,
    hover_input,
    run_flight,
)
from a2s_drake.common.wiring import find_block, own_blocks
from a2s_drake.vehicle.rigid_body import RigidBodyModel
from diagrams import BUILDERS, Blocks, build_airframe_only, build_closed_loop, build_link_only, load_scenario

LOGGED = {
    "vehicle_state": 12,
    "position_reference": 3,
    "attitude_reference": 3,
    "ship_position": 3,
    "channel_gain": 1,
    "snr_db": 1,
    "spectral_efficiency": 1,
    "phase_difference": 1,
    "reflection": 2,
    "ship_antenna_position": 3,
    "ship_preview": 3 * 31,
}


def vector_ports(diagram) -> dict[str, int]:
    ports = map(diagram.get_output_port, range(diagram.num_output_ports()))
    return {port.get_name(): port.size() for port in ports if port.get_name() != "body_poses"}


@pytest.mark.parametrize("name", BUILDERS)
def test_every_drawing_builds_from_a_scenario_and_bears_its_name(name: str, scenario: Scenario) -> None:
    dut = BUILDERS[name](scenario)
    assert dut.get_name() == name


def test_closed_loop_exports_what_a_script_logs(scenario: Scenario) -> None:
    dut = build_closed_loop(scenario)
    mine = {"rotor_speed_squared": 6, "predicted_state": 12 * 31, "solver_status": 4, "measured_state": 12}
    assert vector_ports(dut) == LOGGED | mine
    assert dut.HasOutputPort("body_poses")
    assert dut.num_input_ports() == 0


def test_link_only_exports_the_same_but_for_rotors_and_solver(scenario: Scenario) -> None:
    assert vector_ports(build_link_only(scenario)) == LOGGED | {"measured_state": 12}


def test_airframe_only_opens_its_rotors(scenario: Scenario) -> None:
    dut = build_airframe_only(scenario)
    assert dut.GetInputPort("rotor_speed_squared").size() == 6
    assert vector_ports(dut) == {"vehicle_state": 12}


def test_drawings_default_to_table_i() -> None:
    flight = run_flight(build_link_only(), load_scenario("paper").with_value("simulation.duration", 1.0))
    assert flight.channel_gain[0] == pytest.approx(2.412125015e-8, rel=1e-9)


def test_link_only_tracks_ideally(scenario: Scenario, reference_geometry) -> None:
    flight = run_flight(build_link_only(scenario), scenario)
    position, ship = reference_geometry
    np.testing.assert_allclose(flight.position, position, atol=1e-12)
    np.testing.assert_allclose(flight.ship_position, ship, atol=1e-12)
    eta = attitude_reference(position, ship, Link(), AttitudeLaw(), scenario.mpc.attitude_limit)
    np.testing.assert_allclose(flight.attitude, eta, atol=1e-9)
    assert 0.02 * flight.spectral_efficiency.sum() == pytest.approx(1.449 * 122.387, rel=5e-4)


class Tilted(LeafSystem):
    """A law of a user's own: 0.1 rad of pitch, come what may."""

    def __init__(self, horizon: int, outputs: tuple[str, ...] = ("attitude_reference", "attitude_preview")) -> None:
        LeafSystem.__init__(self)
        size = 3 * (horizon + 1)
        for name in ("position_preview", "ship_preview"):
            self.DeclareVectorInputPort(name, size)
        for name in outputs:
            width = size if name.endswith("_preview") else 3
            self.DeclareVectorOutputPort(
                name, width, lambda _, out: out.SetFromVector(np.tile([0.0, 0.1, 0.0], out.size() // 3))
            )


@pytest.mark.parametrize("build", [build_closed_loop, build_link_only])
def test_a_law_of_ones_own_stands_in_for_the_scenarios(build, scenario: Scenario) -> None:
    dut = build(scenario, blocks=Blocks(law=lambda _: Tilted(scenario.mpc.horizon)))
    flight = run_flight(dut, scenario.with_value("simulation.duration", 0.5))
    assert isinstance(find_block(dut, "attitude_reference"), Tilted)
    assert own_blocks(dut) == {"law": "Tilted"}
    np.testing.assert_array_equal(flight.attitude_reference, np.tile([0.0, 0.1, 0.0], (26, 1)))
    # Ideal tracking holds it at once; in closed loop the vehicle is on its way there.
    assert flight.attitude[-1, 1] == pytest.approx(0.1, abs=0.0 if build is build_link_only else 0.05)


def test_a_law_that_feeds_forward_must_feed_all(scenario: Scenario) -> None:
    outputs = ("attitude_reference", "attitude_preview", "velocity_preview")
    blocks = Blocks(law=lambda _: Tilted(scenario.mpc.horizon, outputs))
    with pytest.raises(WiringError, match=r"\(Tilted\): .*no output angular_velocity_preview, which must have size 93"):
        build_closed_loop(scenario, blocks=blocks)
    scenario.mpc.feedforward = False
    assert build_closed_loop(scenario, blocks=blocks).get_name() == "closed_loop"


def test_the_papers_law_given_as_ones_own_changes_nothing(scenario: Scenario) -> None:
    scenario = scenario.with_value("simulation.duration", 0.3)
    mpc = scenario.mpc

    def law(_: Scenario) -> AttitudeReference:
        return AttitudeReference(scenario.link, scenario.attitude_law, mpc.attitude_limit, mpc.horizon)

    given, own = (
        run_flight(build_closed_loop(scenario, blocks=blocks), scenario) for blocks in (None, Blocks(law=law))
    )
    np.testing.assert_array_equal(own.rotor_speed, given.rotor_speed)


@pytest.mark.parametrize("build", [build_closed_loop, build_link_only])
@pytest.mark.parametrize(
    ("law", "reason"),
    [
        (
            lambda: Tilted(20),
            r"\(Tilted\): output attitude_preview has size 63, must have 93",
        ),
        (
            lambda: Tilted(30, ("attitude_reference", "preview")),
            "no output attitude_preview, which must have size 93; its ",
        ),
        (
            lambda: PassThrough(93),
            r"\(PassThrough\): no output attitude_reference, which must have size 3; its outputs: y; ",
        ),
    ],
)
def test_a_law_that_does_not_fit_is_refused_by_port_and_size(build, law, reason: str, scenario: Scenario) -> None:
    with pytest.raises(WiringError, match=f"^attitude_reference .*{reason}"):
        build(scenario, blocks=Blocks(law=lambda _: law()))


def test_closed_loop_starts_at_rest_where_the_path_begins(scenario: Scenario) -> None:
    scenario.mission.start = [1.0, -2.0, 0.5]
    dut = build_closed_loop(scenario)
    state = dut.GetOutputPort("vehicle_state").Eval(dut.CreateDefaultContext())
    np.testing.assert_allclose(state, [1.0, -2.0, 0.5] + 9 * [0.0], atol=1e-15)


def test_airframe_linearises_in_autodiff(scenario: Scenario) -> None:
    # The oracle is the other way round here: the plant's own AutoDiff against the analytic prediction model.
    dut = build_airframe_only(scenario).ToAutoDiffXd()
    context = dut.CreateDefaultContext()
    tape = InitializeAutoDiff(hover_input(scenario.airframe)).ravel()
    dut.GetInputPort("rotor_speed_squared").FixValue(context, tape)
    slope = dut.EvalTimeDerivatives(context).CopyToVector()
    _, by_input = RigidBodyModel.of(scenario.airframe).jacobians(np.zeros(12), hover_input(scenario.airframe))
    np.testing.assert_allclose(ExtractGradient(slope)[7:10], by_input[9:12], atol=1e-12)
    np.testing.assert_allclose(ExtractGradient(slope)[10:13], by_input[6:9], atol=1e-12)
    assert isinstance(dut.GetOutputPort("vehicle_state").Eval(context)[0], AutoDiffXd)


def test_plant_integration_agrees_with_a_fine_reference(scenario: Scenario) -> None:
    # The default step against one fifty times finer, under a rotor command that tumbles the vehicle.
    ends = []
    for step in (0.01, 0.0002):
        dut = build_airframe_only(scenario)
        simulator = Simulator(dut)
        integrator = simulator.get_mutable_integrator()
        integrator.set_fixed_step_mode(True)
        integrator.set_maximum_step_size(step)
        u = hover_input(scenario.airframe) * np.array([1.02, 0.99, 1.0, 1.01, 0.98, 1.0])
        dut.GetInputPort("rotor_speed_squared").FixValue(simulator.get_mutable_context(), u)
        simulator.AdvanceTo(2.0)
        ends.append(dut.GetOutputPort("vehicle_state").Eval(simulator.get_context()))
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-6)


def test_scenarios_load_by_name_or_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("{mission: {radius: 2.0}}")
    assert load_scenario(str(path)).mission.radius == 2.0
    with pytest.raises(ScenarioError, match="no scenario named 'mine'"):
        load_scenario("mine")
