from html.parser import HTMLParser
from pathlib import Path

import pytest

from a2s_drake.study.paper.reproduction import HEADLINE, PRINTED, report_scenarios
from a2s_drake.views.figures import geometry_figure, save_figure
from a2s_drake.views.report.write import write_report
from diagrams import load_scenario
from tests.study.test_reproduction import UNBOUNDED, made_up


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A whole report of made-up flights."""
    folder = tmp_path_factory.mktemp("report")
    bases = {name: load_scenario(name) for name in (HEADLINE, PRINTED)}
    write_report(bases, made_up(report_scenarios(bases)), folder, UNBOUNDED)
    return folder / "report.html"


class Collector(HTMLParser):
    VOID = ("meta", "img", "br", "link")

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []
        self.ids: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in self.VOID:
            self.open.append(tag)
        for name, value in attrs:
            if name in ("src", "href"):
                self.links.append(value or "")
            if name == "id":
                self.ids.append(value or "")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.fixture
def dut(page: Path) -> Collector:
    collector = Collector()
    collector.feed(page.read_text(encoding="utf-8"))
    return collector


def test_page_is_balanced_and_shows_every_figure_once(dut: Collector) -> None:
    assert dut.open == []
    expected = ["geometry", "trajectory", "position", "channel_gain", "outage", "reference", "attitude_error"]
    expected += ["attitude", "velocity", "angular_velocity", "rotor_speed", "planned_channel_gain", "planned_outage"]
    expected += ["planned_attitude", "planned_angular_velocity", "planned_rotor_speed", "attribution"]
    expected += ["readings", "ceiling", "affine_phase_error"]
    assert dut.ids == expected


def test_page_holds_all_it_shows(dut: Collector, page: Path) -> None:
    assert len(dut.links) == 20
    assert all(link.startswith("data:image/svg+xml;base64,") for link in dut.links)
    assert "url(" not in page.read_text(encoding="utf-8").split("<body>")[0]


@pytest.mark.parametrize(
    "words",
    [
        "+50.00 %",
        "+20.00 %",
        "+22.2 %",
        "+11.4 %",
        "28.5 deg",
        "index_zero",
        "rotor drag 50.0 to 51.5 % over level",
        "tilt 35 deg",
        "J_a",
        "43.24 %",
        "+60.00 %",
        "rotors in motion",
    ],
)
def test_page_says(words: str, dut: Collector) -> None:
    assert words in dut.text


def test_same_results_give_the_same_page(page: Path) -> None:
    geometry = page.parent / "figures" / "geometry.svg"
    again = page.parent / "again"
    save_figure(geometry_figure(), again)
    assert again.with_suffix(".svg").read_bytes() == geometry.read_bytes()


@pytest.mark.parametrize("width", [360, 1400])
def test_page_in_a_browser(width: int, page: Path, open_page) -> None:
    tab = open_page(page, width)
    drawn = "[...document.images].filter(image => image.complete && image.naturalWidth > 0).length"
    assert tab.evaluate(drawn) == 20
    assert tab.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth") == 0
