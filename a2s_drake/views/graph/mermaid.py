"""A diagram as a Mermaid flowchart, which GitHub, GitLab and many editors draw where Markdown is read."""

from a2s_drake.views.graph.model import Block, Path, Port, through_wires


def as_mermaid(whole: Block) -> str:
    """A flowchart, left to right: open diagrams as boxes, wires between the same two blocks drawn as one.

    Each wire is labelled with the port that it comes from and its size. The diagram's own inputs stand in one node, its
    outputs, under the names that they have there, in another with dotted wires.
    """
    names = {block.path: f"b{i}" for i, block in enumerate(whole.walk())}
    lines = ["flowchart LR"]
    if whole.inputs:
        lines.append(f'  inputs(["inputs of<br>{_escape(whole.name)}"])')
    shown = whole.blocks if whole.is_open else [whole]
    lines += [f"  {line}" for block in shown for line in _box(block, names)]
    if whole.outputs:
        lines.append(f'  outputs(["outputs of<br>{_escape(whole.name)}"])')
    bundles: dict[tuple[str, str], list[str]] = {}
    for start, end, label in _wires(whole, names):
        bundle = bundles.setdefault((start, end), [])
        if label not in bundle:
            bundle.append(label)
    for (start, end), bundle in bundles.items():
        arrow = "-.->" if end == "outputs" else "-->"  # so that the loop stands out from what leaves it
        lines.append(f'  {start} {arrow}|"{"<br>".join(bundle)}"| {end}')
    return "\n".join(lines) + "\n"


def _wires(whole: Block, names: dict[Path, str]) -> list[tuple[str, str, str]]:
    """The node that each wire comes from, the one that it leads to, and its label."""
    if not whole.is_open:
        entering = [("inputs", names[()], _label(port, port.id.name)) for port in whole.inputs]
        return entering + [(names[()], "outputs", _label(port, port.id.name)) for port in whole.outputs]
    ports = {port.id: port for block in whole.walk() for port in block.ports}
    wires = []
    for source, *_, target in through_wires(whole):
        start = names[source.path] if source.path else "inputs"
        end = names[target.path] if target.path else "outputs"
        wires.append((start, end, _label(ports[source], source.name if target.path else target.name)))
    return wires


def _label(port: Port, name: str) -> str:
    return f"{_escape(name)} ({port.size_text})"


def _node(block: Block, names: dict[Path, str]) -> str:
    text = f"<b>{_escape(block.name)}</b><br>{_escape(block.kind)}"
    brackets = '[["{}"]]' if block.is_diagram else '["{}"]'
    return names[block.path] + brackets.format(text)


def _box(block: Block, names: dict[Path, str]) -> list[str]:
    if not block.is_open:
        return [_node(block, names)]
    inner = [f"  {line}" for child in block.blocks for line in _box(child, names)]
    return [f'subgraph {names[block.path]}["{_escape(block.name)}"]', *inner, "end"]


def _escape(text: str) -> str:
    """Text inside quotes: Mermaid reads entities written with # in place of &."""
    for character, entity in (("#", "#35;"), ('"', "#quot;"), ("<", "#lt;"), (">", "#gt;"), ("|", "#124;")):
        text = text.replace(character, entity)
    return text
