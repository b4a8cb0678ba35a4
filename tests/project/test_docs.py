"""The reference that `make docs` builds: whole, self-contained, typeset, and with snippets that run."""

import importlib.util
import re
import subprocess
import sys
from dataclasses import fields
from html.parser import HTMLParser
from pathlib import Path
from types import ModuleType

import pytest

import a2s_drake
from a2s_drake import Scenario
from a2s_drake.flight.log import array_columns
from diagrams import BUILDERS
from tests.support.markdown import ROOT, code_blocks

PAGES = sorted(path.relative_to(ROOT / "docs").with_suffix(".html") for path in (ROOT / "docs").rglob("*.md"))
PAGES.append(Path("readme.html"))
DRAWN = [Path("drawn", f"{name}.html") for name in BUILDERS]


def build(site: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(site)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    done = build(folder)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def hooks() -> ModuleType:
    spec = importlib.util.spec_from_file_location("docs_hooks", ROOT / "docs" / "tools" / "hooks.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Elements(HTMLParser):
    """The start tags of a page, and its text outside code."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text, self._code = "", 0
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attributes) -> None:
        self.tags.append((tag, dict(attributes)))
        self._code += tag in ("code", "script", "style")

    def handle_endtag(self, tag: str) -> None:
        self._code -= tag in ("code", "script", "style")

    def handle_data(self, data: str) -> None:
        self.text += data * (self._code == 0)


def test_every_page_is_built_and_none_holds_anything_from_elsewhere(site: Path) -> None:
    built = sorted(path.relative_to(site) for path in site.rglob("*.html"))
    assert built == sorted([*PAGES, *DRAWN, Path("404.html")])
    for page in built:
        for tag, attributes in Elements(site / page).tags:
            # An anchor is followed only when it is clicked.
            loaded = [attributes.get(name) or "" for name in ("src", "href", "srcset", "data") if tag != "a"]
            assert not any(re.match(r"(https?:)?//", address) for address in loaded), (page, tag, attributes)
    for sheet in site.rglob("*.css"):
        assert not re.search(r"(url\(|@import)\s*['\"]?(https?:)?//", sheet.read_text(encoding="utf-8")), sheet
    assert not (site / "tools").exists()


@pytest.mark.parametrize("page", PAGES, ids=str)
def test_every_page_opens_from_disk_and_fits(page: Path, site: Path, open_page) -> None:
    tab = open_page(site / page, folder=site)
    assert tab.locator("h1").first.is_visible()
    for width in (1300, 400):
        tab.set_viewport_size({"width": width, "height": 900})
        assert tab.evaluate("document.documentElement.scrollWidth - window.innerWidth") <= 0


def test_pages_link_to_diagrams_that_fold(site: Path, open_page) -> None:
    tab = open_page(site / "blocks.html", folder=site)
    tab.locator("a[href='drawn/closed_loop.html']").click()
    tab.get_by_role("button", name="fold world/airframe").click()
    assert tab.locator("#picture .closed").count() == 1


def test_the_readmes_diagram_is_drawn_without_mermaid(site: Path, open_page) -> None:
    tab = open_page(site / "readme.html", folder=site)
    width = "image => image.decode().then(() => image.naturalWidth)"
    assert tab.locator("img[src='drawn/closed_loop-2.svg']").evaluate(width) > 500
    assert "flowchart LR" not in tab.locator("article").inner_text()


def test_search_works_from_disk(site: Path, open_page) -> None:
    tab = open_page(site / "index.html", folder=site)
    tab.locator("input[name=query]").click()
    tab.keyboard.type("soft-min")
    tab.locator(".md-search-result__link").first.wait_for(timeout=10_000)
    assert "maths.html" in " ".join(
        link.get_attribute("href") or "" for link in tab.locator(".md-search-result__link").all()
    )


def test_formulas_are_mathml(site: Path) -> None:
    for page in PAGES:
        elements = Elements(site / page)
        assert not re.search(r"\\[(\[]|\$\$|\\(frac|text|lVert)", elements.text), page
        assert not any("arithmatex" in (attributes.get("class") or "") for _, attributes in elements.tags)
    kinds = [attributes.get("display") for tag, attributes in Elements(site / "maths.html").tags if tag == "math"]
    assert kinds.count("block") >= 25
    assert kinds.count("inline") >= 50


def test_formulas_are_laid_out(site: Path, open_page) -> None:
    tab = open_page(site / "maths.html", folder=site)
    heights = tab.evaluate("[...document.querySelectorAll('math')].map(m => m.getBoundingClientRect().height)")
    assert min(heights) > 5.0
    fraction = tab.locator("mfrac").first.bounding_box()
    assert fraction is not None
    assert fraction["height"] > 25.0


@pytest.mark.parametrize(
    "tex", [r"\frac{1", r"\foo{1}", r"{a", r"a}", r"\begin{aligned} a &= b \end{aligned}", r"a_", r"\frac{1}"]
)
def test_a_formula_that_cannot_be_converted_is_refused(tex: str, hooks: ModuleType) -> None:
    with pytest.raises(ValueError, match="formula"):
        hooks.mathml(tex, display=True)


def test_a_broken_formula_ends_the_build(hooks: ModuleType) -> None:
    from mkdocs.exceptions import PluginError
    from mkdocs.structure.files import File
    from mkdocs.structure.pages import Page

    page = Page(None, File("x.md", "docs", "site", use_directory_urls=False), {"repo_url": None, "edit_uri": None})
    with pytest.raises(PluginError, match=r"x\.md: formula"):
        hooks.on_page_content(r'<p><span class="arithmatex">\(\foo\)</span></p>', page=page)


def anchors(page: Path) -> set[str]:
    return {attributes["id"] or "" for _, attributes in Elements(page).tags if "id" in attributes}


def test_every_public_name_and_every_module_has_an_entry(site: Path) -> None:
    entries = set().union(*(anchors(page) for page in (site / "api").glob("*.html")))
    listed = (site / "api" / "index.html").read_text(encoding="utf-8")
    for name in a2s_drake.__all__:
        link = re.search(rf'href="([\w.]+)#([\w.]+\.{name})"', listed)
        assert link, name
        assert link[2] in anchors(site / "api" / link[1])
    assert not re.search(r"<td>\s*</td>|&amp;#", listed)
    modules = [*(ROOT / "a2s_drake").rglob("*.py"), *(ROOT / "diagrams").glob("*.py")]
    for module in modules:
        dotted = ".".join(module.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        if module.name == "__init__.py" and "import" not in module.read_text(encoding="utf-8"):
            continue  # such a package holds nothing of its own
        assert dotted in entries | {"a2s_drake", "a2s_drake.diagrams"}, dotted


def test_sections_and_pictures_of_docstrings_are_shown(site: Path) -> None:
    law = (site / "api" / "guidance.html").read_text(encoding="utf-8")
    for title in ("Parameters", "Returns"):
        assert f'<span class="doc-section-title">{title}:</span>' in law
    for page in (site / "api").glob("*.html"):
        left = r'(?<!doc-section-title">)\b(Args|Attributes|Raises|Returns|Yields):\s'
        assert not re.search(left, page.read_text(encoding="utf-8")), page
    assert re.search(r"<pre.*?\| AttitudeReference \|.*?</pre>", law, re.DOTALL)
    flight = Elements(site / "api" / "flight.html").text
    assert "P_t |g|^2 / sigma^2, dB, shape (n,)." in flight


def test_tables_list_every_field_and_every_column(site: Path) -> None:
    scenario, files = ((site / name).read_text(encoding="utf-8") for name in ("scenario.html", "files.html"))
    for section in fields(Scenario):
        for entry in fields(section.default_factory):
            row = re.search(rf"<tr>\s*<td><code>{section.name}\.{entry.name}</code>.*?</tr>", scenario, re.DOTALL)
            assert row, entry.name
            cells = [re.sub("<.*?>", "", cell).strip() for cell in re.findall(r"<td>(.*?)</td>", row[0], re.DOTALL)]
            assert len(cells) == 4
            assert all(cells)
    for columns in array_columns().values():
        assert all(f"<code>{column}</code>" in files for column in columns)


@pytest.mark.parametrize("page", ["maths.md", "blocks.md", "files.md"])
def test_snippets_run(page: str, capsys, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    snippets = [block.text for block in code_blocks(ROOT / "docs" / page) if block.language == "python"]
    assert snippets
    names: dict[str, object] = {"__name__": page}
    for snippet in snippets:
        exec(compile(snippet, page, "exec"), names)
    assert capsys.readouterr().out


def snippets_under(heading: str) -> list[str]:
    """The Python snippets of `docs/blocks.md` between the heading of an id and the next one."""
    page = (ROOT / "docs" / "blocks.md").read_text(encoding="utf-8")
    section = page.partition(f"{{ #{heading} }}\n")[2].partition("\n#")[0]
    return re.findall(r"^```python\n(.*?)^```$", section, re.MULTILINE | re.DOTALL)


ROLE_EXAMPLES = {"channel": 1, "controller": 1, "path": 2, "sensor": 1, "observer": 1, "log": 1}


@pytest.mark.parametrize(
    ("heading", "place"), [(heading, place) for heading, count in ROLE_EXAMPLES.items() for place in range(count)]
)
def test_an_example_of_a_role_is_a_short_file_of_its_own(heading: str, place: int) -> None:
    (start,), examples = snippets_under("own"), snippets_under(heading)
    assert len(examples) == ROLE_EXAMPLES[heading]
    lines = [[line for line in part.splitlines() if line.strip()] for part in (start, examples[place])]
    assert len(lines[0]) == 5
    assert sum(map(len, lines)) <= 25
    exec(compile(start + examples[place], f"blocks.md, {heading}", "exec"), {"__name__": "__main__"})
