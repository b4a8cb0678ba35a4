"""A diagram for people to read: as text, Mermaid, Graphviz' DOT, SVG, or a page on which sub-diagrams fold."""

from collections.abc import Callable

from a2s_drake.views.graph.dot import GraphvizError, GraphvizMissing, as_dot, as_svg
from a2s_drake.views.graph.mermaid import as_mermaid
from a2s_drake.views.graph.model import Block, Port, PortId, Wire, read_graph, through_wires
from a2s_drake.views.graph.page import as_html
from a2s_drake.views.graph.text import as_text

FORMATS: dict[str, Callable[[Block], str]] = {
    "text": as_text,
    "mermaid": as_mermaid,
    "dot": as_dot,
    "svg": as_svg,
    "html": as_html,
}
"""How to write what `read_graph` reads."""

__all__ = [
    "FORMATS",
    "read_graph",
    "Block",
    "Port",
    "PortId",
    "Wire",
    "through_wires",
    "as_text",
    "as_mermaid",
    "as_dot",
    "as_svg",
    "as_html",
    "GraphvizError",
    "GraphvizMissing",
]
