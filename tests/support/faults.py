"""The mission's loop with something put wrong in it for a while."""

from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, LeafSystem, OutputPort

from a2s_drake import MpcController, Scenario, build_wired
from a2s_drake.common.wiring import export_outputs
from a2s_drake.control.ladder import Planner
from a2s_drake.link.two_ray import TwoRayChannel
from a2s_drake.vehicle.airframe import add_airframe
from diagrams.reference import add_reference

Change = Callable[[np.ndarray], np.ndarray]


class Tamper(LeafSystem):
    """Passes a signal on, but from `start` until `end` (s) changes it first."""

    def __init__(self, size: int, change: Change, start: float, end: float = np.inf) -> None:
        LeafSystem.__init__(self)
        self._span, self._change = (start, end), change
        self._genuine = self.DeclareVectorInputPort("genuine", size)
        self.DeclareVectorOutputPort("tampered", size, self._calc_tampered)

    def _calc_tampered(self, context: Context, output: BasicVector) -> None:
        start, end = self._span
        genuine = self._genuine.Eval(context).copy()
        # Half a nanosecond, so that rounding of sample times does not move the span.
        wrong = start - 5e-10 <= context.get_time() < end - 5e-10
        output.SetFromVector(self._change(genuine) if wrong else genuine)


def faulty_loop(
    scenario: Scenario,
    start: float = 0.0,
    end: float = np.inf,
    *,
    planner: Planner | None = None,
    **changes: Change,
) -> Diagram:
    """The closed loop with signals tampered with: `vehicle_state` (as measured), `position_preview`,
    `attitude_preview`, `rotor_speed_squared`."""
    builder = DiagramBuilder()
    path, ship, law = add_reference(builder, scenario)
    mpc = builder.AddNamedSystem("mpc", MpcController(scenario.airframe, scenario.mpc, planner))
    airframe = add_airframe(builder, scenario.airframe, scenario.mission.start)
    channel = builder.AddNamedSystem("channel", TwoRayChannel(scenario.link))

    def through(signal: OutputPort) -> OutputPort:
        if signal.get_name() not in changes:
            return signal
        name = f"tamper_{signal.get_name()}"
        tamper = builder.AddNamedSystem(name, Tamper(signal.size(), changes[signal.get_name()], start, end))
        builder.Connect(signal, tamper.get_input_port())
        return tamper.get_output_port()

    builder.Connect(through(path.GetOutputPort("position_preview")), mpc.GetInputPort("position_preview"))
    builder.Connect(through(law.GetOutputPort("attitude_preview")), mpc.GetInputPort("attitude_preview"))
    builder.Connect(through(mpc.GetOutputPort("rotor_speed_squared")), airframe.GetInputPort("rotor_speed_squared"))
    builder.Connect(through(airframe.GetOutputPort("vehicle_state")), mpc.GetInputPort("vehicle_state"))
    builder.Connect(airframe.GetOutputPort("vehicle_state"), channel.GetInputPort("vehicle_state"))
    builder.Connect(ship.GetOutputPort("ship_position"), channel.GetInputPort("ship_position"))
    export_outputs(builder, airframe, mpc, channel)
    return build_wired(builder, "faulty_loop")
