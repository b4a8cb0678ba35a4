"""What griffe does not see for itself: blocks over scalar types, comments beside fields, sections without a gap."""

import ast
import re
from functools import cache
from pathlib import Path
from typing import Any

import griffe
from comments import assignment_comments  # type: ignore[import-not-found]

_SECTION = re.compile(r"(?<=[^\n])\n(?=(?:Args|Attributes|Raises|Returns|Yields):\n)")
_CODE = re.compile(r"(```.*?```|`[^`\n]*`)", re.DOTALL)


@cache
def _comments(path: Path) -> dict[str, str]:
    return assignment_comments(path.read_text(encoding="utf-8"))


def _as_markdown(docstring: str) -> str:
    """A docstring whose sections stand apart, and whose mathematics Markdown does not take for links and emphasis."""
    pieces = _CODE.split(_SECTION.sub("\n\n", docstring))
    for place in range(0, len(pieces), 2):  # every other piece is code
        pieces[place] = re.sub(r"[\[\]|<>*\\]", lambda match: f"&#{ord(match[0])};", pieces[place])
    return "".join(pieces)


class ProjectDocstrings(griffe.Extension):
    """Reads this project's docstrings as they are meant."""

    def __init__(self) -> None:
        super().__init__()
        self._blocks: dict[tuple[str, str], griffe.Class] = {}

    def on_function_instance(self, *, node: Any, func: griffe.Function, agent: Any, **_: Any) -> None:
        """Keeps the block that a function decorated with `TemplateSystem.define` makes for a scalar type."""
        if not isinstance(node, ast.FunctionDef) or "TemplateSystem.define" not in map(_callee, node.decorator_list):
            return
        for inner in node.body:
            if isinstance(inner, ast.ClassDef):
                agent.visit(inner)
                block = func.parent.members[inner.name]
                construct = block.members["_construct"]
                construct.name = "__init__"
                construct.parameters = griffe.Parameters(*(p for p in construct.parameters if p.name != "converter"))
                block.set_member("__init__", construct)
                self._blocks[func.module.path, inner.name] = block

    def on_attribute_instance(self, *, attr: griffe.Attribute, **_: Any) -> None:
        """Shows a block in place of the line that instantiates it for floats, and comments of fields and constants."""
        block = self._blocks.get((attr.module.path, attr.name))
        if block is not None:
            attr.parent.set_member(attr.name, block)
        elif attr.docstring is None:
            inside = "" if attr.parent.is_module else f"{attr.parent.name}."
            comment = _comments(attr.filepath).get(inside + attr.name)
            if comment:
                attr.docstring = griffe.Docstring(comment, parent=attr)

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:
        """Prepares every docstring for the parser."""
        _prepare(pkg)


def _callee(node: ast.expr) -> str:
    return ast.unparse(node.func) if isinstance(node, ast.Call) else ""


def _prepare(item: griffe.Object) -> None:
    if item.docstring is not None:
        item.docstring.value = _as_markdown(item.docstring.value)
    for member in item.members.values():
        if not member.is_alias:
            _prepare(member)
