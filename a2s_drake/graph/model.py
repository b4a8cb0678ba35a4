"""A diagram as data: blocks, ports with sizes and units, wires. Every format is drawn from this."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from pydrake.systems.framework import (
    Diagram,
    InputPort,
    InputPortIndex,
    OutputPort,
    OutputPortIndex,
    PortDataType,
    System,
)

from a2s_drake.ports import PORT_UNITS

Side = Literal["in", "out"]


class PortId(NamedTuple):
    """A port by its block's path ("" for the whole, then "airframe", "airframe/plant"), side and name."""

    path: str
    side: Side
    name: str


class Wire(NamedTuple):
    """A connection; an exported port is a wire between a diagram's own port and the port within."""

    source: PortId
    target: PortId


@dataclass(frozen=True)
class Port:
    """A port of a block.

    Attributes:
      size: number of elements; None where the port carries an object rather than a vector.
      unit: what it is measured in, as in `PORT_UNITS`; "" where that is not known.
    """

    id: PortId
    size: int | None
    unit: str = ""

    @property
    def label(self) -> str:
        """The name with size and unit: `ship_position (3) [m]`."""
        return f"{self.id.name} ({self.size_text})" + (f" [{self.unit}]" if self.unit else "")

    @property
    def size_text(self) -> str:
        """The size for a reader."""
        return "abstract" if self.size is None else str(self.size)


@dataclass(frozen=True)
class Block:
    """A system of a diagram, or a diagram with what it holds.

    Attributes:
      path: its place, as in `PortId`.
      kind: its class, without module and scalar type.
      origin: the first part of its class's full name: `a2s_drake`, `drake`, or a package of the user's.
      is_diagram: whether it is one, be it open or closed.
      blocks, wires: what an open diagram holds, in the order of construction; empty for a closed one.
    """

    name: str
    path: str
    kind: str
    origin: str
    is_diagram: bool
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    blocks: tuple["Block", ...] = ()
    wires: tuple[Wire, ...] = ()

    @property
    def is_open(self) -> bool:
        """Whether the blocks within are shown."""
        return bool(self.blocks)

    @property
    def ports(self) -> tuple[Port, ...]:
        """Inputs, then outputs."""
        return self.inputs + self.outputs

    def walk(self) -> Iterator["Block"]:
        """This block and, depth first, all that it holds."""
        yield self
        for block in self.blocks:
            yield from block.walk()

    def all_wires(self) -> list[Wire]:
        """The wires of this block and of all open diagrams in it."""
        return [wire for block in self.walk() for wire in block.wires]


def read_graph(diagram: Diagram, depth: int | None = None, units: Mapping[str, str] | None = None) -> Block:
    """Reads a diagram's blocks and its connection map. The result is the same on every run.

    Args:
      depth: how many levels of diagrams are opened: 0 shows the diagram as one block, 1 its blocks with the diagrams
        among them closed, None all.
      units: units by port name, beside those of `PORT_UNITS`. Ports of other names get the unit of what they are
        wired to.
    Raises:
      ValueError: for a negative depth.
    """
    if depth is not None and depth < 0:
        raise ValueError(f"depth = {depth}: must be at least 0")
    whole = _read(diagram, "", PORT_UNITS | dict(units or {}))
    return close_below(_spread_units(whole), depth)


def full_name(whole: Block, port: PortId) -> str:
    """`airframe/plant.state`; a port of the whole goes by the whole's name."""
    return f"{port.path or whole.name}.{port.name}"


def close_below(block: Block, depth: int | None) -> Block:
    """The block with `depth` levels of diagrams open; all with None."""
    if depth is None:
        return block
    if depth == 0:
        return replace(block, blocks=(), wires=())
    return replace(block, blocks=tuple(close_below(inner, depth - 1) for inner in block.blocks))


def close(block: Block, paths: frozenset[str]) -> Block:
    """The block with the diagrams at some paths closed."""
    if block.path in paths:
        return replace(block, blocks=(), wires=())
    return replace(block, blocks=tuple(close(inner, paths) for inner in block.blocks))


def through_wires(whole: Block) -> list[tuple[PortId, ...]]:
    """The connections from end to end, past the borders of open diagrams.

    Each is the ports that it passes: first the output of a closed block or an input of the whole, last the input of a
    closed block or an output of the whole, between them ports of open diagrams.
    """
    wires = whole.all_wires()
    borders = {block.path for block in whole.walk() if block.is_open and block.path}
    onward: dict[PortId, list[PortId]] = {}
    for wire in wires:
        onward.setdefault(wire.source, []).append(wire.target)

    def follow(passed: tuple[PortId, ...]) -> Iterator[tuple[PortId, ...]]:
        for target in onward.get(passed[-1], []):
            if target.path in borders:
                yield from follow((*passed, target))
            else:
                yield (*passed, target)

    return [chain for source in onward if source.path not in borders for chain in follow((source,))]


def connected(whole: Block) -> set[PortId]:
    """The ports that a wire begins or ends at."""
    return {port for wire in whole.all_wires() for port in wire}


def _read(system: System, path: str, units: Mapping[str, str]) -> Block:
    class_name = system.GetSystemType()
    inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
    outputs = [system.get_output_port(i) for i in range(system.num_output_ports())]
    block = Block(
        name=system.get_name(),
        path=path,
        kind=_short(class_name),
        origin=class_name.replace("::", ".").split(".")[0],
        is_diagram=isinstance(system, Diagram),
        inputs=tuple(_read_port(port, path, "in", units) for port in inputs),
        outputs=tuple(_read_port(port, path, "out", units) for port in outputs),
    )
    if not isinstance(system, Diagram):
        return block
    prefix = f"{path}/" if path else ""
    blocks = tuple(_read(inner, prefix + inner.get_name(), units) for inner in system.GetSystems())
    return replace(block, blocks=blocks, wires=_read_wires(system, path, prefix))


def _read_port(port: InputPort | OutputPort, path: str, side: Side, units: Mapping[str, str]) -> Port:
    size = None if port.get_data_type() == PortDataType.kAbstractValued else port.size()
    return Port(PortId(path, side, port.get_name()), size, units.get(port.get_name(), ""))


def _read_wires(diagram: Diagram, path: str, prefix: str) -> tuple[Wire, ...]:
    """The wires in an order of their own: the connection map's own order changes from run to run."""

    def inner(system: System, side: Side, index: int) -> PortId:
        port = system.get_input_port(index) if side == "in" else system.get_output_port(index)
        return PortId(prefix + system.get_name(), side, port.get_name())

    wires = []
    for i in range(diagram.num_input_ports()):
        name = diagram.get_input_port(i).get_name()
        for system, index in diagram.GetInputPortLocators(InputPortIndex(i)):
            wires.append(Wire(PortId(path, "in", name), inner(system, "in", int(index))))
    place = {system: i for i, system in enumerate(diagram.GetSystems())}
    connections = sorted(
        (place[source], int(output), place[target], int(entry))
        for (target, entry), (source, output) in diagram.connection_map().items()
    )
    systems = diagram.GetSystems()
    for source, output, target, entry in connections:
        wires.append(Wire(inner(systems[source], "out", output), inner(systems[target], "in", entry)))
    for i in range(diagram.num_output_ports()):
        system, index = diagram.get_output_port_locator(OutputPortIndex(i))
        own = PortId(path, "out", diagram.get_output_port(i).get_name())
        wires.append(Wire(inner(system, "out", int(index)), own))
    return tuple(wires)


def _short(class_name: str) -> str:
    """`a2s_drake.two_ray.TwoRayChannel_[float]` and `drake::systems::Gain<double>` without the rest."""
    bare = class_name.split("<")[0].split("[")[0]
    return bare.replace("::", ".").split(".")[-1].removesuffix("_")


def _spread_units(whole: Block) -> Block:
    """Gives ports without a unit that of what they are wired to, as far as it reaches."""
    units = {port.id: port.unit for block in whole.walk() for port in block.ports}
    wires = whole.all_wires()
    grown = True
    while grown:
        grown = False
        for wire in wires:
            for known, unknown in (wire, (wire.target, wire.source)):
                if units[known] and not units[unknown]:
                    units[unknown] = units[known]
                    grown = True

    def fill(block: Block) -> Block:
        return replace(
            block,
            inputs=tuple(replace(port, unit=units[port.id]) for port in block.inputs),
            outputs=tuple(replace(port, unit=units[port.id]) for port in block.outputs),
            blocks=tuple(fill(inner) for inner in block.blocks),
        )

    return fill(whole)
