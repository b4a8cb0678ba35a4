"""The last step of every builder: nothing may be left unconnected."""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, System


class WiringError(ValueError):
    """A diagram with dangling inputs; the message lists each as `block: port`."""


def _is_optional(port: InputPort) -> bool:
    """A plant's inputs other than the spatial forces default to zero or stay unused without a scene graph."""
    return isinstance(port.get_system(), MultibodyPlant) and port.get_name() != "applied_spatial_force"


def export_outputs(builder: DiagramBuilder, *systems: System) -> None:
    """Exports every output port of some systems under the port's own name."""
    for system in systems:
        for port in map(system.get_output_port, range(system.num_output_ports())):
            builder.ExportOutput(port, port.get_name())


def build_wired(builder: DiagramBuilder, name: str) -> Diagram:
    """Builds a diagram after a check that every input port in it is connected or exported.

    Raises:
      WiringError: when some are not.
    """
    dangling = [
        f"{system.get_name()}: {port.get_name()}"
        for system in builder.GetSystems()
        for port in map(system.get_input_port, range(system.num_input_ports()))
        if not builder.IsConnectedOrExported(port) and not _is_optional(port)
    ]
    if dangling:
        raise WiringError(f"{name} leaves inputs unconnected: {', '.join(dangling)}")
    diagram = builder.Build()
    diagram.set_name(name)
    return diagram
