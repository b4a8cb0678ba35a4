"""A diagram as one self-contained page: sub-diagrams fold, wires and blocks tell of themselves under the pointer."""

import html
import json
import re
from importlib.resources import files
from itertools import product
from typing import Any

from a2s_drake.views.graph.dot import as_dot, draw
from a2s_drake.views.graph.model import Block, Path, PortId, close, full_name, full_path, through_wires, wired_to

MAX_PICTURES = 64


def as_html(whole: Block) -> str:
    """The page. It holds a picture of every way to fold the open sub-diagrams, and a table of all ports.

    Of diagrams with more than `MAX_PICTURES` ways it holds those that fold one sub-diagram, or a whole level.

    Raises:
      GraphvizError: when Graphviz fails; GraphvizMissing: when there is none.
    """
    ways = foldings(whole)
    folded = [close(whole, closed) for closed in ways]
    drawings = draw([as_dot(block) for block in folded])
    pictures = [
        {"closed": [_key(path) for path in sorted(closed)], "svg": svg[svg.index("<svg") :], **_facts(block)}
        for closed, block, svg in zip(ways, folded, drawings, strict=True)
    ]
    diagrams = [{"key": _key(block.path), "name": full_path(whole, block.path)} for block in _diagrams(whole)]
    data = {"diagrams": diagrams, "all": _count(whole) == len(ways), "pictures": pictures}
    # In a script element only "</" could be taken for its end.
    text = json.dumps(data, ensure_ascii=False).replace("</", "<\\/")
    parts = {"TITLE": html.escape(whole.name), "TABLES": _table(whole), "DATA": text}
    page = files("a2s_drake.views.graph").joinpath("page.html").read_text(encoding="utf-8")
    return re.sub("@(TITLE|TABLES|DATA)@", lambda match: parts[match[1]], page)


def foldings(whole: Block, limit: int = MAX_PICTURES) -> list[frozenset[Path]]:
    """The ways to fold a diagram, each the paths of the closed sub-diagrams; first the one with all of them open.

    When there are more than `limit`, only those that close one of the first `limit` sub-diagrams, and those that close
    all of a level.
    """
    if _count(whole) <= limit:
        return _ways(whole)
    paths = [block.path for block in _diagrams(whole)]
    levels = [frozenset(path for path in paths if len(path) == level) for level in sorted({*map(len, paths)})]
    return list(dict.fromkeys([frozenset[Path](), *(frozenset([path]) for path in paths[:limit]), *levels]))


def _key(path: Path) -> str:
    """A path for the page's script: no other path begins with these characters but those of blocks within."""
    return "".join(f"{name}\0" for name in path)


def _count(block: Block) -> int:
    count = 1
    for child in block.blocks:
        if child.is_open:
            count *= 1 + _count(child)
    return count


def _ways(block: Block) -> list[frozenset[Path]]:
    choices = [[*_ways(child), frozenset([child.path])] for child in block.blocks if child.is_open]
    return [frozenset[Path]().union(*choice) for choice in product(*choices)]


def _diagrams(whole: Block) -> list[Block]:
    """The open sub-diagrams."""
    return [block for block in whole.walk() if block.is_open and block.path]


def _facts(whole: Block) -> dict[str, Any]:
    """What the page tells of the blocks and wires of one picture, in the order of their numbers in it."""
    ports = {port.id: port for block in whole.walk() for port in block.ports}
    number = {block.path: i for i, block in enumerate(whole.walk())}
    blocks = []
    for block in whole.walk():
        facts = [["block", full_path(whole, block.path)], ["class", f"{block.kind} ({block.origin})"]]
        blocks.append({"key": _key(block.path), "facts": facts})

    def end(port: PortId) -> int | str:
        return number[port.path] if port.path or not whole.is_open else f"{port.side}puts"

    wires = []
    for chain in through_wires(whole):
        port = ports[chain[0]]
        facts = [["wire", port.id.name], ["size", port.size_text], ["unit", port.unit or "-"]]
        facts += [["from", full_name(whole, chain[0])], ["to", full_name(whole, chain[-1])]]
        facts += [["through", full_name(whole, border)] for border in chain[1:-1]]
        wires.append({"ends": [end(chain[0]), end(chain[-1])], "facts": facts})
    return {"blocks": blocks, "wires": wires}


def _table(whole: Block) -> str:
    wires = whole.all_wires()
    rows = ["<table><thead><tr><th>port<th>side<th>size<th>unit<th>wired to</tr></thead>"]
    for block in whole.walk():
        head = f"{html.escape(full_path(whole, block.path))} <small>{html.escape(block.kind)}</small>"
        rows.append(f'<tbody><tr><th scope="rowgroup" colspan="5">{head}</th></tr>')
        for port in block.ports:
            ends = "<br>".join(html.escape(end) for end in wired_to(whole, port.id, wires))
            cells = f"<td>{html.escape(port.id.name)}<td>{port.id.side}<td class=size>{port.size_text}"
            rows.append(f"<tr>{cells}<td>{html.escape(port.unit)}<td>{ends}</tr>")
        rows.append("</tbody>")
    return "\n".join([*rows, "</table>"])
