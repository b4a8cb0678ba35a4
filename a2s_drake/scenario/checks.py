"""Range checks of scenario parts, driven by the limits declared beside each field."""

import math
from dataclasses import fields
from typing import Any

from a2s_drake.common.quoting import MESSAGE_LENGTH, named, one_line, quoted
from a2s_drake.scenario.parts import Airframe


class ScenarioError(ValueError):
    """A scenario that cannot be flown. The message names the field, its value and what is allowed, on one line."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message, MESSAGE_LENGTH))


def refuse(name: str, value: object, allowed: str) -> ScenarioError:
    """The one shape of message: `name = value: allowed`. A long value is shortened."""
    return ScenarioError(f"{named(name)} = {quoted(value)}: {allowed}")


def describe_limits(limits: dict[str, Any]) -> str:
    """What a field may be, in words: `must be finite, above 0.0, at most 1.0`."""
    if limits.get("choices") == (False, True):
        return "must be true or false"
    if "choices" in limits:
        return "must be one of " + ", ".join(str(choice) for choice in limits["choices"])
    if "file" in limits:
        return "must be the name of a file"
    words = {"above": "above", "at_least": "at least", "below": "below", "at_most": "at most"}
    bounds = [f"{word} {limits[key]}" for key, word in words.items() if key in limits]
    return "must be " + ", ".join(["finite", *bounds])


def _within(value: Any, limits: dict[str, Any]) -> bool:
    if "choices" in limits:
        return value in limits["choices"]
    if "file" in limits:
        return value != "" and "\0" not in value
    return (
        # Every integer is finite, but Python cannot say so of one that is too large for a float.
        (isinstance(value, int) or math.isfinite(value))
        and value > limits.get("above", -math.inf)
        and value >= limits.get("at_least", -math.inf)
        and value < limits.get("below", math.inf)
        and value <= limits.get("at_most", math.inf)
    )


def check_part(section: str, part: Any) -> None:
    """Checks each field of one scenario part against its own limits.

    Raises:
      ScenarioError: for the first field that is not finite, out of range, of the wrong length or not a choice.
    """
    for spec in fields(part):
        name, value, limits = f"{section}.{spec.name}", getattr(part, spec.name), dict(spec.metadata)
        if value is None and spec.default is None:
            continue
        length = limits.pop("length", None)
        if length is not None and len(value) != length:
            raise refuse(name, value, f"must have {length} entries, has {len(value)}")
        entries = [value] if length is None else value
        if not all(_within(entry, limits) for entry in entries):
            raise refuse(name, value, describe_limits(limits))


def check_order(section: str, part: Any, low: str, high: str, *, strict: bool = True) -> None:
    """Checks that field `low` lies below field `high` (entry by entry for lists); equality passes unless `strict`."""
    lower, upper = getattr(part, low), getattr(part, high)
    pairs = zip(lower, upper, strict=True) if isinstance(lower, list) else [(lower, upper)]
    if not all(a < b or (a == b and not strict) for a, b in pairs):
        relation = "below" if strict else "at most"
        raise refuse(f"{section}.{low}", lower, f"must be {relation} {section}.{high} = {upper!r}")


def check_inertia(airframe: Airframe) -> None:
    """Checks that the principal moments belong to some mass distribution: none exceeds the sum of the other two."""
    moments = airframe.inertia
    if 2.0 * max(moments) > sum(moments) * (1.0 + 1e-12):
        raise refuse("airframe.inertia", moments, "no moment may exceed the sum of the other two")
