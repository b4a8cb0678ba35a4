"""Field values: what YAML or a caller holds, as the type that a field declares, or refused with how to write it."""

import re
from numbers import Integral, Real
from types import NoneType
from typing import Any, get_args, get_origin

from a2s_drake.scenario.checks import refuse
from a2s_drake.scenario.yaml_reader import plain_value

_KINDS = {float: "a number", int: "a whole number", bool: "true or false", str: "a word"}
_LISTS = {
    float: "a list of numbers, such as [1, 2.5]",
    int: "a list of whole numbers, such as [1, 2]",
    bool: "a list of truth values, such as [true, false]",
    str: "a list of words, such as [one, two]",
}

# How people write numbers elsewhere, and what to do about it here.
_SLIPS = {
    r"[-+]?0[xob].*": "in decimal digits",
    r".*_.*": "without underscores",
    r".*:.*": "without colons",
    r".*,.*": "with a decimal point",
    r"[-+]?0[0-9].*": "without leading zeros",
    r".*[^0-9.]": "without a unit",
}


def field_value(name: str, value: Any, hint: Any) -> Any:
    """A value as the type that a field declares: float, int, bool, str, a list of one of them, or any of these or None.

    Whole numbers are taken for numbers. Nothing else is converted.

    Args:
      name: what to call the field in errors.
      hint: the field's type.
    Raises:
      ScenarioError: when the value has another type, or is too large for a float.
    """
    kind, *others = [entry for entry in get_args(hint) if entry is not NoneType] if _may_be_null(hint) else [hint]
    if others:
        raise TypeError(f"{name}: no values are known for the type {hint}")
    if value is None and _may_be_null(hint):
        return None
    if get_origin(kind) is list and isinstance(value, list | tuple):
        (entry_kind,) = get_args(kind)
        return [field_value(f"{name}[{place}]", entry, entry_kind) for place, entry in enumerate(value)]
    if _is_of(value, kind):
        try:
            return kind(value)
        except OverflowError as error:
            raise refuse(name, value, "must be a number of at most 1.7e308") from error
    words = _LISTS[get_args(kind)[0]] if get_origin(kind) is list else _KINDS[kind]
    if kind is str and _may_be_null(hint):
        words = "a text, in quotes where it looks like a number,"
    or_null = " or null" if _may_be_null(hint) else ""
    raise refuse(name, value, f"must be {words}{or_null}{_advice(value, kind)}")


def _may_be_null(hint: Any) -> bool:
    return NoneType in get_args(hint)


def _is_of(value: Any, kind: Any) -> bool:
    if kind in (float, int):
        return isinstance(value, Real if kind is float else Integral) and not isinstance(value, bool)
    return kind in (bool, str) and isinstance(value, kind)


def _advice(value: Any, kind: Any) -> str:
    """How to write what was probably meant, behind a comma; empty where that is unclear."""
    if kind is int and isinstance(value, float) and value.is_integer():
        return ", written without a decimal point or an exponent"
    if not isinstance(value, str):
        return ""
    text = value.strip()
    if _is_of(plain_value(text), kind) and kind is not str:
        return ", written without quotes"
    if kind in (float, int) and re.match(r"[-+]?\.?[0-9]", text):
        for slip, words in _SLIPS.items():
            if re.fullmatch(slip, text):
                return f", written {words}"
    return ""
