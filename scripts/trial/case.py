"""Case: one command to try, with the files that it is given, and how a person types it again."""

import os
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

SCRIPTS = Path(__file__).parents[1]

# What is longer is kept on disk and copied from there rather than shown.
_SHOWN = 2000


@dataclass(frozen=True)
class Case:
    """A script with arguments, run in a folder of its own that holds some files.

    Attributes:
      arguments: as typed after the script's name; paths are relative to the case's folder.
      files: the content of each file, by name.
      links: where each symbolic link points, by name; made after files and folders.
      folders: the names of empty folders.
      script: the name of a script of the project, or the path of another.
      label: the letter of the kind of draw and its number, which draw the case again.
      kind: what is tried.
      must_refuse: whether any ending but a refusal is a fault.
      fresh: whether it runs in an interpreter of its own rather than in a copy of one that has imported everything.
      timeout: wall-clock seconds after which it counts as hanging.
    """

    arguments: tuple[str, ...]
    files: Mapping[str, bytes] = field(default_factory=dict)
    links: Mapping[str, str] = field(default_factory=dict)
    folders: tuple[str, ...] = ()
    script: str = "simulate"
    label: str = ""
    kind: str = ""
    must_refuse: bool = False
    fresh: bool = False
    timeout: float = 60.0

    @property
    def path(self) -> Path:
        """The file of the script."""
        return SCRIPTS / f"{self.script}.py" if "/" not in self.script else Path(self.script)

    def prepare(self, folder: Path) -> None:
        """Makes a folder that holds the case's files, folders and links."""
        folder.mkdir(parents=True)
        for name in self.folders:
            (folder / name).mkdir()
        for name, content in self.files.items():
            (folder / name).write_bytes(content)
        for name, target in self.links.items():
            (folder / name).symlink_to(target)

    def typed(self, kept: Path) -> str:
        """The shell commands that run this case again, where `kept` is a folder that holds its files."""
        lines = ['cd "$(mktemp -d)"', *(f"mkdir {quoted(name)}" for name in self.folders)]
        for name, content in self.files.items():
            if len(content) > _SHOWN:
                lines.append(f"cp {quoted(str(kept / name))} .")
            else:
                lines.append(f"printf %b {_escaped(content)} > {quoted(name)}")
        lines += [f"ln -s {quoted(target)} {quoted(name)}" for name, target in self.links.items()]
        return "\n".join([*lines, self._command()])

    def _command(self) -> str:
        if any("\0" in text for text in self.arguments):  # which no shell can pass on
            call = f"import sys; from scripts import {self.script} as s; sys.exit(s.main({list(self.arguments)!r}))"
            return f"python -c {shlex.quote(call)}"
        return " ".join(["python", quoted(str(self.path)), *map(quoted, self.arguments)])


def quoted(text: str) -> str:
    """A text as a word of bash, with escapes for all that does not print."""
    if text.isprintable():
        return shlex.quote(text)
    return "$'" + "".join(_escape(byte) for byte in os.fsencode(text)) + "'"


def _escape(byte: int) -> str:
    return f"\\x{byte:02x}" if not 32 <= byte < 127 or byte in b"\\'" else chr(byte)


def _escaped(content: bytes) -> str:
    """A file's content for `printf %b`; octal escapes, which cannot swallow a digit that follows them."""
    plain = (chr(b) if 32 <= b < 127 and b != 0x5C else "\\n" if b == 0x0A else f"\\0{b:03o}" for b in content)
    return shlex.quote("".join(plain))
