"""Checks of wiring: a block given in place of another must fit, and nothing may be left unconnected."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, PortDataType, System

# The attribute of a diagram under which it carries the names of the user's own blocks.
_OWN_BLOCKS = "a2s_own_blocks"


class WiringError(ValueError):
    """A diagram with dangling inputs, listed as `block: port`, or a block whose ports do not fit its role."""


def _is_optional(port: InputPort) -> bool:
    """A plant's inputs other than the spatial forces default to zero or stay unused without a scene graph."""
    return isinstance(port.get_system(), MultibodyPlant) and port.get_name() != "applied_spatial_force"


def check_ports(role: str, block: System, inputs: Mapping[str, int], outputs: Mapping[str, int]) -> None:
    """Checks that a block has the ports that its role in a diagram takes; it may have more.

    Args:
      role: the block's name in the diagram, for the message.
      inputs: sizes by name of port.
      outputs: the same.
    Raises:
      WiringError: names the role, the block's class, and each port that does not fit: size found, size wanted.
    """
    ports = (
        ("input", inputs, map(block.get_input_port, range(block.num_input_ports()))),
        ("output", outputs, map(block.get_output_port, range(block.num_output_ports()))),
    )
    misfits = [text for kind, wanted, found in ports for text in _misfits(kind, wanted, found)]
    if misfits:
        # Drake writes a template's scalar type behind this letter into the class name of an instance.
        kind = type(block).__name__.partition("_\N{MATHEMATICAL BOLD SCRIPT CAPITAL T}")[0]
        raise WiringError(f"{role} ({kind}): {'; '.join(misfits)}")


def _misfits(kind: str, wanted: Mapping[str, int], ports: Iterable[Any]) -> Iterator[str]:
    found = {port.get_name(): port for port in ports}
    for name, size in wanted.items():
        if name not in found:
            yield f"no {kind} {name}, which must have size {size}; its {kind}s: {', '.join(found) or 'none'}"
        elif found[name].get_data_type() != PortDataType.kVectorValued:
            yield f"{kind} {name} is abstract, must be a vector of size {size}"
        elif found[name].size() != size:
            yield f"{kind} {name} has size {found[name].size()}, must have {size}"


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


def mark_own_blocks(diagram: Diagram, names: dict[str, str]) -> None:
    """Notes in a diagram which of its blocks are the user's own: block name by role, `{"law": "MyLaw"}`."""
    setattr(diagram, _OWN_BLOCKS, dict(names))


def own_blocks(diagram: Diagram) -> dict[str, str]:
    """The blocks of the user's own in a diagram, as `mark_own_blocks` noted them; empty without any."""
    return dict(getattr(diagram, _OWN_BLOCKS, {}))
