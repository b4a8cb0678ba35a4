"""Ways to damage a file or a disk, and what must come of it."""

import contextlib
import io
import resource
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from a2s_drake.common.files import DamagedFileError
from a2s_drake.guidance.plan.cache import OtherPlanError

FLIPS = 400


@contextlib.contextmanager
def full_disk(size: int) -> Iterator[None]:
    """Has every file refuse to grow beyond so many bytes, as on a disk that is full."""
    before, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (before, most))


def content(path: Path) -> dict[str, np.ndarray]:
    with np.load(path) as archive:
        return dict(archive)


def rewrite(path: Path, **changed: np.ndarray | None) -> None:
    """Writes an archive anew with some of its arrays changed, or left out where they are None."""
    arrays = {name: array for name, array in (content(path) | changed).items() if array is not None}
    np.savez(path, **arrays)


def flipped(file: Path, rng: np.random.Generator) -> None:
    """Turns over one bit of a file, anywhere in it."""
    data = bytearray(file.read_bytes())
    place = int(rng.integers(8 * len(data)))
    data[place // 8] ^= 1 << place % 8
    file.write_bytes(data)


def flip_many(file: Path, rng: np.random.Generator, load: Callable[[], list[np.ndarray]]) -> tuple[int, int]:
    """How many of many flips load to the arrays as they were, and how many are refused on one line."""
    whole, right = file.read_bytes(), load()
    same = refused = 0
    for _ in range(FLIPS):
        flipped(file, rng)
        try:
            for was, now in zip(right, load(), strict=True):
                np.testing.assert_array_equal(now, was)
            same += 1
        except (DamagedFileError, OtherPlanError) as error:
            assert str(error).startswith(str(file))
            assert "\n" not in str(error)
            refused += 1
        file.write_bytes(whole)
    return same, refused


def archive_of(**arrays: np.ndarray) -> bytes:
    archive = io.BytesIO()
    np.savez(archive, **arrays)
    return archive.getvalue()


def encrypted() -> bytes:
    """An archive that says of its one entry, in both places, that it is encrypted."""
    data = bytearray(archive_of(time=np.zeros(3)))
    data[6] |= 1
    data[data.index(b"PK\x01\x02") + 8] |= 1
    return bytes(data)
