"""Track files: the CSV files that a scenario may name for the UAV's path and the ship's track.

A scenario holds only the name of such a file. The file is read when a motion is made of it, so that no old content is
used. A flight keeps the content that its diagram was built with, see `a2s_drake.flight.log.Flight.files`.
"""

import copy
import csv
import errno
import hashlib
import io
import math
import os
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.files import read_bytes
from a2s_drake.common.quoting import quoted
from a2s_drake.scenario.checks import ScenarioError, refuse
from a2s_drake.scenario.parts import Mission
from a2s_drake.scenario.scenario import Scenario

# The fields of `mission` that name a track file, and what a copy of that file beside a flight is called.
COPIES = {"path_file": "path.csv", "ship_track_file": "ship_track.csv"}

_HEADERS = {
    "path_file": (("time", "x", "y", "z"),),
    "ship_track_file": (("time", "x", "y"), ("time", "x", "y", "z")),
}

# 200,000 rows are more than an hour at 20 ms; Drake makes a spline of them in two seconds.
MAX_ROWS = 200_000
MAX_BYTES = 20_000_000
# The farthest point, m, as for `mission.ship_start`, and the last instant, s, as for `mission.duration`.
MAX_COORDINATE = 1e6
MAX_TIME = 86400.0
# Rows that are closer in time than this, s, must be a mistake: no path needs a point every microsecond.
MIN_STEP = 1e-6


def read_files(mission: Mission, known: Mapping[str, bytes] | None = None) -> dict[str, bytes]:
    """The content of each track file that a mission names, by field.

    Args:
      known: content by field; a file that is not among them is read now.
    Raises:
      ScenarioError: when one cannot be read, is no regular file or too large; names the field and the file.
    """
    known, names = known or {}, {field: getattr(mission, field) for field in COPIES}
    return {
        field: known[field] if field in known else read_content(field, name)
        for field, name in names.items()
        if name is not None
    }


def read_content(field: str, name: str) -> bytes:
    """The content of the track file that a field of `mission` names.

    Raises:
      ScenarioError: when it cannot be read, is no regular file or too large; names the field and the file.
    """
    try:
        mode = Path(name).stat().st_mode
        if stat.S_ISDIR(mode):
            raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
        if not stat.S_ISREG(mode):  # Reading a pipe or a device might never end.
            raise OSError(errno.EINVAL, "must be a regular file")
        content = read_bytes(Path(name), MAX_BYTES + 1)
    except OSError as error:
        raise refuse(f"mission.{field}", name, error.strerror or str(error)) from error
    except ValueError as error:
        raise refuse(f"mission.{field}", name, "the name is no file name") from error
    if len(content) > MAX_BYTES:
        raise refuse(f"mission.{field}", name, f"must be at most {MAX_BYTES // 1_000_000} MB long")
    return content


def read_track(mission: Mission, field: str, content: bytes | None = None) -> tuple[FloatArray, FloatArray]:
    """The track that a field of a mission names: times, s, shape (n,), and points, m, shape (n, columns).

    Args:
      field: `path_file`, whose points are x, y, z; or `ship_track_file`: x, y and, where the file has it, z.
      content: of the file, where it is known; without it the file is read.
    Raises:
      ScenarioError: when the file cannot be read or holds no track; names the field, the file and the line.
    """
    name = getattr(mission, field)
    if content is None:
        content = read_content(field, name)

    def refused(line: int, words: str) -> ScenarioError:
        return refuse(f"mission.{field}", name, f"line {line}: {words}")

    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise refused(content.count(b"\n", 0, error.start) + 1, "must be UTF-8 text") from error
    reader = csv.reader(io.StringIO(text, newline=""))
    rows = _filled(reader)
    table: list[list[float]] = []
    try:
        header = tuple(name.lower() for name in next(rows, ()))
        if header not in _HEADERS[field]:
            allowed = " or ".join(map(",".join, _HEADERS[field]))
            raise refused(max(reader.line_num, 1), f"the header must be {allowed}, is {quoted(','.join(header))}")
        for row in rows:
            try:
                table.append(_numbers(row, header, table))
            except ValueError as error:
                raise refused(reader.line_num, str(error)) from error
    except csv.Error as error:
        raise refused(reader.line_num, f"cannot be read as CSV: {error}") from error
    if len(table) < 2:
        raise refused(reader.line_num, f"must hold at least 2 rows of numbers, holds {len(table)}")
    values = np.array(table)
    return values[:, 0], values[:, 1:]


def _filled(reader: Iterator[list[str]]) -> Iterator[list[str]]:
    """The rows that hold something, without blanks around the cells."""
    for row in reader:
        cells = [cell.strip() for cell in row]
        if any(cells):
            yield cells


def _numbers(row: list[str], header: tuple[str, ...], before: list[list[float]]) -> list[float]:
    """A row of a track as numbers; ValueError says in words what stands in the way."""
    if len(row) != len(header):
        raise ValueError(f"must hold {len(header)} numbers ({','.join(header)}), holds {len(row)}")
    if len(before) == MAX_ROWS:
        raise ValueError(f"a track must have at most {MAX_ROWS} rows")
    numbers = [_number(name, cell) for name, cell in zip(header, row, strict=True)]
    time = numbers[0]
    if not before and time != 0.0:
        raise ValueError(f"time must start at 0, is {time!r}")
    if before and time < before[-1][0] + MIN_STEP:
        raise ValueError(f"time must increase by at least {MIN_STEP:g} s, is {time!r} after {before[-1][0]!r}")
    return numbers


def _number(name: str, cell: str) -> float:
    limit = MAX_TIME if name == "time" else MAX_COORDINATE
    try:
        # Python reads 1_000 and digits of other scripts too; other programs do not.
        value = float(cell) if cell.isascii() and "_" not in cell else math.nan
    except ValueError:
        value = math.nan
    if not abs(value) <= limit:
        raise ValueError(f"{name} must be a number of at most {limit:g} in magnitude, is {quoted(cell)}")
    return value


def by_content(scenario: Scenario, files: Mapping[str, bytes]) -> Scenario:
    """A scenario with a digest of each track file in place of its name, to compare scenarios by what is flown.

    Args:
      files: content by field; a file that is not among them is read now.
    """
    changed = copy.deepcopy(scenario)
    for field, content in read_files(scenario.mission, files).items():
        setattr(changed.mission, field, f"sha256 {hashlib.sha256(content).hexdigest()}")
    return changed
