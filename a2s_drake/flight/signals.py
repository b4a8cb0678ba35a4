"""Signals of the user's own: the ports that a flight keeps beside its arrays, and the names that they go by."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from pydrake.systems.framework import Context, Diagram, OutputPort, PortDataType, System

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.quoting import quoted
from a2s_drake.common.wiring import WiringError

# What Drake calls a block without a name: its class, maybe with modules before it, and its address in memory.
_MADE_UP = re.compile(r"(?:.*[./:])?([^./:@]+)@[0-9a-f]{16}")


class Signals:
    """Output ports of a diagram, or of blocks at any depth in it, by readable names.

    A port of the diagram itself goes by its own name, `snr_db`; a block's by the block's and its own,
    `mpc.predicted_state`. Where two would share a name, both are told apart by the blocks around them,
    `left.mpc.predicted_state`; where that does not help, by a number at the end, `_2`. A block without a name goes by
    its class. A character that cannot be printed becomes `_`.
    """

    def __init__(self, diagram: Diagram, ports: Sequence[OutputPort]) -> None:
        """The signals of some ports. A port given twice is kept once.

        Raises:
          TypeError: when `ports` is no list, or an entry is no output port; names it.
          WiringError: when a port is abstract, or belongs to no block of the diagram; names it.
        """
        _check_list(ports)
        places = dict(_blocks(diagram, ())) if ports else {}
        found: dict[tuple[System, int], OutputPort] = {}
        for place, port in enumerate(ports):
            _check(f"log[{place}]", port, places, diagram)
            found.setdefault((port.get_system(), port.get_index()), port)
        paths = [(*places[port.get_system()], printable(port.get_name())) for port in found.values()]
        self._ports = dict(zip(_unique_names(paths), found.values(), strict=True))

    def reader(self, context: Context) -> "SignalReader":
        """Reads the signals in a context of the diagram."""
        return SignalReader(self._ports, context)

    def stacked(self, rows: Sequence[Mapping[str, FloatArray]]) -> dict[str, FloatArray]:
        """What was read, one array of shape (n, width) for each signal."""
        shapes = {name: (len(rows), port.size()) for name, port in self._ports.items()}
        return {name: np.array([row[name] for row in rows]).reshape(shape) for name, shape in shapes.items()}


class SignalReader:
    """Reads some ports in one context. The contexts of their blocks are looked up once."""

    def __init__(self, ports: Mapping[str, OutputPort], context: Context) -> None:
        self._ports = [(name, port, port.get_system().GetMyContextFromRoot(context)) for name, port in ports.items()]

    def read(self) -> dict[str, FloatArray]:
        """The present value of each signal, shape (width,)."""
        return {name: np.array(port.Eval(context)) for name, port, context in self._ports}


def printable(text: str) -> str:
    """A text whose characters can all be printed, as names in files must be: the others become `_`."""
    return "".join(letter if letter.isprintable() else "_" for letter in text)


def _blocks(system: System, path: tuple[str, ...]) -> Iterator[tuple[System, tuple[str, ...]]]:
    """A system and all that is inside it, each with the names that lead to it from outside."""
    yield system, path
    if isinstance(system, Diagram):
        for inner in system.GetSystems():
            yield from _blocks(inner, (*path, _name(inner)))


def _name(block: System) -> str:
    name = block.get_name()
    made_up = _MADE_UP.fullmatch(name)
    return made_up[1] if made_up else printable(name)


def _check_list(ports: Any) -> None:
    if isinstance(ports, Iterable) and not isinstance(ports, str | bytes):
        return
    what = f"{_name(ports.get_system())}.{ports.get_name()}" if isinstance(ports, OutputPort) else ports
    raise TypeError(f"log = {quoted(what)}: must be a list of output ports, [port] for a single one")


def _check(entry: str, port: Any, places: Mapping[System, tuple[str, ...]], diagram: Diagram) -> None:
    if not isinstance(port, OutputPort):
        raise TypeError(f"{entry} = {quoted(port)}: must be an output port of the diagram or of a block in it")
    name = f"{_name(port.get_system())}.{port.get_name()}"
    if port.get_system() not in places:
        raise WiringError(f"{entry} = {quoted(name)}: belongs to no block of the diagram {quoted(diagram.get_name())}")
    if port.get_data_type() != PortDataType.kVectorValued:
        raise WiringError(f"{entry} = {quoted(name)}: is abstract, must be vector-valued")


def _unique_names(paths: Sequence[tuple[str, ...]]) -> list[str]:
    short = [".".join(path[-2:]) for path in paths]
    shared = Counter(short)
    names: dict[str, None] = {}
    for path, name in zip(paths, short, strict=True):
        wanted = name if shared[name] == 1 else ".".join(path)
        number, unique = 1, wanted
        while unique in names:
            number += 1
            unique = f"{wanted}_{number}"
        names[unique] = None
    return list(names)
