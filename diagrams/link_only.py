"""The link of a vehicle that is always exactly where and how it should be: no dynamics, no controller."""

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import ConstantVectorSource, Multiplexer

from a2s_drake.common.wiring import build_wired, export_outputs
from a2s_drake.link.two_ray import TwoRayChannel
from a2s_drake.scenario.scenario import Scenario

from .reference import add_reference


def build_link_only(scenario: Scenario | None = None, law: System | None = None) -> Diagram:
    """Ideal tracking of a scenario (Table I by default); the vehicle's velocities read zero.

    A block with the ports of `AttitudeReference`, made for this diagram alone, may stand in for the scenario's law.

    ```
    +-----------+
    |           |--> vehicle_state
    | link_only |--> position_reference, attitude_reference, ship_position
    |           |--> channel_gain, snr_db, spectral_efficiency, phase_difference
    +-----------+
    ```

    Raises:
      WiringError: when the law's ports do not fit; names them, with the sizes found and wanted.
    """
    scenario = scenario or Scenario()
    builder = DiagramBuilder()
    path, ship, law = add_reference(builder, scenario, law)
    velocities = builder.AddNamedSystem("velocities", ConstantVectorSource(np.zeros(6)))
    state = builder.AddNamedSystem("vehicle_state", Multiplexer([3, 3, 6]))
    channel = builder.AddNamedSystem("channel", TwoRayChannel(scenario.link))

    builder.Connect(path.GetOutputPort("position_reference"), state.get_input_port(0))
    builder.Connect(law.GetOutputPort("attitude_reference"), state.get_input_port(1))
    builder.Connect(velocities.get_output_port(), state.get_input_port(2))
    builder.Connect(state.get_output_port(), channel.GetInputPort("vehicle_state"))
    builder.Connect(ship.GetOutputPort("ship_position"), channel.GetInputPort("ship_position"))

    builder.ExportOutput(state.get_output_port(), "vehicle_state")
    export_outputs(builder, channel)
    return build_wired(builder, "link_only")
