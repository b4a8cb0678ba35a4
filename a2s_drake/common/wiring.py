"""Checks of wiring: a block given in place of another must fit, and nothing may be left unconnected."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, OutputPort, PortDataType, System

# The attribute of a diagram under which it carries the names of the user's own blocks.
_OWN_BLOCKS = "a2s_own_blocks"
# The attribute under which a diagram carries the track files that its blocks were built from.
_TRACK_FILES = "a2s_track_files"


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
    ports = (("input", inputs, input_ports(block)), ("output", outputs, output_ports(block)))
    misfits = [text for kind, wanted, found in ports for text in _misfits(kind, wanted, found)]
    if misfits:
        raise WiringError(f"{role} ({class_name(block)}): {'; '.join(misfits)}")


def class_name(block: System) -> str:
    """The name of a block's class, without the scalar type of a template."""
    # Drake writes a template's scalar type behind this letter into the class name of an instance.
    return type(block).__name__.partition("_\N{MATHEMATICAL BOLD SCRIPT CAPITAL T}")[0]


def _misfits(kind: str, wanted: Mapping[str, int], ports: Iterable[Any]) -> Iterator[str]:
    found = {port.get_name(): port for port in ports}
    for name, size in wanted.items():
        if name not in found:
            yield f"no {kind} {name}, which must have size {size}; its {kind}s: {', '.join(found) or 'none'}"
        elif found[name].get_data_type() != PortDataType.kVectorValued:
            yield f"{kind} {name} is abstract, must be a vector of size {size}"
        elif found[name].size() != size:
            yield f"{kind} {name} has size {found[name].size()}, must have {size}"


def input_ports(block: System) -> list[InputPort]:
    """The inputs of a block, in order."""
    return [block.get_input_port(i) for i in range(block.num_input_ports())]


def output_ports(block: System) -> list[OutputPort]:
    """The outputs of a block, in order."""
    return [block.get_output_port(i) for i in range(block.num_output_ports())]


class NamedWiring:
    """Wires the blocks of a diagram by the names of their signals.

    An input gets the signal of its own name. Of several blocks that give it, the last one added before counts. Where
    there is none, it is the first one added later; and where there is none at all, the diagram gets such an input. So a
    block that gives the same signal as one before it takes that one's place for all that come after.
    """

    def __init__(self, builder: DiagramBuilder) -> None:
        self._builder = builder
        self._outputs: dict[str, OutputPort] = {}
        self._open: list[tuple[str, InputPort, str]] = []

    def add(
        self,
        name: str,
        block: System,
        inputs: Mapping[str, str] | None = None,
        outputs: Mapping[str, str] | None = None,
    ) -> System:
        """Adds a block under a name and wires its inputs.

        Args:
          inputs: the signal that an input takes, by the port's name, where the two names differ.
          outputs: the signal that an output gives, in the same way.
        Raises:
          WiringError: where a signal does not fit an input.
        """
        what = f"{name} ({class_name(block)})"
        self._builder.AddNamedSystem(name, block)
        takes, gives = inputs or {}, outputs or {}
        still_open = []
        for port in input_ports(block):
            if _is_optional(port) or self._builder.IsConnectedOrExported(port):
                continue
            signal = takes.get(port.get_name(), port.get_name())
            if signal in self._outputs:
                self._connect(signal, port, what)
            else:
                still_open.append((signal, port, what))
        # A block's own outputs are no answer to its inputs, but to those that were open before it.
        new = {gives.get(port.get_name(), port.get_name()): port for port in output_ports(block)}
        waiting, self._open = self._open, []
        self._outputs |= new
        for signal, port, whose in waiting:
            if signal in new:
                self._connect(signal, port, whose)
            else:
                self._open.append((signal, port, whose))
        self._open += still_open
        return block

    def export(self, given: Diagram | None = None, outputs: Collection[str] | None = None) -> None:
        """Makes the inputs that are still open, and outputs, ports of the diagram, each named after its signal.

        Args:
          given: the only diagram that the inputs can come from; anything may be asked for without it.
          outputs: the signals to show; all of them without it.
        Raises:
          WiringError: for an input that nothing gives; names its block.
        """
        exported: dict[str, int] = {}
        for signal, port, what in self._open:
            if given is not None and not given.HasOutputPort(signal):
                raise WiringError(f"{what}: input {signal}: no other block there gives it, nor does {given.get_name()}")
            if signal not in exported:
                self._builder.ExportInput(port, signal)
                exported[signal] = port.size()
                continue
            if port.size() != exported[signal]:
                raise WiringError(f"{what}: input {signal} has size {port.size()}, must have {exported[signal]}")
            self._builder.ConnectInput(signal, port)
        for name, output in self._outputs.items():
            if outputs is None or name in outputs:
                self._builder.ExportOutput(output, name)

    def _connect(self, signal: str, port: InputPort, what: str) -> None:
        connect_fitting(self._builder, self._outputs[signal], port, what)


def connect_fitting(builder: DiagramBuilder, output: OutputPort, port: InputPort, what: str) -> None:
    """Connects two ports.

    Raises:
      WiringError: where one is abstract and the other is not, or their sizes differ; `what` names the input's block.
    """
    name = port.get_name()
    if output.get_data_type() != port.get_data_type():
        raise WiringError(f"{what}: input {name} and its signal must both be vectors, or both abstract")
    if output.size() != port.size():
        raise WiringError(f"{what}: input {name} has size {port.size()}, must have {output.size()}")
    builder.Connect(output, port)


def export_outputs(builder: DiagramBuilder, *systems: System) -> None:
    """Exports every output port of some systems under the port's own name."""
    for system in systems:
        for port in output_ports(system):
            builder.ExportOutput(port, port.get_name())


def build_wired(builder: DiagramBuilder, name: str) -> Diagram:
    """Builds a diagram after a check that every input port in it is connected or exported.

    Raises:
      WiringError: when some are not, or Drake cannot build it.
    """
    dangling = [
        f"{system.get_name()}: {port.get_name()}"
        for system in builder.GetSystems()
        for port in input_ports(system)
        if not builder.IsConnectedOrExported(port) and not _is_optional(port)
    ]
    if dangling:
        raise WiringError(f"{name} leaves inputs unconnected: {', '.join(dangling)}")
    try:
        diagram = builder.Build()
    except RuntimeError as error:  # for an algebraic loop, and for a block that is part of another diagram
        raise WiringError(f"{name} cannot be built: {error}") from error
    diagram.set_name(name)
    return diagram


def find_block(diagram: Diagram, name: str) -> System:
    """The block of a name in a diagram, at any depth.

    Raises:
      WiringError: where there is none, or more than one.
    """
    found = list(_named(diagram, name))
    if len(found) != 1:
        raise WiringError(f"{diagram.get_name()}: there are {len(found)} blocks called {name}, must be one")
    return found[0]


def _named(diagram: Diagram, name: str) -> Iterator[System]:
    for block in diagram.GetSystems():
        if block.get_name() == name:
            yield block
        if isinstance(block, Diagram):
            yield from _named(block, name)


def mark_own_blocks(diagram: Diagram, names: dict[str, str]) -> None:
    """Notes in a diagram which of its blocks are the user's own: block name by role, `{"law": "MyLaw"}`."""
    setattr(diagram, _OWN_BLOCKS, dict(names))


def own_blocks(diagram: Diagram) -> dict[str, str]:
    """The blocks of the user's own in a diagram and in those within it, name by role; empty without any.

    A diagram that no builder of this library made is the user's own as a whole: its role is `diagram`.
    """
    parts = [block for block in diagram.GetSystems() if isinstance(block, Diagram)]
    own: dict[str, str] = getattr(diagram, _OWN_BLOCKS, {"diagram": diagram.get_name() or class_name(diagram)})
    return {role: name for part in parts if hasattr(part, _OWN_BLOCKS) for role, name in own_blocks(part).items()} | own


def mark_track_files(diagram: Diagram, files: Mapping[str, bytes]) -> None:
    """Notes in a diagram the content of the track files that its blocks were built from, by field of `mission`."""
    setattr(diagram, _TRACK_FILES, dict(files))


def track_files(diagram: Diagram) -> dict[str, bytes] | None:
    """The track files that a diagram was built from, as `mark_track_files` noted them; None where no builder did.

    A diagram that a user builds around one with such a note was built from the same files.
    """
    files: dict[str, bytes] | None = getattr(diagram, _TRACK_FILES, None)
    if files is not None:
        return dict(files)
    inner = [track_files(block) for block in diagram.GetSystems() if isinstance(block, Diagram)]
    noted = [found for found in inner if found is not None]
    return {field: content for found in noted for field, content in found.items()} if noted else None
