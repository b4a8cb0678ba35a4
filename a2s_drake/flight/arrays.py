"""What an array of a flight's log holds: its unit, and the names of its columns."""

from collections.abc import Sequence
from dataclasses import field
from typing import Any

ANGLES = ("roll", "pitch", "yaw")


def columns_of(unit: str, column: str, parts: Sequence[str] = ("",)) -> list[str]:
    """The names of an array's columns; each ends in the unit, if there is one."""
    suffix = f"_{unit.lower().replace('/', '_per_')}" if unit else ""
    return [column.format(part) + suffix for part in parts]


def logged(unit: str, column: str, parts: Sequence[str] = ("",)) -> dict[str, Any]:
    """The metadata of an array that every diagram gives."""
    return {"unit": unit, "columns": columns_of(unit, column, parts), "optional": False}


def optional(unit: str, columns: Sequence[str]) -> Any:
    """The field of an array that not every diagram gives. A flight that is made without it holds NaN there."""
    return field(default=None, metadata={"unit": unit, "columns": list(columns), "optional": True})


def shape_of(rows: int, columns: Sequence[str]) -> tuple[int, ...]:
    """The shape of an array with some rows and these columns: a single column makes a vector."""
    return (rows,) if len(columns) == 1 else (rows, len(columns))


STATE_UNIT = "m, rad, m/s, rad/s"


def state_columns(prefix: str) -> list[str]:
    """The names of the columns of a vehicle's 12 states, whose parts have units of their own."""
    return [
        *columns_of("m", prefix + "position_{}", "xyz"),
        *columns_of("rad", prefix + "{}", ANGLES),
        *columns_of("m/s", prefix + "velocity_{}", "xyz"),
        *columns_of("rad/s", prefix + "angular_velocity_{}", "xyz"),
    ]
