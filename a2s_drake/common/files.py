"""Files on a disk that others use too: written whole or not at all, and checked when they are read."""

import contextlib
import errno
import fcntl
import os
import secrets
import stat
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from io import BytesIO
from pathlib import Path

import numpy as np

from a2s_drake.common.arrays import Array, FloatArray


class DamagedFileError(ValueError):
    """A file that does not hold what it should. The message is one line that names the file."""


class ResultsError(OSError):
    """Results that cannot be written; its one line also says what is kept."""


@contextlib.contextmanager
def what_is_kept(words: str) -> Iterator[None]:
    """Raises ResultsError, which adds what is kept, for an OSError of the code inside."""
    try:
        yield
    except OSError as failure:
        raise ResultsError(f"{in_words(failure)}; {words}") from failure


def in_words(error: Exception) -> str:
    """An error in one line, that of a disk as `results/flight.npz: No space left on device`."""
    if isinstance(error, OSError) and error.filename is not None and error.strerror:
        return f"{error.filename}: {error.strerror}"
    return str(error)


@contextlib.contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """A new file to write in place of `path`, moved there at the end: an interrupt leaves the old file or the new one.

    The new file has a name of its own in the same folder, so two processes can write the same `path`. It gets the
    permissions of the file that it replaces, or those that the umask leaves. A symbolic link at `path` stays, and the
    file that it points to is written.

    Raises:
      OSError: when the disk refuses, or `path` is there and is no regular file; names `path`.
    """
    target, mode = _destination(path)
    part = _reserve(target.parent, path)
    try:
        if mode is not None:
            # What was for its owner alone stays so while it is written. The owner must be able to write.
            part.chmod(mode | stat.S_IWUSR)
        yield part
        if mode is not None and not mode & stat.S_IWUSR:
            part.chmod(mode)
        part.replace(target)
    except OSError as error:
        # A failed write() knows no file name, and the name of the part would tell the user nothing.
        if error.errno is not None and error.filename in (None, part, str(part)):
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise
    finally:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)


def check_writable(path: Path) -> None:
    """Checks that `written_whole` can write a file, by making an empty one beside it for a moment.

    Raises:
      OSError: when it cannot; names the file.
    """
    target, _ = _destination(path)
    _reserve(target.parent, path).unlink()


def check_folder(folder: Path) -> None:
    """Checks that a folder is there or can be made, and that files can be written in it. It leaves nothing behind.

    Raises:
      OSError: when it cannot.
    """
    folder = folder.absolute()
    missing = []
    while not os.path.lexists(folder):
        missing.append(folder.name)
        folder = folder.parent
    for name in missing:
        _destination(folder / name)  # which refuses a name that is too long
    _reserve(folder, folder).unlink()


def _destination(path: Path) -> tuple[Path, int | None]:
    """Where links lead from a path, and the permissions of the file that is there, if any."""
    try:
        found = path.stat()
    except FileNotFoundError:
        return Path(os.path.realpath(path)), None
    except ValueError as error:
        raise OSError(errno.EINVAL, "the name is no file name", str(path)) from error
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "not a regular file", str(path))
    return Path(os.path.realpath(path)), stat.S_IMODE(found.st_mode)


def _reserve(folder: Path, path: Path) -> Path:
    """A new empty file in a folder. Its name is short, so that any name the folder allows can be written.

    Raises:
      OSError: when it cannot be made; names the file `path` that it is for.
    """
    part = folder / f".part-{secrets.token_hex(8)}"
    try:
        part.touch(exist_ok=False)
    except OSError as error:
        error.filename = str(path)
        raise
    return part


@contextlib.contextmanager
def held(folder: Path) -> Iterator[None]:
    """Waits until no other process or thread holds a folder, then holds it. It leaves no file.

    The lock binds only those that ask for it. A file system without locks goes on without.
    """
    descriptor = None
    try:
        with contextlib.suppress(OSError):
            descriptor = os.open(folder, os.O_RDONLY)
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        if descriptor is not None:
            os.close(descriptor)  # This gives the lock back.


def read_bytes(path: Path, limit: int = -1) -> bytes:
    """The content of a file, or its first `limit` bytes where that is not negative.

    Raises:
      OSError: when it cannot be read; names the file.
    """
    try:
        with path.open("rb") as file:
            return file.read(limit)
    except OSError as error:
        error.filename = str(path)  # A failed read() knows no file name.
        raise
    except ValueError as error:
        raise OSError(errno.EINVAL, "the name is no file name", str(path)) from error


def write_arrays(path: Path, arrays: Mapping[str, Array]) -> None:
    """Writes an .npz archive of arrays, none of them of Python objects. Equal arrays give equal bytes."""
    with path.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)


def read_arrays(path: Path) -> dict[str, Array]:
    """The arrays of an .npz archive by name. They are as they were written: each is checked against its checksum.

    Raises:
      OSError: when the file cannot be read; names it.
      DamagedFileError: when it is no such archive, an array is not whole, or one holds Python objects.
    """
    content = BytesIO(read_bytes(path))
    try:
        with zipfile.ZipFile(content) as archive:
            return {name.removesuffix(".npy"): _array(archive.read(name)) for name in archive.namelist()}
    except Exception as error:  # One changed byte can have these libraries raise almost any error.
        reason = " ".join(str(error).split()) or type(error).__name__
        raise DamagedFileError(f"{path}: is damaged: {reason}") from error


def check_rows(path: Path, arrays: Mapping[str, Array], widths: Mapping[str, int | None]) -> dict[str, FloatArray]:
    """Arrays that `read_arrays` read and that hold one row per sample: shape (n,) for width 1, else (n, width).

    Args:
      path: the file that they come from, for messages.
      widths: of the arrays to check and return, by name, the first of them not None; whatever else there is is left
        alone. None stands for shape (n, m) with any m.
    Raises:
      DamagedFileError: when an array is missing, is not float64, or has another shape than the others ask for.
    """
    rows = None
    for name, width in widths.items():
        if name not in arrays:
            raise DamagedFileError(f"{path}: {name} is missing")
        array = arrays[name]
        rows = array.shape[:1] if rows is None else rows
        shape: tuple[int | str, ...] = rows if width == 1 else (*rows, "m" if width is None else width)
        # A width that is left open is whatever there is.
        found = (*array.shape[:1], "m") if width is None and array.ndim == 2 else array.shape
        if array.dtype != np.float64 or found != shape or len(rows) != 1:
            wrong = f"{array.dtype} of shape {array.shape}"
            wanted = f"({', '.join(map(str, shape))}{',' * (len(shape) == 1)})" if len(rows) == 1 else "(n,)"
            raise DamagedFileError(f"{path}: {name} is {wrong}, must be float64 of shape {wanted}")
    return {name: arrays[name] for name in widths}


def entries_after(prefix: str, arrays: Iterable[str]) -> dict[str, str]:
    """The names in an archive that begin with a prefix, by the rest of the name."""
    return {name.removeprefix(prefix): name for name in arrays if name.startswith(prefix)}


def read_text_entry(path: Path, arrays: Mapping[str, Array], name: str) -> str:
    """The one line of text that an array of `read_arrays` holds.

    Raises:
      DamagedFileError: when it holds something else.
    """
    array = arrays[name]
    text = array.item() if array.dtype.kind == "U" and array.shape == () else None
    if not isinstance(text, str) or not text.isprintable():
        raise DamagedFileError(f"{path}: {name} must be one line of text")
    return text


def _array(data: bytes) -> Array:
    """An array from the content of an .npy file. Reading all of it first has the archive check its sum."""
    stream = BytesIO(data)
    array: Array = np.lib.format.read_array(stream, allow_pickle=False)
    if stream.read(1):
        raise ValueError("an array is followed by something else")
    return array
