"""A diagram in Graphviz' language, and the SVG that Graphviz makes of it."""

import html
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence

from a2s_drake.common.packages import is_installed
from a2s_drake.views.graph.model import Block, Path, Port, PortId, connected, full_name, through_wires

_FILL = {"a2s_drake": "#d7e8f7", "drake": "#e9e9e9", "diagram": "#fbe9c6"}
_FILL_OF_OTHERS = "#dff0d8"

# Read by a Python process of its own: the libraries of the wheel write warnings about fonts past Python's stderr.
_BY_WHEEL = """
import json, pygraphviz, sys
pictures = [pygraphviz.AGraph(string=text).draw(format="svg", prog="dot").decode() for text in json.load(sys.stdin)]
json.dump(pictures, sys.stdout)
"""

_STYLE = """<style>
.wire:hover path { stroke: #c0392b; stroke-width: 3; }
.wire:hover polygon { stroke: #c0392b; fill: #c0392b; }
</style>"""


class GraphvizError(RuntimeError):
    """Graphviz could not draw a diagram."""


class GraphvizMissing(GraphvizError):
    """Neither the `dot` program nor pygraphviz, whose wheels bring Graphviz along, is installed."""


def as_dot(whole: Block) -> str:
    """The diagram for Graphviz, left to right: blocks as tables of their wired ports, open diagrams as boxes.

    Block i of `whole.walk()` has the id `block-i`, wire i of `through_wires(whole)` the id `wire-i`.
    """
    chains = through_wires(whole)
    used = connected(whole)
    ids = {block.path: f"block-{i}" for i, block in enumerate(whole.walk())}
    cells = {port.id: f"port-{i}" for i, port in enumerate(p for block in whole.walk() for p in block.ports)}
    ports = {port.id: port for block in whole.walk() for port in block.ports}
    lines = [
        f"digraph {_quote(whole.name)} {{",
        '  graph [rankdir=LR, ranksep=0.9, nodesep=0.35, fontname="Helvetica", fontsize=12]',
        '  node [shape=plain, fontname="Helvetica", fontsize=10]',
        '  edge [color="#44546a", arrowsize=0.6, penwidth=1.2]',
    ]
    if not whole.is_open:
        lines += [f"  {line}" for line in _table(whole, whole.ports, ids, cells)]
    else:
        lines += [f"  {line}" for block in whole.blocks for line in _box(block, used, ids, cells)]
        lines += _border(whole, "inputs", whole.inputs, cells) + _border(whole, "outputs", whole.outputs, cells)
    order = list(ids)
    for i, chain in enumerate(chains):
        names = " -> ".join(full_name(whole, port) for port in chain)
        tooltip = f"{ports[chain[0]].label}\n{names}"
        # Blocks stand in the order in which they were added, so wires that lead back do not decide on places.
        ends = [order.index(port.path) for port in (chain[0], chain[-1])]
        back = ", constraint=false" if chain[-1].path and ends[0] >= ends[1] else ""
        lines.append(
            f"  {_end(chain[0], ids, cells)}:e -> {_end(chain[-1], ids, cells)}:w "
            f'[id="wire-{i}", class=wire, tooltip={_quote(tooltip)}{back}]'
        )
    return "\n".join([*lines, "}"]) + "\n"


def as_svg(whole: Block) -> str:
    """The picture, with a tooltip on every wire.

    Raises:
      GraphvizError: when Graphviz fails; GraphvizMissing: when there is none.
    """
    return draw([as_dot(whole)])[0]


def draw(texts: Sequence[str]) -> list[str]:
    """SVG documents of graphs in Graphviz' language, by the `dot` program where there is one, else by pygraphviz.

    Raises:
      GraphvizError: when it fails, with its words; GraphvizMissing: when there is neither.
    """
    program = shutil.which("dot")
    if program is not None:
        drawn = _run([program, "-Tsvg"], "\n".join(texts))
        pictures = ["<?xml" + part for part in drawn.split("<?xml")[1:]]
    else:
        if not is_installed("pygraphviz"):
            raise GraphvizMissing(
                "SVG and HTML need Graphviz: its program `dot`, or the package pygraphviz, which comes with the extra "
                "a2s_drake[graph]"
            )
        pictures = json.loads(_run([sys.executable, "-c", _BY_WHEEL], json.dumps(list(texts))))
    return [re.sub(r"(<svg\b[^>]*>)", lambda match: match[1] + _STYLE, picture, count=1) for picture in pictures]


def _run(command: list[str], text: str) -> str:
    done = subprocess.run(command, input=text, capture_output=True, text=True, encoding="utf-8", check=False)
    # It also tells of errors in a label and goes on to draw without it.
    if done.returncode or "rror: " in done.stderr:
        raise GraphvizError(f"Graphviz could not draw the diagram: {done.stderr.strip()}")
    return done.stdout


def _box(block: Block, used: set[PortId], ids: dict[Path, str], cells: dict[PortId, str]) -> list[str]:
    if not block.is_open:
        return _table(block, tuple(port for port in block.ports if port.id in used), ids, cells)
    style = f'style="rounded,filled"; fillcolor="{_FILL["diagram"]}80"; color="#c9a227"'
    inner = [f"  {line}" for child in block.blocks for line in _box(child, used, ids, cells)]
    own = f'"cluster {ids[block.path]}"'
    label = f"<<B>{_text(block.name)}</B>>"
    return [f"subgraph {own} {{", f'  id="{ids[block.path]}"; class=diagram; label={label}; {style}', *inner, "}"]


def _table(block: Block, ports: tuple[Port, ...], ids: dict[Path, str], cells: dict[PortId, str]) -> list[str]:
    """A block: its name over its ports, inputs left, outputs right."""
    fill = _FILL.get("diagram" if block.is_diagram else block.origin, _FILL_OF_OTHERS)
    inputs = [port for port in ports if port.id.side == "in"]
    outputs = [port for port in ports if port.id.side == "out"]
    head = f'<B>{_text(block.name)}</B><BR/><FONT POINT-SIZE="9">{_text(block.kind)}</FONT>'
    columns = [(side, align) for side, align in ((inputs, "LEFT"), (outputs, "RIGHT")) if side]
    rows = [f'<TR><TD COLSPAN="{max(len(columns), 1)}" BGCOLOR="{fill}" CELLPADDING="5">{head}</TD></TR>']
    for i in range(max(len(inputs), len(outputs))):
        row = [_cell(side[i], align, cells) if i < len(side) else '<TD BORDER="0"></TD>' for side, align in columns]
        rows.append(f"<TR>{''.join(row)}</TR>")
    label = f'<TABLE BORDER="0" CELLBORDER="1" CELLSPACING="0" COLOR="#8895a7">{"".join(rows)}</TABLE>'
    kind = "closed" if block.is_diagram else "block"
    own = ids[block.path]
    return [f'"{own}" [id="{own}", class={kind}, tooltip={_quote(f"{block.name}: {block.kind}")}, label=<{label}>]']


def _cell(port: Port, align: str, cells: dict[PortId, str]) -> str:
    size = f'<FONT COLOR="#7a7a7a" POINT-SIZE="8"> {port.size_text}</FONT>'
    style = f'ALIGN="{align}" BGCOLOR="white" CELLPADDING="3"'
    return f'<TD PORT="{cells[port.id]}" {style}>{_text(port.id.name)}{size}</TD>'


def _border(whole: Block, name: str, ports: tuple[Port, ...], cells: dict[PortId, str]) -> list[str]:
    """The diagram's own inputs or outputs, at the left or right margin."""
    if not ports:
        return []
    rows = "".join(f"<TR>{_cell(port, 'LEFT', cells)}</TR>" for port in ports)
    head = f'<TR><TD BORDER="0"><I>{name}</I></TD></TR>'
    label = f'<TABLE BORDER="0" CELLBORDER="1" CELLSPACING="0" COLOR="#c3c9d1">{head}{rows}</TABLE>'
    rank = "source" if name == "inputs" else "sink"
    tooltip = _quote(f"{name} of {whole.name}")
    return [f'  {{rank={rank}; "{name}" [id="{name}", class=border, tooltip={tooltip}, label=<{label}>]}}']


def _end(port: PortId, ids: dict[Path, str], cells: dict[PortId, str]) -> str:
    node = ids[port.path] if port.path else f"{port.side}puts"
    return f'"{node}":"{cells[port]}"'


def _text(name: str) -> str:
    """A name in a label, where Graphviz reads entities, and a backslash as the start of an escape of its own."""
    return html.escape(name).replace("\\", "\\\\") or " "


def _quote(text: str) -> str:
    # Graphviz reads the escapes of a tooltip twice over.
    escaped = text.replace("\\", 4 * "\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
