"""A diagram as a table of blocks and ports, for a terminal."""

import textwrap

from a2s_drake.views.graph.model import Block, Path, Port, PortId, Wire, connected, full_path, wired_to

_HEADER = ("port", "size", "unit", "wired to")
_WIDTH = 110

_Row = tuple[str, str, str, str]


def as_text(whole: Block) -> str:
    """A table: per block its ports with size, unit and the ports that feed it (<-) or that it feeds (->), one a line.

    A port is named `block.port`, a port of the diagram itself by the diagram's name. A sub-diagram's ports are wired
    on both sides of its border. Ports that nothing is wired to are named below the others.
    """
    wires, used = whole.all_wires(), connected(whole)
    rows: dict[Path, list[_Row]] = {}
    for block in whole.walk():
        shown = [port for port in block.ports if port.id in used or block is whole]
        rows[block.path] = [row for port in shown for row in _rows(whole, port, wires)]
    every_row = [_HEADER, *(row for of_block in rows.values() for row in of_block)]
    widths = [max(len(row[column]) for row in every_row) for column in range(3)]
    lines = [_line(_HEADER, widths), "-" * _WIDTH]
    for block in whole.walk():
        lines.append(f"{full_path(whole, block.path)}  ({_kind(block)})")
        lines += [_line(row, widths) for row in rows[block.path]]
        if block is not whole:
            lines += _unwired("in", block.inputs, used) + _unwired("out", block.outputs, used)
    return "\n".join(lines) + "\n"


def _kind(block: Block) -> str:
    return f"{block.kind}, closed" if block.is_diagram and not block.is_open else block.kind


def _rows(whole: Block, port: Port, wires: list[Wire]) -> list[_Row]:
    first, *others = wired_to(whole, port.id, wires) or [""]
    row = (f"  {port.id.side:>3}  {port.id.name}", port.size_text, port.unit, first)
    return [row, *(("", "", "", other) for other in others)]


def _unwired(side: str, ports: tuple[Port, ...], used: set[PortId]) -> list[str]:
    names = ", ".join(port.id.name for port in ports if port.id not in used)
    text = f"{side:>5}  not wired: {names}"
    return textwrap.wrap(text, _WIDTH, subsequent_indent=" " * 7) if names else []


def _line(row: _Row, widths: list[int]) -> str:
    port, size, unit, wired = row
    return f"{port:<{widths[0]}}  {size:>{widths[1]}}  {unit:<{widths[2]}}  {wired}".rstrip()
