"""A diagram as data: blocks, ports with sizes and units, wires. Every format is drawn from this."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

from pydrake.systems.framework import Diagram_, InputPortIndex, OutputPortIndex, PortDataType

from a2s_drake.common.signals import DRAKE_PORT_UNITS, PORT_UNITS
from a2s_drake.common.wiring import input_ports, output_ports
from a2s_drake.views.graph.names import block_names, class_name

Path = tuple[str, ...]
"""A block's place: () is the whole, ("airframe",) a block in it, ("airframe", "plant") a block in that."""

Side = Literal["in", "out"]

_DIAGRAMS = tuple(Diagram_[scalar] for (scalar,) in Diagram_.param_list)


class PortId(NamedTuple):
    """A port by its block's path, side and name."""

    path: Path
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
      name: its own, or its class and number where its maker gave it none.
      kind: its class, without module and scalar type.
      origin: the first part of its class's full name: `a2s_drake`, `drake`, or a package of the user's.
      is_diagram: whether it is one, be it open or closed.
      blocks, wires: what an open diagram holds, in the order of construction; empty for a closed one.
    """

    name: str
    path: Path
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


def read_graph(diagram: Any, depth: int | None = None, units: Mapping[str, str] | None = None) -> Block:
    """Reads a diagram's blocks and its connection map. The result is the same on every run.

    Args:
      diagram: a Drake diagram, of any scalar type.
      depth: how many levels of diagrams are opened: 0 shows the diagram as one block, 1 its blocks with the diagrams
        among them closed, None all.
      units: units by port name, for blocks of one's own. Ports for which neither these nor `PORT_UNITS` give one get
        the unit of what they are wired to.
    Raises:
      ValueError: for a negative depth.
    """
    if depth is not None and depth < 0:
        raise ValueError(f"depth = {depth}: must be at least 0")
    whole = _read(diagram, (), diagram.get_name() or "diagram", units or {})
    return close_below(_spread_units(whole), depth)


def full_name(whole: Block, port: PortId) -> str:
    """`airframe/plant.state`; a port of the whole goes by the whole's name."""
    return f"{full_path(whole, port.path)}.{port.name}"


def full_path(whole: Block, path: Path) -> str:
    """`airframe/plant`; the whole goes by its name, which it sets apart from a block of the same name in it."""
    if path:
        return "/".join(f"[{name}]" if "/" in name else name for name in path)
    return f"{whole.name} (whole)" if any(block.name == whole.name for block in whole.blocks) else whole.name


def wired_to(whole: Block, port: PortId, wires: Sequence[Wire]) -> list[str]:
    """What a port is wired to, for a reader: `<- block.port` feeds it, `-> block.port` it feeds."""
    feeding = [f"<- {full_name(whole, wire.source)}" for wire in wires if wire.target == port]
    return feeding + [f"-> {full_name(whole, wire.target)}" for wire in wires if wire.source == port]


def close_below(block: Block, depth: int | None) -> Block:
    """The block with `depth` levels of diagrams open; all with None."""
    if depth is None:
        return block
    if depth == 0:
        return replace(block, blocks=(), wires=())
    return replace(block, blocks=tuple(close_below(inner, depth - 1) for inner in block.blocks))


def close(block: Block, paths: frozenset[Path]) -> Block:
    """The block with the diagrams at some paths closed."""
    if block.path in paths:
        return replace(block, blocks=(), wires=())
    return replace(block, blocks=tuple(close(inner, paths) for inner in block.blocks))


def through_wires(whole: Block) -> list[tuple[PortId, ...]]:
    """The connections from end to end, past the borders of open diagrams.

    A connection is the ports that it passes. The first is the output of a closed block or an input of the whole. The
    last is the input of a closed block or an output of the whole. Those between are ports of open diagrams.
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


def _read(system: Any, path: Path, name: str, units: Mapping[str, str]) -> Block:
    kind, origin = class_name(system)
    inputs, outputs = input_ports(system), output_ports(system)

    def read_port(port: Any, side: Side) -> Port:
        own = port.get_name()
        known = PORT_UNITS.get(own, "") if origin == "a2s_drake" else DRAKE_PORT_UNITS.get((kind, own), "")
        size = None if port.get_data_type() == PortDataType.kAbstractValued else port.size()
        return Port(PortId(path, side, own), size, known or units.get(own, ""))

    block = Block(
        name=name,
        path=path,
        kind=kind,
        origin=origin,
        is_diagram=isinstance(system, _DIAGRAMS),
        inputs=tuple(read_port(port, "in") for port in inputs),
        outputs=tuple(read_port(port, "out") for port in outputs),
    )
    if not block.is_diagram:
        return block
    systems = system.GetSystems()
    names = block_names(systems)
    blocks = tuple(_read(inner, (*path, own), own, units) for inner, own in zip(systems, names, strict=True))
    return replace(block, blocks=blocks, wires=_read_wires(system, path, names))


def _read_wires(diagram: Any, path: Path, names: Sequence[str]) -> tuple[Wire, ...]:
    """The wires in an order of their own: the connection map's own order changes from run to run."""
    systems = diagram.GetSystems()
    place = {system: i for i, system in enumerate(systems)}

    def inner(number: int, side: Side, index: int) -> PortId:
        system = systems[number]
        port = system.get_input_port(index) if side == "in" else system.get_output_port(index)
        return PortId((*path, names[number]), side, port.get_name())

    wires = []
    for i in range(diagram.num_input_ports()):
        own = PortId(path, "in", diagram.get_input_port(i).get_name())
        for system, index in diagram.GetInputPortLocators(InputPortIndex(i)):
            wires.append(Wire(own, inner(place[system], "in", int(index))))
    connections = sorted(
        (place[source], int(output), place[target], int(entry))
        for (target, entry), (source, output) in diagram.connection_map().items()
    )
    for source, output, target, entry in connections:
        wires.append(Wire(inner(source, "out", output), inner(target, "in", entry)))
    for i in range(diagram.num_output_ports()):
        system, index = diagram.get_output_port_locator(OutputPortIndex(i))
        own = PortId(path, "out", diagram.get_output_port(i).get_name())
        wires.append(Wire(inner(place[system], "out", int(index)), own))
    return tuple(wires)


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
