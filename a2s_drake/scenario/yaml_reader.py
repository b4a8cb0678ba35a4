"""YAML reader: the part of YAML that settings need, read as a person means it, with the line of every key.

Numbers, true, false and null are those of the core schema of YAML 1.2, but a number with a leading zero, an underscore
or a colon is a text, and so is a date. What a file of settings has no use for is refused: keys that are not texts, keys
that stand twice, anchors, aliases and tags.
"""

import math
import re
from pathlib import Path
from typing import Any, ClassVar

import yaml

from a2s_drake.common.files import read_bytes
from a2s_drake.common.quoting import PATH_LENGTH, named, one_line, quoted, shorten
from a2s_drake.scenario.checks import ScenarioError

# A file of settings is some kilobytes long; more than this is another file, and would take seconds to read.
MAX_LENGTH = 200_000
# A map of scenarios has four levels.
MAX_DEPTH = 16
# Python reads integers of up to 4300 digits, and a float holds 308; what is longer becomes an infinite float.
MAX_DIGITS = 400

_WORDS = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), math.nan),
    **{sign + word: float(sign + "inf") for sign in ("", "+", "-") for word in (".inf", ".Inf", ".INF")},
}
_WHOLE = re.compile(r"[-+]?(0|[1-9][0-9]*)")
_NUMBER = re.compile(r"[-+]?(\.[0-9]+|(0|[1-9][0-9]*)(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
# Those that YAML does not allow, and those that it may take for line breaks where nobody sees one.
_CONTROL = re.compile("[^\t\n\r -~\xa0-\u2027\u202a-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_LINE_BREAK = re.compile("\r\n|\r|\n")


class YamlMap(dict[str, Any]):
    """A map as it was read. `lines` holds the line of each key, counted from 1."""

    def __init__(self) -> None:
        super().__init__()
        self.lines: dict[str, int] = {}


class _RefusedError(Exception):
    """What was refused, in words, and its line."""

    def __init__(self, line: int, reason: str) -> None:
        super().__init__(reason)
        self.line = line


class _Composer(yaml.SafeLoader):
    """PyYAML up to its tree of nodes. It makes no Python objects, follows no alias and goes no deeper than it may."""

    yaml_implicit_resolvers: ClassVar[dict[str, Any]] = {}  # What a text without quotes stands for is decided below.

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        event = self.peek_event()
        line = event.start_mark.line + 1
        if event.anchor is not None:
            raise _RefusedError(line, "anchors and aliases (& and *) are not read; write the value out")
        if event.tag is not None:
            raise _RefusedError(line, f"tags (here {quoted(event.tag)}) are not read; write the value alone")
        if self._depth == MAX_DEPTH:
            raise _RefusedError(line, f"a value is nested more than {MAX_DEPTH} levels deep")
        self._depth += 1
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node


def read_text(path: Path) -> str:
    """The text of a file of settings.

    Raises:
      OSError: when it cannot be read; names the file.
      ScenarioError: when it is too long or not UTF-8; names the file.
    """
    shown = one_line(str(path), PATH_LENGTH)
    content = read_bytes(path, 4 * MAX_LENGTH + 1)
    if len(content) > 4 * MAX_LENGTH:
        raise ScenarioError(f"{shown}: {_TOO_LONG}")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = _line_at(content[: error.start].decode("utf-8"))
        raise ScenarioError(f"{shown}, line {line}: is not UTF-8 text") from error


def read_yaml(text: str, source: str) -> Any:
    """A YAML document as YamlMap, list, str, int, float, bool and None.

    Args:
      source: what to call the text in errors.
    Raises:
      ScenarioError: names the source and the line of what is no YAML or is refused.
    """
    if len(text) > MAX_LENGTH:
        raise ScenarioError(f"{source}: {_TOO_LONG}")
    if found := _CONTROL.search(text):
        character = f"U+{ord(found[0]):04X}"
        raise ScenarioError(
            f"{source}, line {_line_at(text[: found.start()])}: holds the control character {character}"
        )
    composer = _Composer(text)
    try:
        node = composer.get_single_node()
        return None if node is None else _value(node)
    except _RefusedError as error:
        raise ScenarioError(f"{source}, line {error.line}: {error}") from error
    except yaml.MarkedYAMLError as error:
        line = (error.problem_mark or error.context_mark).line + 1
        reason = shorten(", ".join(part for part in (error.context, error.problem) if part), 300)
        raise ScenarioError(f"{source}, line {line}: cannot be read as YAML: {reason}") from error
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # PyYAML lets some of Python's own errors through.
        reason = shorten(str(error), 300)
        raise ScenarioError(f"{source}, line {composer.line + 1}: cannot be read as YAML: {reason}") from error


def plain_value(text: str) -> str | int | float | bool | None:
    """What a text without quotes stands for: null, true or false, a number, or else itself."""
    if text in _WORDS:
        return _WORDS[text]
    if _WHOLE.fullmatch(text) and len(text) <= MAX_DIGITS:
        return int(text)
    return float(text) if _NUMBER.fullmatch(text) else text


_TOO_LONG = f"is longer than {MAX_LENGTH} characters, and so no file of settings"


def _line_at(text: str) -> int:
    """The line, counted from 1, on which a text ends."""
    return len(_LINE_BREAK.findall(text)) + 1


def _value(node: Any) -> Any:
    if isinstance(node, yaml.MappingNode):
        return _map(node)
    if isinstance(node, yaml.SequenceNode):
        return [_value(entry) for entry in node.value]
    if node.style is not None:  # in quotes, or a block of text
        return node.value
    if len(node.value) > MAX_DIGITS and _WHOLE.fullmatch(node.value):
        raise _RefusedError(node.start_mark.line + 1, f"a number of {len(node.value)} digits is too long")
    return plain_value(node.value)


def _map(node: Any) -> YamlMap:
    made = YamlMap()
    for key_node, value_node in node.value:
        line = key_node.start_mark.line + 1
        key = _value(key_node)
        if not isinstance(key, str):
            raise _RefusedError(line, f"a key must be a word, is {quoted(key)}")
        if key in made:
            raise _RefusedError(line, f"{named(key)} is set twice, first in line {made.lines[key]}")
        made[key], made.lines[key] = _value(value_node), line
    return made
