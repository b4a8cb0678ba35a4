"""Diagrams to draw."""

from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Gain, PassThrough

from diagrams import BUILDERS, load_scenario

DISTURBED = ["disturbance.gust_force=[0,3,0]", "disturbance.rotor_efficiency=[0.9,1,1,1,1,1]"]
DISTURBED += ["disturbance.input_delay_periods=1", "disturbance.position_noise=0.01"]


def build(name: str, *overrides: str) -> Diagram:
    return BUILDERS[name](load_scenario("paper").with_overrides(overrides).validate())


def nest(depth: int, name: str = "nest") -> Diagram:
    """Pass-throughs in diagrams in diagrams, each level with a block of its own behind the inner one."""
    builder = DiagramBuilder()
    first = builder.AddNamedSystem("inner", nest(depth - 1, "inner") if depth else PassThrough(2))
    last = builder.AddNamedSystem("double", Gain(2.0, 2))
    builder.Connect(first.get_output_port(0), last.get_input_port())
    builder.ExportInput(first.get_input_port(0), "level")
    builder.ExportOutput(last.get_output_port(), "level")
    diagram = builder.Build()
    diagram.set_name(name)
    return diagram


def odd_names() -> Diagram:
    """Names that Graphviz, Mermaid, HTML or a path could take for something of their own."""
    inner = DiagramBuilder()
    gain = inner.AddNamedSystem("b", Gain(1.0, 1))
    inner.ExportInput(gain.get_input_port(), "left::arm in|put")
    inner.ExportOutput(gain.get_output_port(), 'say "\\N" <i>&</i>')
    builder = DiagramBuilder()
    first = builder.AddNamedSystem("a", inner.Build())
    second = builder.AddNamedSystem("a/b", Gain(1.0, 1))
    third = builder.AddNamedSystem(r"c \N \G", Gain(1.0, 1))
    builder.Connect(first.get_output_port(0), second.get_input_port())
    builder.Connect(second.get_output_port(), third.get_input_port())
    builder.ExportInput(first.get_input_port(0), "entry")
    builder.ExportOutput(third.get_output_port(), "once")
    builder.ExportOutput(third.get_output_port(), "twice")
    diagram = builder.Build()
    diagram.set_name("@DATA@")
    return diagram
