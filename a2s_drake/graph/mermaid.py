"""A diagram as a Mermaid flowchart, which GitHub, GitLab and many editors draw where Markdown is read."""

from a2s_drake.graph.model import Block, Port, PortId, through_wires


def as_mermaid(whole: Block) -> str:
    """A flowchart, left to right: open diagrams as boxes, wires between the same two blocks drawn as one.

    Each wire is labelled with the port that it comes from and its size. The diagram's own inputs stand in one node, its
    outputs in another, with dotted wires.
    """
    names = {block.path: f"b{i}" for i, block in enumerate(whole.walk())}
    ports = {port.id: port for block in whole.walk() for port in block.ports}
    lines = ["flowchart LR"]
    if not whole.is_open:
        return "\n".join([*lines, f"  {_node(whole, names)}"]) + "\n"
    if whole.inputs:
        lines.append(f'  inputs(["inputs of<br>{_escape(whole.name)}"])')
    lines += [f"  {line}" for block in whole.blocks for line in _box(block, names)]
    if whole.outputs:
        lines.append(f'  outputs(["outputs of<br>{_escape(whole.name)}"])')
    bundles: dict[tuple[str, str], list[Port]] = {}
    for chain in through_wires(whole):
        ends = _end(chain[0], names), _end(chain[-1], names)
        bundle = bundles.setdefault(ends, [])
        if ports[chain[0]] not in bundle:
            bundle.append(ports[chain[0]])
    for (source, target), bundle in bundles.items():
        label = "<br>".join(f"{_escape(port.id.name)} ({port.size_text})" for port in bundle)
        arrow = "-.->" if target == "outputs" else "-->"  # so that the loop stands out from what leaves it
        lines.append(f'  {source} {arrow}|"{label}"| {target}')
    return "\n".join(lines) + "\n"


def _end(port: PortId, names: dict[str, str]) -> str:
    if port.path:
        return names[port.path]
    return "inputs" if port.side == "in" else "outputs"


def _node(block: Block, names: dict[str, str]) -> str:
    text = f"<b>{_escape(block.name)}</b><br>{_escape(block.kind)}"
    brackets = '[["{}"]]' if block.is_diagram else '["{}"]'
    return names[block.path] + brackets.format(text)


def _box(block: Block, names: dict[str, str]) -> list[str]:
    if not block.is_open:
        return [_node(block, names)]
    inner = [f"  {line}" for child in block.blocks for line in _box(child, names)]
    return [f'subgraph {names[block.path]}["{_escape(block.name)}"]', *inner, "end"]


def _escape(text: str) -> str:
    """Text inside quotes: Mermaid reads entities written with # in place of &."""
    for character, entity in (("#", "#35;"), ('"', "#quot;"), ("<", "#lt;"), (">", "#gt;"), ("|", "#124;")):
        text = text.replace(character, entity)
    return text
