"""The whole mission: path, ship, attitude law, MPC, hexarotor and channel in one loop."""

from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort, System

from a2s_drake.common.wiring import build_wired, check_ports, export_outputs
from a2s_drake.control.controller import MpcController, feedforward_ports
from a2s_drake.control.ladder import Planner
from a2s_drake.link.two_ray import TwoRayChannel
from a2s_drake.navigation.sensors import MeasurementNoise
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.vehicle.actuators import InputDelay
from a2s_drake.vehicle.airframe import add_airframe, hover_input

from .reference import add_reference


def build_closed_loop(
    scenario: Scenario | None = None, planner: Planner | None = None, law: System | None = None
) -> Diagram:
    """The mission of a scenario (Table I by default), the vehicle at rest and level where the path begins.

    Noise on the measured state and delay of the commands stand in it only where the scenario asks for them;
    `rotor_speed_squared` is the command that reaches the rotors. A planner of one's own may stand in for the
    scenario's, and so may an attitude law: a block with the ports of `AttitudeReference`, made for this diagram alone.
    Where a law has the outputs of `feedforward_ports` too, the controller follows these as well, unless
    `mpc.feedforward` is off.

    ```
    +-------------+
    |             |--> vehicle_state, rotor_speed_squared, body_poses
    |             |--> position_reference, attitude_reference, ship_position
    | closed_loop |--> channel_gain, snr_db, spectral_efficiency, phase_difference
    |             |--> predicted_state, solver_status
    +-------------+
    ```

    Raises:
      WiringError: when the law's ports do not fit; names them, with the sizes found and wanted.
    """
    scenario = scenario or Scenario()
    builder = DiagramBuilder()
    path, ship, law = add_reference(builder, scenario, law)
    feeds = _feedforward(scenario, law)
    controller = MpcController(scenario.airframe, scenario.mpc, planner, feedforward=bool(feeds))
    mpc = builder.AddNamedSystem("mpc", controller)
    airframe = add_airframe(builder, scenario.airframe, scenario.mission.start, scenario.disturbance)
    channel = builder.AddNamedSystem("channel", TwoRayChannel(scenario.link))

    builder.Connect(path.GetOutputPort("position_preview"), mpc.GetInputPort("position_preview"))
    builder.Connect(law.GetOutputPort("attitude_preview"), mpc.GetInputPort("attitude_preview"))
    for name in feeds:
        builder.Connect(law.GetOutputPort(name), mpc.GetInputPort(name))
    command = _delayed(builder, scenario, mpc.GetOutputPort("rotor_speed_squared"))
    builder.Connect(command, airframe.GetInputPort("rotor_speed_squared"))
    measured = _measured(builder, scenario, airframe.GetOutputPort("vehicle_state"))
    builder.Connect(measured, mpc.GetInputPort("vehicle_state"))
    builder.Connect(airframe.GetOutputPort("vehicle_state"), channel.GetInputPort("vehicle_state"))
    builder.Connect(ship.GetOutputPort("ship_position"), channel.GetInputPort("ship_position"))

    export_outputs(builder, airframe, channel)
    builder.ExportOutput(command, "rotor_speed_squared")
    for name in ("predicted_state", "solver_status"):
        builder.ExportOutput(mpc.GetOutputPort(name), name)
    return build_wired(builder, "closed_loop")


def _feedforward(scenario: Scenario, law: System) -> dict[str, int]:
    """The outputs of a law, by name and size, that the controller follows beyond the attitude."""
    ports = feedforward_ports(scenario.mpc)
    if not (scenario.mpc.feedforward and any(map(law.HasOutputPort, ports))):
        return {}
    check_ports("attitude_reference", law, {}, ports)
    return ports


def _measured(builder: DiagramBuilder, scenario: Scenario, state: OutputPort) -> OutputPort:
    """The state as the controller gets to see it."""
    if not any(scenario.disturbance.noise_deviations):
        return state
    noise = builder.AddNamedSystem("measurement", MeasurementNoise(scenario.disturbance, scenario.mpc.period))
    builder.Connect(state, noise.GetInputPort("vehicle_state"))
    return noise.GetOutputPort("measured_state")


def _delayed(builder: DiagramBuilder, scenario: Scenario, command: OutputPort) -> OutputPort:
    """The command as the rotors get it."""
    periods = scenario.disturbance.input_delay_periods
    if periods == 0:
        return command
    delay = InputDelay(periods, scenario.mpc.period, hover_input(scenario.airframe))
    builder.Connect(command, builder.AddNamedSystem("input_delay", delay).GetInputPort("rotor_speed_command"))
    return delay.GetOutputPort("rotor_speed_squared")
