"""The whole mission: path, ship, attitude law, MPC, hexarotor and channel in one loop."""

from pydrake.systems.framework import Diagram, DiagramBuilder

from a2s_drake.airframe import add_airframe
from a2s_drake.mpc.controller import MpcController
from a2s_drake.scenario import Scenario
from a2s_drake.two_ray import TwoRayChannel
from a2s_drake.wiring import build_wired, export_outputs
from diagrams.reference import add_reference


def build_closed_loop(scenario: Scenario | None = None) -> Diagram:
    """The mission of a scenario (Table I by default), the vehicle at rest and level where the path begins.

    ```
    +-------------+
    |             |--> vehicle_state, rotor_speed_squared, body_poses
    |             |--> position_reference, attitude_reference, ship_position
    | closed_loop |--> channel_gain, snr_db, spectral_efficiency, phase_difference
    |             |--> predicted_state, solver_status
    +-------------+
    ```
    """
    scenario = scenario or Scenario()
    builder = DiagramBuilder()
    path, ship, law = add_reference(builder, scenario)
    mpc = builder.AddNamedSystem("mpc", MpcController(scenario.airframe, scenario.mpc))
    airframe = add_airframe(builder, scenario.airframe, scenario.mission.start)
    channel = builder.AddNamedSystem("channel", TwoRayChannel(scenario.link))

    builder.Connect(path.GetOutputPort("position_preview"), mpc.GetInputPort("position_preview"))
    builder.Connect(law.GetOutputPort("attitude_preview"), mpc.GetInputPort("attitude_preview"))
    builder.Connect(mpc.GetOutputPort("rotor_speed_squared"), airframe.GetInputPort("rotor_speed_squared"))
    builder.Connect(airframe.GetOutputPort("vehicle_state"), mpc.GetInputPort("vehicle_state"))
    builder.Connect(airframe.GetOutputPort("vehicle_state"), channel.GetInputPort("vehicle_state"))
    builder.Connect(ship.GetOutputPort("ship_position"), channel.GetInputPort("ship_position"))

    export_outputs(builder, airframe, mpc, channel)
    return build_wired(builder, "closed_loop")
