"""MkDocs hooks: formulas to MathML, tables and diagrams from the code, and the README as a page."""

import ast
import html
import inspect
import re
import sys
import xml.etree.ElementTree as ET
from dataclasses import MISSING, Field, fields
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

TOOLS = Path(__file__).resolve().parent
ROOT = TOOLS.parents[1]
sys.path[:0] = [str(TOOLS), str(ROOT)]

from comments import assignment_comments  # noqa: E402

import a2s_drake  # noqa: E402
from a2s_drake.flight import log as flight  # noqa: E402
from a2s_drake.scenario import parts as parameters  # noqa: E402
from a2s_drake.views.graph import as_html, as_svg, read_graph  # noqa: E402
from diagrams import BUILDERS  # noqa: E402

_FORMULA = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)
_MATHML = "{http://www.w3.org/1998/Math/MathML}"
ET.register_namespace("", _MATHML.strip("{}"))
_CHILDREN = {"mfrac": 2, "msub": 2, "msup": 2, "munder": 2, "mover": 2, "msubsup": 3, "munderover": 3}
_MERMAID = re.compile(r"<!-- show_diagram (\w+) [^\n]*mermaid -->\n```mermaid\n.*?```", re.DOTALL)
_FOREIGN_LINK = re.compile(r"(?<!!)\[([^\]]*)\]\((?!https?:|docs/|#)[^)]*\)")


def mathml(tex: str, *, display: bool) -> str:
    """A formula as a MathML element.

    Raises:
      ValueError: when it cannot be converted. The converter itself passes on what it does not know.
    """
    try:
        element = convert(tex, display="block" if display else "inline")
        tree = ET.fromstring(element)
    except Exception as error:  # The converter's errors share no base class.
        raise ValueError(f"formula {tex!r}: {error!r}") from error
    if tex.replace(r"\{", "").count("{") != tex.replace(r"\}", "").count("}"):
        raise ValueError(f"formula {tex!r}: its braces do not match")
    for part in tree.iter():
        if "\\" in (part.text or ""):
            raise ValueError(f"formula {tex!r}: {part.text} is not known")
        expected = _CHILDREN.get(part.tag.removeprefix(_MATHML), len(part))
        if len(part) != expected:
            raise ValueError(f"formula {tex!r}: something is missing")
        _space_operators(part)
    return ET.tostring(tree, encoding="unicode")


def _space_operators(parent: ET.Element) -> None:
    """Sets bars and slashes tight, and signs like signs: the converter marks neither, and browsers guess."""
    before = "("
    for part in parent:
        symbol = (part.text or "") if part.tag == f"{_MATHML}mo" else ""
        if symbol in ("|", "\u2016", "/"):
            part.attrib |= {"stretchy": "false", "lspace": "0", "rspace": "0"}
        elif symbol in ("-", "+", "\u2212", "\u00b1") and before and before in "(=[,<\u2264":
            part.attrib |= {"form": "prefix", "lspace": "0", "rspace": "0"}
        before = symbol


def scenario_tables() -> str:
    """Markdown of every scenario field: name, default, allowed values, meaning."""
    comments = assignment_comments(inspect.getsource(parameters))
    lines: list[str] = []
    for section in fields(a2s_drake.Scenario):
        part: Any = section.default_factory  # type: ignore[misc]
        lines += ["", f"## {section.name}", "", inspect.getdoc(part) or "", ""]
        lines += ["| field | default | allowed | meaning |", "|---|---|---|---|"]
        for entry in fields(part):
            meaning = comments[f"{part.__name__}.{entry.name}"]
            cells = [f"`{section.name}.{entry.name}`", f"`{_default(entry)}`", _allowed(entry), _escaped(meaning)]
            lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _default(entry: Field[Any]) -> str:
    value = entry.default if entry.default_factory is MISSING else entry.default_factory()
    return "null" if value is None else str(value)


def _allowed(entry: Field[Any]) -> str:
    limits = dict(entry.metadata)
    length = limits.pop("length", None)
    if "choices" in limits:
        return ", ".join(f"`{choice}`" for choice in limits["choices"])
    if "file" in limits:
        return "a CSV file"
    signs = {"above": ">", "at_least": "\u2265", "below": "<", "at_most": "\u2264"}
    words = html.escape(", ".join(f"{signs[key]} {limit:g}" for key, limit in limits.items()))
    return words if length is None else f"{length} entries, each {words}"


def _escaped(text: str) -> str:
    """A text that Markdown shows as it is, but for its code."""
    pieces = re.split(r"(`[^`]*`)", text.replace("\n", " "))
    for place in range(0, len(pieces), 2):
        pieces[place] = re.sub(r"[|<>*_\[\]]", lambda match: f"&#{ord(match[0])};", pieces[place])
    return "".join(pieces)


def flight_table() -> str:
    """Markdown of every array of a flight, and of its columns as CSV."""
    stated = dict(re.findall(r"^ +(\w+): (.*), shape ", flight.Flight.__doc__ or "", re.MULTILINE))
    shapes = dict(re.findall(r"^ +(\w+): .*, shape (\(.*?\))", flight.Flight.__doc__ or "", re.MULTILINE))
    lines = ["| array | shape | unit | what | columns of `flight.csv` |", "|---|---|---|---|---|"]
    columns, units = flight.array_columns(), flight.array_units()
    for name in flight.array_names():
        unit = units[name]
        what = ", ".join(word for word in stated[name].split(", ") if word not in (*unit.split(", "), "dimensionless"))
        listed = " ".join(f"`{column}`" for column in columns[name])
        lines.append(f"| `{name}` | {shapes[name]} | {unit or '1'} | {_escaped(what)} | {listed} |")
    return "\n".join(lines)


def public_names() -> str:
    """Markdown of every public name: a link to its entry and its first sentence."""
    lines = ["| name | what it is |", "|---|---|"]
    imports = [node for node in ast.walk(_tree(a2s_drake)) if isinstance(node, ast.ImportFrom)]
    modules = {alias.name: str(node.module) for node in imports for alias in node.names}
    for name in a2s_drake.__all__:
        said = _documentation(import_module(modules[name]), name)
        # A full stop behind a capital is an initial's.
        first = re.split(r"(?<=[^A-Z])\.(?:\s|$)", said)[0].rstrip(".")
        lines.append(f"| [`{name}`][{modules[name]}.{name}] | {_escaped(first)} |")
    return "\n".join(lines)


def _tree(module: ModuleType) -> ast.Module:
    return ast.parse(inspect.getsource(module))


def _documentation(module: ModuleType, name: str) -> str:
    """What a module's source says of a name, or, for a block that a template makes, what the block says."""
    for node in _tree(module).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name:
            return ast.get_docstring(node) or ""
    return assignment_comments(inspect.getsource(module)).get(name) or inspect.getdoc(getattr(module, name)) or ""


_TABLES = {"scenario-tables": scenario_tables, "flight-table": flight_table, "public-names": public_names}


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the diagrams, and the README as a page.

    Mermaid would need a script, so the README's diagram is drawn here; its links to files that are no part of the site
    become plain text.
    """
    for name, build in BUILDERS.items():
        diagram = build(a2s_drake.Scenario())
        files.append(File.generated(config, f"drawn/{name}-2.svg", content=as_svg(read_graph(diagram, depth=2))))
        files.append(File.generated(config, f"drawn/{name}.html", content=as_html(read_graph(diagram))))
    readme = _FOREIGN_LINK.sub(r"\1", (ROOT / "README.md").read_text(encoding="utf-8"))
    readme = _MERMAID.sub(r"![The diagram \1](drawn/\1-2.svg)", readme)
    files.append(File.generated(config, "readme.md", content=readme.replace("](docs/", "](")))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Fills in the tables that are made from the code."""
    return re.sub(r"<!-- table: ([\w-]+) -->", lambda match: _TABLES[match[1]](), markdown)


def on_page_content(page_html: str, page: Any, **_: Any) -> str:
    """Turns formulas into MathML.

    Raises:
      PluginError: for a formula that cannot be converted; it ends the build.
    """

    def converted(match: re.Match[str]) -> str:
        tex, block = html.unescape(match[2]).strip(), match[1] == "div"
        if not block:
            return mathml(tex, display=False)
        # On a narrow page the statements of a line stand one below the other.
        statements = "".join(mathml(statement, display=True) for statement in tex.split(r"\qquad"))
        return f'<div class="formula">{statements}</div>'

    try:
        return _FORMULA.sub(converted, page_html)
    except ValueError as error:
        raise PluginError(f"{page.file.src_uri}: {error}") from error
