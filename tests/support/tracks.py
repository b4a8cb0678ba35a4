"""Track files for tests, written without the library."""

from pathlib import Path

import numpy as np


def write_track(file: Path, time: np.ndarray, points: np.ndarray, header: str = "time,x,y,z") -> str:
    """Writes times (n,) and points (n, columns) as a CSV file, every digit of them; returns its name."""
    rows = [",".join(map(repr, map(float, row))) for row in np.column_stack([time, points])]
    file.write_text("\n".join([header, *rows]) + "\n")
    return str(file)


def circle(time: np.ndarray, radius: float = 2.65, duration: float = 40.0) -> np.ndarray:
    """The paper's circle from the origin, by complex numbers, m, shape (n, 3)."""
    s = 0.5 * (1.0 - np.cos(np.pi * np.clip(time / duration, 0.0, 1.0)))
    place = radius * (np.exp(2j * np.pi * s) - 1.0)
    return np.stack([place.real, place.imag, np.zeros_like(s)], axis=-1)
