import json
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from a2s_drake.views.graph import (
    as_html,
    read_graph,
)
from a2s_drake.views.graph.model import Block, close, full_name, through_wires
from a2s_drake.views.graph.page import foldings
from diagrams import BUILDERS
from tests.support.graphs import build, nest


@pytest.fixture(params=BUILDERS)
def diagram(request: pytest.FixtureRequest) -> Diagram:
    return build(request.param)


def test_there_is_a_picture_of_every_way_to_fold() -> None:
    ways = foldings(read_graph(nest(2)))
    assert ways == [frozenset(), {("inner", "inner")}, {("inner",)}]


def test_beside_one_another_diagrams_fold_independently() -> None:
    assert set(foldings(pair())) == {
        frozenset((name,) for name in closed) for closed in ([], ["left"], ["right"], ["left", "right"])
    }


def test_of_too_many_ways_one_diagram_or_one_level_is_folded() -> None:
    inner, level = ("inner",), ("inner", "inner")
    assert foldings(read_graph(nest(3)), limit=2) == [frozenset(), {inner}, {level}, {(*level, "inner")}]
    assert foldings(row_of(7))[1:] == [*({(f"d{i}",)} for i in range(7)), {(f"d{i}",) for i in range(7)}]


def row_of(count: int) -> Block:
    builder = DiagramBuilder()
    for i in range(count):
        builder.ExportInput(builder.AddNamedSystem(f"d{i}", nest(0)).get_input_port(0), f"u{i}")
    diagram = builder.Build()
    diagram.set_name("row")
    return read_graph(diagram)


def pair() -> Block:
    builder = DiagramBuilder()
    left = builder.AddNamedSystem("left", nest(0, "left"))
    right = builder.AddNamedSystem("right", nest(0, "right"))
    builder.Connect(left.get_output_port(0), right.get_input_port(0))
    builder.ExportInput(left.get_input_port(0), "entry")
    diagram = builder.Build()
    diagram.set_name("pair")
    return read_graph(diagram)


@pytest.fixture
def show(tmp_path: Path, open_page):
    def show_one(whole: Block):
        path = tmp_path / "page.html"
        path.write_text(as_html(whole), encoding="utf-8")
        return open_page(path)

    return show_one


def names_drawn(tab) -> list[str]:
    return sorted(tab.locator("#picture :is(.block, .closed, .diagram)").evaluate_all("all => all.map(g => g.id)"))


def test_page_shows_every_block_and_every_wire(diagram: Diagram, show) -> None:
    whole = read_graph(diagram)
    tab = show(whole)
    assert len(names_drawn(tab)) == len(list(whole.walk())) - 1
    assert tab.locator("#picture .wire").count() == len(through_wires(whole))
    assert tab.locator("#tables tbody").count() == len(list(whole.walk()))
    table = tab.locator("#tables").inner_text()
    assert all(f"-> {full_name(whole, wire.target)}" in table for wire in whole.all_wires())
    assert tab.locator("#picture title").count() == 0
    assert "xlink:title" not in tab.locator("#picture").inner_html()
    assert not tab.locator("#note").is_visible()
    assert tab.title() == whole.name


@pytest.mark.parametrize("way", ["button", "picture"])
def test_a_sub_diagram_folds_and_unfolds(way: str, show) -> None:
    whole = read_graph(build("closed_loop"))
    tab = show(whole)
    inner = tab.get_by_text("MultibodyPlant").locator("visible=true").and_(tab.locator("#picture text"))
    assert inner.count() == 1
    click = {
        "button": lambda: tab.locator("#folds button").get_by_text("fold world/airframe").click(),
        "picture": lambda: tab.locator("#picture text").get_by_text("airframe", exact=True).click(),
    }[way]
    click()
    assert inner.count() == 0
    folded = close(whole, frozenset([("world", "airframe")]))
    assert tab.locator("#picture .wire").count() == len(through_wires(folded))
    button = tab.get_by_role("button", name="fold world/airframe")
    assert button.get_attribute("aria-expanded") == "false"
    click()
    assert inner.count() == 1


def test_folding_keeps_what_else_is_folded(show) -> None:
    tab = show(pair())
    for path in ("left", "right"):
        tab.get_by_role("button", name=f"fold {path}", exact=True).click()
    assert tab.locator("#picture .closed").count() == 2
    tab.get_by_role("button", name="unfold left").click()
    assert tab.locator("#folds button").all_inner_texts() == ["fold left", "unfold right"]


def test_folding_the_outer_one_hides_the_inner_ones_button(show) -> None:
    tab = show(read_graph(nest(2)))
    assert tab.locator("#folds button").all_inner_texts() == ["fold inner", "fold inner/inner"]
    tab.get_by_role("button", name="fold inner", exact=True).click()
    assert tab.locator("#folds button").all_inner_texts() == ["unfold inner"]


def test_a_wire_tells_name_size_and_unit_under_the_pointer(show) -> None:
    whole = read_graph(build("closed_loop"))
    chains = through_wires(whole)
    ends = ("onboard", "mpc"), ("world", "airframe", "propeller")
    number = next(i for i, c in enumerate(chains) if (c[0].path, c[-1].path) == ends)
    tab = show(whole)
    card = tab.locator("#card")
    assert not card.is_visible()
    point = "path.getPointAtLength(path.getTotalLength() / 3).matrixTransform(path.getScreenCTM())"
    script = f"path => {{ const point = {point}; return [point.x, point.y]; }}"
    tab.mouse.move(*tab.locator(f"#wire-{number} path").first.evaluate(script))
    assert card.is_visible()
    assert card.inner_text().split("\n") == [
        *("wire", "rotor_speed_squared", "size", "6", "unit", "Hz^2"),
        *("from", "onboard/mpc.rotor_speed_squared", "to", "world/airframe/propeller.command"),
        *("through", "onboard.rotor_speed_squared"),
        *("through", "world.rotor_speed_squared", "through", "world/airframe.rotor_speed_squared"),
    ]
    assert tab.locator("#picture .hit").evaluate_all("all => all.map(g => g.id)") == [f"wire-{number}"]
    tab.mouse.move(2, 2)
    assert not card.is_visible()
    assert tab.locator("#picture .hit").count() == 0


def test_the_keyboard_reaches_wires_and_folds(show) -> None:
    tab = show(read_graph(build("closed_loop")))
    tab.locator("#picture .diagram").last.focus()
    tab.keyboard.press("Enter")
    assert tab.locator("#picture .closed").count() == 1
    tab.locator("#picture .wire").first.focus()
    assert tab.locator("#card").is_visible()
    assert tab.locator("#picture .hit").count() == 1
    tab.locator("#folds button").last.focus()
    assert not tab.locator("#card").is_visible()
    tab.keyboard.press("Enter")
    assert tab.locator("#picture .closed").count() == 0
    assert tab.evaluate("document.activeElement.textContent") == "fold onboard"


def test_many_sub_diagrams_fold_one_at_a_time(show) -> None:
    tab = show(row_of(7))
    assert tab.locator("#note").is_visible()
    for name in ("d3", "d5"):
        tab.get_by_role("button", name=f"fold {name}", exact=True).click()
        assert tab.locator("#picture .closed").count() == 1
        assert tab.get_by_role("button", name=f"unfold {name}").count() == 1


def test_a_block_lights_its_wires_under_the_pointer(show) -> None:
    whole = read_graph(build("link_only"))
    tab = show(whole)
    tab.locator("#picture text").get_by_text("TwoRayChannel").hover()
    assert "a2s_drake" in tab.locator("#card").inner_text()
    wires = [chain for chain in through_wires(whole) if ("channel",) in (chain[0].path, chain[-1].path)]
    assert tab.locator("#picture .hit").count() == len(wires) == 7


def test_page_fits_a_narrow_window(tmp_path: Path, open_page) -> None:
    path = tmp_path / "page.html"
    path.write_text(as_html(read_graph(build("closed_loop"))), encoding="utf-8")
    tab = open_page(path, 380, 700)
    assert tab.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth") == 0


def test_page_data_cannot_end_its_script() -> None:
    builder = DiagramBuilder()
    builder.AddNamedSystem("</script><b>", ConstantVectorSource(np.zeros(1)))
    page = as_html(read_graph(builder.Build()))
    text = page.split('<script id="data" type="application/json">')[1].split("</script>")[0]
    assert json.loads(text)["pictures"][0]["blocks"][1]["key"] == "</script><b>\0"
