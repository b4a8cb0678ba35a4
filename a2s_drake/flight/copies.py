"""Copies: the track files that a saved flight keeps beside its log, under names that no file of the user's has."""

import copy
import hashlib
import os
import re
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import numpy as np

from a2s_drake.common.arrays import Array
from a2s_drake.common.files import DamagedFileError, entries_after, read_arrays, read_bytes, read_text_entry
from a2s_drake.scenario.checks import ScenarioError
from a2s_drake.scenario.parts import Mission
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.scenario.track_file import COPIES, MAX_BYTES, read_content, read_files

# An entry `copy:path.csv` of flight.npz holds the SHA-256 of that copy as the flight wrote it.
_NOTE = "copy:"

# A log may be damaged or made by others, so a name in it counts only where a flight could have chosen it.
_NAME = re.compile(r"(?:path|ship_track)(?:_[0-9]+)?\.csv")


@dataclass(frozen=True)
class Copies:
    """The track files of a flight that is about to be saved in a folder.

    Attributes:
      scenario: the flight's, but it names the copies.
      written: the content of each copy that is to be written, by its name. The others are there already, as files of
        the user's own.
      left_over: the SHA-256 of each copy that an earlier flight has written in the folder, by its name, and that this
        flight does not name.
      folder: where the flight is saved.
    """

    scenario: Scenario
    written: Mapping[str, bytes]
    left_over: Mapping[str, str]
    folder: Path

    @classmethod
    def placed(cls, folder: Path, scenario: Scenario, files: Mapping[str, bytes]) -> "Copies":
        """Chooses a name for each copy: `path.csv`, or `path_2.csv` and so on where a file of the user's stands there.

        A file of the user's that holds the same already serves as the copy and is left as it is.

        Args:
          files: content by field of `mission`; a file that is not among them is read now.
        Raises:
          ScenarioError: when a file cannot be read; names it.
        """
        noted, changed, written = _noted(folder), copy.deepcopy(scenario), {}
        for field, content in read_files(scenario.mission, files).items():
            for name in _names(COPIES[field]):
                if not os.path.lexists(folder / name) or _is_as_written(folder / name, noted.get(name)):
                    written[name] = content
                    break
                if _digest(folder / name) == _sha256(content):
                    break
            setattr(changed.mission, field, name)
            noted.pop(name, None)
        return cls(changed, written, noted, folder)

    def notes(self) -> dict[str, Array]:
        """What flight.npz says about the copies that are written, by the entry's name."""
        return {_NOTE + name: np.array(_sha256(content)) for name, content in self.written.items()}

    def remove_left_over(self) -> None:
        """Removes the copies that an earlier flight has written here, except where their content was changed since."""
        for name, digest in self.left_over.items():
            if _is_as_written(self.folder / name, digest):
                (self.folder / name).unlink(missing_ok=True)


def read_copies(mission: Mission) -> dict[str, bytes]:
    """The content of each track file that a saved mission names, by field. A warning names each that cannot be read."""
    files: dict[str, bytes] = {}
    for field in COPIES:
        name = getattr(mission, field)
        if name is None:
            continue
        try:
            files[field] = read_content(field, name)
        except ScenarioError as error:
            warnings.warn(f"{error}; the flight is loaded without this file", stacklevel=3)
    return files


def _names(first: str) -> Iterator[str]:
    yield first
    yield from (f"{Path(first).stem}_{number}{Path(first).suffix}" for number in count(2))


def _noted(folder: Path) -> dict[str, str]:
    """The copies that an earlier flight in a folder has written, with their SHA-256; none where there is no flight."""
    log = folder / "flight.npz"
    try:
        arrays = read_arrays(log)
        notes = entries_after(_NOTE, arrays).items()
        return {name: read_text_entry(log, arrays, entry) for name, entry in notes if _NAME.fullmatch(name)}
    except (OSError, DamagedFileError):
        return {}


def _is_as_written(path: Path, digest: str | None) -> bool:
    return digest is not None and _digest(path) == digest


def _digest(path: Path) -> str | None:
    """The SHA-256 of a regular file; None for anything else. A link is the user's: a flight writes none."""
    try:
        if path.is_symlink() or not path.is_file():
            return None
        return _sha256(read_bytes(path, MAX_BYTES + 1))
    except OSError:
        return None


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
