"""Diagrams around `link_only`, with ports and blocks that it does not have itself."""

from collections.abc import Callable, Mapping

import numpy as np
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, LeafSystem, System

from a2s_drake import Scenario, build_wired
from a2s_drake.common.wiring import export_outputs
from diagrams import build_link_only

EVERY_DIAGRAM_EXPORTS = (
    *("vehicle_state", "position_reference", "attitude_reference", "ship_position"),
    *("channel_gain", "snr_db", "spectral_efficiency", "phase_difference"),
)


class FunctionOfTime(LeafSystem):
    """Puts out a function of time, under a port's name of one's own."""

    def __init__(self, port: str, size: int, function: Callable[[float], object]) -> None:
        LeafSystem.__init__(self)
        self._function = function
        self.DeclareVectorOutputPort(port, size, self._calc, {self.time_ticket()})

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(np.ravel(self._function(context.get_time())))


class Sampled(LeafSystem):
    """Puts out a function of the time of its last update; before the first one, `start`."""

    def __init__(self, port: str, period: float, function: Callable[[float], object], start: object) -> None:
        LeafSystem.__init__(self)
        self._function = function
        self._held = self.DeclareDiscreteState(np.ravel(start))
        self.DeclareStateOutputPort(port, self._held)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, state) -> None:
        state.set_value(self._held, np.ravel(self._function(context.get_time())))


def extended_link(scenario: Scenario, *exported: System, inside: Mapping[str, System] | None = None) -> Diagram:
    """`link_only` with what every diagram exports, the outputs of more blocks, and blocks inside that show none."""
    builder = DiagramBuilder()
    link = builder.AddNamedSystem("link", build_link_only(scenario))
    for block in exported:
        builder.AddSystem(block)
    for name, block in (inside or {}).items():
        builder.AddNamedSystem(name, block)
    for name in EVERY_DIAGRAM_EXPORTS:
        builder.ExportOutput(link.GetOutputPort(name), name)
    export_outputs(builder, *exported)
    return build_wired(builder, "extended")


def nested(block: System, name: str, around: str) -> Diagram:
    """A named block in a diagram of another name, which exports its outputs."""
    builder = DiagramBuilder()
    builder.AddNamedSystem(name, block)
    export_outputs(builder, block)
    return build_wired(builder, around)
