"""The standard streams of a script: there even where the caller closed them, and silent where their reader has left."""

import contextlib
import io
import os
import select
import sys
from typing import TextIO

# Why what was printed to standard output is lost, if it is.
losses: list[str] = []


class _TakesAll(io.FileIO):
    """A standard stream that never fails: what cannot be written is dropped, so that the work itself goes on."""

    def write(self, data: "bytes | bytearray | memoryview", /) -> int | None:  # type: ignore[override]
        try:
            return super().write(data)
        except OSError as failure:
            # A reader that leaves has seen enough. Any other failure loses output that somebody wants to see.
            if not isinstance(failure, BrokenPipeError) and self.fileno() == 1:
                losses.append(failure.strerror or str(failure))
            drop(self.fileno())
            return len(data)


def drop(descriptor: int) -> None:
    """Sends what is written to a descriptor to the null device from now on."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, descriptor)
    os.close(null)


def drop_unread_output() -> None:
    """Drops standard output where writing to it would wait for a reader that does not read."""
    with contextlib.suppress(OSError, ValueError):
        if not select.select([], [1], [], 0.0)[1]:
            drop(1)


def open_closed() -> None:
    """Opens the null device in place of each standard stream that the caller closed.

    The next file to be opened would otherwise get its number, and what is printed would end up in that file.
    """
    for descriptor, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(descriptor)
        except OSError:
            # Lower numbers are taken, so this one is the next. Worker processes inherit it like any standard stream.
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
        if getattr(sys, name) is None:
            raw = io.FileIO(descriptor, "r" if descriptor == 0 else "w", closefd=False)
            buffered = io.BufferedReader(raw) if descriptor == 0 else io.BufferedWriter(raw)
            setattr(sys, name, io.TextIOWrapper(buffered, encoding="utf-8"))


def guard() -> None:
    """Has printing to standard output and standard error never fail; `losses` tells of what was lost."""
    sys.stdout, sys.stderr = _guarded(sys.stdout), _guarded(sys.stderr)


def _guarded(stream: TextIO) -> TextIO:
    raw = _TakesAll(stream.fileno(), "w", closefd=False)
    return io.TextIOWrapper(
        raw if stream.write_through else io.BufferedWriter(raw),
        encoding=stream.encoding,
        errors=stream.errors,
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )
