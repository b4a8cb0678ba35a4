import re
import shutil
import sys
import xml.etree.ElementTree as ElementTree
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.framework import Diagram, DiagramBuilder, InputPortIndex, LeafSystem, OutputPortIndex
from pydrake.systems.primitives import ConstantVectorSource, Gain, PassThrough

from a2s_drake.views.graph import (
    GraphvizError,
    GraphvizMissing,
    as_dot,
    as_html,
    as_mermaid,
    as_svg,
    as_text,
    dot,
    read_graph,
)
from a2s_drake.views.graph.model import connected, full_name, through_wires
from diagrams import BUILDERS
from scripts import show_diagram
from tests.support.graphs import DISTURBED, build, nest, odd_names


@pytest.fixture(params=BUILDERS)
def diagram(request: pytest.FixtureRequest) -> Diagram:
    return build(request.param)


def systems_within(diagram: Diagram, path: tuple[str, ...] = ()) -> dict[tuple[str, ...], object]:
    found = {}
    for system in diagram.GetSystems():
        own = (*path, system.get_name())
        found[own] = system
        if isinstance(system, Diagram):
            found |= systems_within(system, own)
    return found


@pytest.mark.parametrize("overrides", [[], DISTURBED])
@pytest.mark.parametrize("name", BUILDERS)
def test_wires_are_those_that_drake_calls_connected(name: str, overrides: list[str]) -> None:
    diagram = build(name, *overrides)
    dut = read_graph(diagram)
    for path, owner in {(): diagram, **systems_within(diagram)}.items():
        if not isinstance(owner, Diagram):
            continue
        expected = set()
        for source, target in product(owner.GetSystems(), repeat=2):
            for output, entry in product(range(source.num_output_ports()), range(target.num_input_ports())):
                ports = source.get_output_port(output), target.get_input_port(entry)
                if owner.AreConnected(*ports):
                    ends = zip((source, target), ports, strict=True)
                    expected.add(tuple(f"{system.get_name()}.{port.get_name()}" for system, port in ends))
        block = next(block for block in dut.walk() if block.path == path)
        inner = [wire for wire in block.wires if path not in (wire.source.path, wire.target.path)]
        found = {(full_name(dut, w.source), full_name(dut, w.target)) for w in inner}
        prefix = "".join(f"{name}/" for name in path)
        assert found == {(prefix + source, prefix + target) for source, target in expected}
        assert len(inner) == len(found)


def test_exported_ports_are_wired_to_what_they_export(diagram: Diagram) -> None:
    dut = read_graph(diagram)
    found = {(w.source.name, full_name(dut, w.target)) for w in dut.wires if not w.source.path}
    expected = {
        (diagram.get_input_port(i).get_name(), f"{system.get_name()}.{system.get_input_port(port).get_name()}")
        for i in range(diagram.num_input_ports())
        for system, port in diagram.GetInputPortLocators(InputPortIndex(i))
    }
    assert found == expected
    exported = {w.target.name: full_name(dut, w.source) for w in dut.wires if not w.target.path}
    assert list(exported) == [diagram.get_output_port(i).get_name() for i in range(diagram.num_output_ports())]
    for i, source in enumerate(exported.values()):
        system, port = diagram.get_output_port_locator(OutputPortIndex(i))
        assert source == f"{system.get_name()}.{system.get_output_port(port).get_name()}"


def test_ports_have_the_sizes_that_drake_gives_them(diagram: Diagram) -> None:
    systems = systems_within(diagram)
    for block in read_graph(diagram).blocks:
        for port in block.ports:
            own = systems[block.path]
            theirs = own.GetInputPort(port.id.name) if port.id.side == "in" else own.GetOutputPort(port.id.name)
            assert port.size in (theirs.size(), None)
            assert (port.size is None) == ("Abstract" in str(theirs.get_data_type()))


@pytest.mark.parametrize("overrides", [[], DISTURBED])
def test_every_wired_port_of_ours_has_a_unit(overrides: list[str]) -> None:
    for name in BUILDERS:
        dut = read_graph(build(name, *overrides))
        used = connected(dut)
        ours = [port for block in dut.walk() if block.origin == "a2s_drake" for port in block.ports]
        assert ours
        assert [port.id for port in ours if port.id in used and not port.unit] == []


def test_a_port_gets_its_unit_from_what_it_is_wired_to() -> None:
    ports = {port.id: port for block in read_graph(build("link_only")).walk() for port in block.ports}
    multiplexer = {i.name: port.unit for i, port in ports.items() if i.path == ("vehicle_state",)}
    assert multiplexer == {"u0": "m", "u1": "rad", "u2": "", "y0": "m, rad, m/s, rad/s"}


def test_units_of_ones_own_ports_can_be_given() -> None:
    dut = read_graph(nest(0), units={"level": "m"})
    assert {port.unit for port in dut.blocks[0].inputs} == {"m"}


def test_reading_again_gives_the_same(diagram: Diagram) -> None:
    assert read_graph(build(diagram.get_name())) == read_graph(diagram)


@pytest.mark.parametrize(("depth", "count"), [(0, 1), (1, 3), (2, 5), (None, 7)])
def test_depth_is_the_number_of_levels_opened(depth: int | None, count: int) -> None:
    assert len(list(read_graph(nest(2), depth).walk())) == count


def test_a_negative_depth_is_refused() -> None:
    with pytest.raises(ValueError, match="depth = -1: must be at least 0"):
        read_graph(nest(0), -1)


@pytest.mark.parametrize("depth", range(4))
def test_wires_run_through_the_borders_of_open_diagrams(depth: int) -> None:
    dut = read_graph(nest(depth))
    chains = through_wires(dut)
    assert len(chains) == depth + 3  # one into the innermost, one behind each block
    assert {len(chain) for chain in chains} == ({depth + 2, 3, 2} if depth else {2})
    assert {chain[-1].path for chain in chains if not chain[0].path} == {("inner",) * (depth + 1)}


def test_text_tells_of_every_wire_and_every_port(diagram: Diagram) -> None:
    dut = read_graph(diagram)
    text = as_text(dut)
    for wire in dut.all_wires():
        assert f"-> {full_name(dut, wire.target)}\n" in text
        assert f"<- {full_name(dut, wire.source)}\n" in text
    for block in dut.walk():
        assert all(re.search(rf"\b{port.id.name}\b", text) for port in block.ports)


def test_text_row() -> None:
    lines = as_text(read_graph(build("closed_loop"), depth=1)).splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("onboard "))
    row = next(i for i, line in enumerate(lines) if i > start and "out  rotor_speed_squared " in line)
    assert lines[row].split() == ["out", "rotor_speed_squared", "6", "Hz^2", "->", "world.rotor_speed_squared"]
    assert lines[row + 1].split() == ["->", "closed_loop.rotor_speed_squared"]
    assert "world  (Diagram, closed)" in lines


def test_text_of_a_closed_diagram_lists_its_own_ports() -> None:
    text = as_text(read_graph(build("airframe_only"), depth=0))
    assert [line.split()[1] for line in text.splitlines()[3:]] == ["rotor_speed_squared", "vehicle_state", "body_poses"]


def test_mermaid_draws_every_block_and_wire_once(diagram: Diagram) -> None:
    dut = read_graph(diagram)
    lines = [line.strip() for line in as_mermaid(dut).splitlines()]
    assert lines[0] == "flowchart LR"
    nodes = {m[1] for line in lines if (m := re.match(r"(\w+)(\[\[|\[|\(\[)", line))}
    boxes = [line for line in lines if line.startswith("subgraph ")]
    assert len(boxes) == lines.count("end") == sum(block.is_open for block in dut.walk()) - 1
    shown = [block for block in dut.walk() if not block.is_open]
    assert len(nodes) == len(shown) + bool(dut.inputs) + bool(dut.outputs)
    drawn = []
    for line in lines:
        if match := re.fullmatch(r'(\w+) (?:-->|-\.->)\|"([^"]+)"\| (\w+)', line):
            assert {match[1], match[3]} <= nodes
            drawn += [(match[1], label.split(" ")[0], match[3]) for label in match[2].split("<br>")]
    chains = through_wires(dut)
    inner = {(chain[0], chain[-1].path) for chain in chains if chain[-1].path}
    assert len(drawn) == len(set(drawn)) == len(inner) + len(dut.outputs)
    assert [label for _, label, end in drawn if end == "outputs"] != []
    assert {label for _, label, end in drawn if end == "outputs"} == {port.id.name for port in dut.outputs}


def test_mermaid_takes_any_name() -> None:
    builder = DiagramBuilder()
    builder.AddNamedSystem('a "b" <c> #d |e|', ConstantVectorSource(np.zeros(1)))
    diagram = builder.Build()
    diagram.set_name("odd")
    assert '["<b>a #quot;b#quot; #lt;c#gt; #35;d #124;e#124;</b><br>ConstantVectorSource"]' in as_mermaid(
        read_graph(diagram)
    )


def test_mermaid_of_a_closed_diagram_names_its_ports() -> None:
    drawn = as_mermaid(read_graph(build("airframe_only"), depth=0))
    assert 'inputs -->|"rotor_speed_squared (6)"| b0' in drawn
    assert 'b0 -.->|"vehicle_state (12)<br>body_poses (abstract)"| outputs' in drawn


def titles(svg: str) -> list[str]:
    """The tooltips of the wires of a picture."""
    links = ElementTree.fromstring(svg).iter("{http://www.w3.org/2000/svg}a")
    return [link.get("{http://www.w3.org/1999/xlink}title") or "" for link in links]


@pytest.mark.parametrize("depth", [None, 1, 0])
def test_odd_names_come_through(depth: int | None) -> None:
    dut = read_graph(odd_names(), depth)
    svg = as_svg(dut)
    drawn = "".join(ElementTree.fromstring(svg).itertext())
    for block in dut.walk():
        assert block.path == () or block.name in drawn
        assert block.is_open or all(port.id.name in drawn for port in block.ports if port.id in connected(dut))
    for wire in through_wires(dut):
        assert any(full_name(dut, wire[-1]) in title for title in titles(svg))
    assert as_html(dut).count('"pictures"') == 1


def test_a_name_with_a_slash_is_no_path() -> None:
    dut = read_graph(odd_names())
    paths = {block.path for block in dut.walk()}
    assert {("a", "b"), ("a/b",)} <= paths
    text = as_text(dut)
    assert "\na/b  (Gain)" in text
    assert "\n[a/b]  (Gain)" in text
    assert "-> [a/b].u0\n" in text


def test_a_block_with_the_name_of_the_whole_is_told_apart() -> None:
    builder = DiagramBuilder()
    builder.ExportInput(builder.AddNamedSystem("same", Gain(1.0, 1)).get_input_port(), "u0")
    diagram = builder.Build()
    diagram.set_name("same")
    assert "-> same.u0\n" in as_text(read_graph(diagram))
    assert "<- same (whole).u0\n" in as_text(read_graph(diagram))


def test_what_is_exported_twice_is_shown_twice() -> None:
    drawn = as_mermaid(read_graph(odd_names(), 1))
    assert '-.->|"once (1)<br>twice (1)"| outputs' in drawn


def test_systems_without_a_name_get_their_class_and_number() -> None:
    def nameless() -> Diagram:
        builder = DiagramBuilder()
        builder.AddSystem(ConstantVectorSource(np.zeros(1)))
        gains = [builder.AddSystem(Gain(1.0, 1)) for _ in range(2)]
        builder.ExportInput(gains[0].get_input_port(), "u")
        builder.Connect(gains[0].get_output_port(), gains[1].get_input_port())
        return builder.Build()

    dut = read_graph(nameless())
    assert [block.name for block in dut.walk()] == ["diagram", "ConstantVectorSource_0", "Gain_1", "Gain_2"]
    assert dut == read_graph(nameless())
    assert "diagram" in as_svg(read_graph(nameless(), 0))


def test_a_class_within_a_function_has_a_name() -> None:
    class Local(LeafSystem):
        def __init__(self) -> None:
            LeafSystem.__init__(self)
            self.DeclareVectorInputPort("u", 1)

    builder = DiagramBuilder()
    builder.ExportInput(builder.AddNamedSystem("own", Local()).get_input_port(0), "u")
    dut = read_graph(builder.Build())
    assert dut.blocks[0].kind == "Local"
    assert dut.blocks[0].origin == "tests"
    assert "Local" in as_svg(dut)


def test_a_port_of_anothers_block_has_no_unit_by_its_name_alone() -> None:
    builder = DiagramBuilder()
    builder.ExportInput(builder.AddNamedSystem("mine", PassThrough(3)).get_input_port(), "ship_position")
    dut = read_graph(builder.Build())
    assert {port.unit for block in dut.walk() for port in block.ports} == {""}


def test_diagrams_of_other_scalars_are_read_as_well() -> None:
    diagram = build("airframe_only")
    kinds = [block.kind for block in read_graph(diagram).walk()]
    for other in (diagram.ToAutoDiffXd(), nest(1).ToSymbolic()):
        assert read_graph(other).is_open
    assert [block.kind for block in read_graph(diagram.ToAutoDiffXd()).walk()] == kinds


def test_svg_holds_every_block_and_wire(diagram: Diagram) -> None:
    dut = read_graph(diagram)
    groups = ElementTree.fromstring(as_svg(dut)).iter("{http://www.w3.org/2000/svg}g")
    by_id = {group.get("id"): group for group in groups}
    for i, block in enumerate(dut.walk()):
        if i:
            text = "".join(by_id[f"block-{i}"].itertext())
            assert block.name in text
            assert block.is_open or block.kind in text
    wires = through_wires(dut)
    for i, chain in enumerate(wires):
        link = by_id[f"a_wire-{i}"][0]
        title = link.get("{http://www.w3.org/1999/xlink}title") or ""
        assert title.startswith(f"{chain[0].name} (")
        assert full_name(dut, chain[-1]) in title
    assert f"wire-{len(wires)}" not in by_id


def test_the_dot_program_is_used_where_there_is_one(tmp_path: Path, monkeypatch) -> None:
    program = tmp_path / "dot"
    picture = '<?xml version="1.0"?><svg width="1"></svg>'
    program.write_text(f"#!{sys.executable}\nimport sys\nprint({picture!r} * sys.stdin.read().count('digraph'))\n")
    program.chmod(0o755)
    monkeypatch.setattr(shutil, "which", {"dot": str(program)}.get)
    drawn = dot.draw([as_dot(read_graph(nest(depth))) for depth in range(2)])
    assert len(drawn) == 2
    assert all(text.startswith("<?xml") and text.count("<svg") == 1 and ".wire:hover" in text for text in drawn)


@pytest.mark.parametrize("text", ["digraph {{", "digraph { a [label=<<B></B>>] }"])
def test_what_graphviz_cannot_draw_is_told_in_its_words(text: str, monkeypatch) -> None:
    monkeypatch.setattr(shutil, "which", {}.get)
    with pytest.raises(GraphvizError, match=r"could not draw the diagram: (?s:.*)rror"):
        dot.draw([text])


def test_script_tells_of_a_dot_program_that_fails_in_one_line(tmp_path: Path, monkeypatch, capsys) -> None:
    program = tmp_path / "dot"
    program.write_text(f"#!{sys.executable}\nraise SystemExit('it broke')\n")
    program.chmod(0o755)
    monkeypatch.setattr(shutil, "which", {"dot": str(program)}.get)
    assert show_diagram.main(["link_only", "--format", "svg"]) == 1
    assert capsys.readouterr().err == "error: Graphviz could not draw the diagram: it broke\n"


def test_without_graphviz_the_error_names_what_to_install(monkeypatch, capsys) -> None:
    monkeypatch.setattr(shutil, "which", {}.get)
    monkeypatch.setattr(dot, "is_installed", {}.get)
    with pytest.raises(GraphvizMissing, match=r"a2s_drake\[graph\]"):
        as_svg(read_graph(nest(0)))
    assert show_diagram.main(["link_only", "--format", "html"]) == 1
    assert capsys.readouterr().err.startswith("error: SVG and HTML need Graphviz")
