"""The mission's loop with something put wrong in it for a while."""

from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, InputPort, LeafSystem, OutputPort

from a2s_drake import MpcController, Scenario, build_wired
from a2s_drake.common.wiring import NamedWiring
from a2s_drake.control.ladder import Planner
from diagrams import Blocks, build_closed_loop

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

    def controller(_: Scenario) -> Diagram:
        builder = DiagramBuilder()
        wiring = NamedWiring(builder)
        mpc = MpcController(scenario.airframe, scenario.mpc, planner)

        def tamper(port: InputPort | OutputPort) -> None:
            name = port.get_name()
            if name in changes:
                block = Tamper(port.size(), changes[name], start, end)
                wiring.add(f"tamper_{name}", block, {"genuine": name}, {"tampered": name})

        for i in range(mpc.num_input_ports()):
            tamper(mpc.get_input_port(i))
        wiring.add("mpc", mpc)
        tamper(mpc.GetOutputPort("rotor_speed_squared"))
        wiring.export(outputs={"rotor_speed_squared", "predicted_state", "solver_status"})
        return build_wired(builder, "tampered")

    return build_closed_loop(scenario, blocks=Blocks(controller=controller))
