"""Triangle meshes for the replay's scene: tubes, prisms, and strokes from which lines and text are drawn."""

from typing import NamedTuple

import numpy as np

from a2s_drake.common.arrays import FloatArray

# The seven segments of a digit, on a grid one wide and two high.
_TOP, _MIDDLE, _BOTTOM = ((0, 2), (1, 2)), ((0, 1), (1, 1)), ((0, 0), (1, 0))
_UPPER_LEFT, _UPPER_RIGHT = ((0, 1), (0, 2)), ((1, 1), (1, 2))
_LOWER_LEFT, _LOWER_RIGHT = ((0, 0), (0, 1)), ((1, 0), (1, 1))
_LEFT, _RIGHT = (_UPPER_LEFT, _LOWER_LEFT), (_UPPER_RIGHT, _LOWER_RIGHT)

GLYPHS: dict[str, tuple[tuple[tuple[float, float], tuple[float, float]], ...]] = {
    "0": (_TOP, _BOTTOM, *_LEFT, *_RIGHT),
    "1": _RIGHT,
    "2": (_TOP, _UPPER_RIGHT, _MIDDLE, _LOWER_LEFT, _BOTTOM),
    "3": (_TOP, _MIDDLE, _BOTTOM, *_RIGHT),
    "4": (_UPPER_LEFT, _MIDDLE, *_RIGHT),
    "5": (_TOP, _UPPER_LEFT, _MIDDLE, _LOWER_RIGHT, _BOTTOM),
    "6": (_TOP, *_LEFT, _MIDDLE, _LOWER_RIGHT, _BOTTOM),
    "7": (_TOP, *_RIGHT),
    "8": (_TOP, _MIDDLE, _BOTTOM, *_LEFT, *_RIGHT),
    "9": (_TOP, _MIDDLE, _BOTTOM, _UPPER_LEFT, *_RIGHT),
    "-": (_MIDDLE,),
    ".": (((0.45, 0), (0.55, 0)),),
    " ": (),
    "B": (*_LEFT, ((0, 2), (0.8, 2)), ((0.8, 2), (0.8, 1)), _MIDDLE, _LOWER_RIGHT, _BOTTOM),
    "N": (*_LEFT, *_RIGHT, ((0, 2), (1, 0))),
    "R": (*_LEFT, _TOP, _UPPER_RIGHT, _MIDDLE, ((0.4, 1), (1, 0))),
    "S": (_TOP, _UPPER_LEFT, _MIDDLE, _LOWER_RIGHT, _BOTTOM),
    "d": (*_RIGHT, _MIDDLE, _LOWER_LEFT, _BOTTOM),
    "e": (((0, 1.2), (1, 1.2)), ((1, 1.2), (1, 0.6)), ((0, 0.6), (1, 0.6)), ((0, 1.2), (0, 0)), _BOTTOM),
    "i": (((0.5, 0), (0.5, 1.2)), ((0.5, 1.6), (0.5, 1.7))),
    "m": (((0, 0), (0, 1.2)), ((0, 1.2), (1, 1.2)), ((0.5, 1.2), (0.5, 0)), ((1, 1.2), (1, 0))),
    "n": (((0, 0), (0, 1.2)), ((0, 1.2), (1, 1.2)), ((1, 1.2), (1, 0))),
    "s": (
        *(((0, 1.2), (1, 1.2)), ((0, 1.2), (0, 0.6)), ((0, 0.6), (1, 0.6))),
        *(((1, 0.6), (1, 0)), _BOTTOM),
    ),
    "t": (((0.4, 0), (0.4, 2)), ((0, 1.2), (0.9, 1.2)), ((0.4, 0), (0.9, 0))),
}
ADVANCE = 1.7  # from one character to the next, in character widths


class Mesh(NamedTuple):
    """A triangle mesh: `vertices` (3, n) in m, and `faces` (3, m), each column three columns of `vertices`."""

    vertices: FloatArray
    faces: np.ndarray[tuple[int, int], np.dtype[np.int32]]


def tube(start: FloatArray, end: FloatArray, start_radius: float, end_radius: float, sides: int = 8) -> Mesh:
    """An open tube between two points (3), m, whose radius (m) goes evenly from one value to the other."""
    axis = (end - start) / max(float(np.linalg.norm(end - start)), 1e-12)
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= max(float(np.linalg.norm(across)), 1e-12)
    turn = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.outer(across, np.cos(turn)) + np.outer(np.cross(axis, across), np.sin(turn))
    vertices = np.hstack([start[:, np.newaxis] + start_radius * ring, end[:, np.newaxis] + end_radius * ring])
    return Mesh(vertices, _walls(sides))


def prism(outline: FloatArray, bottom: float, top: float) -> Mesh:
    """A closed prism over a convex counter-clockwise outline, shape (n, 2), m, between two heights, m."""
    n = len(outline)
    vertices = np.vstack([np.tile(outline.T, 2), np.repeat([bottom, top], n)])
    fan = np.array([[0, i, i + 1] for i in range(1, n - 1)], dtype=np.int32).T
    faces = np.hstack([_walls(n), fan[::-1], fan + n])
    # Corners of their own for every triangle, so that the edges look sharp.
    return Mesh(vertices[:, faces.T.ravel()], np.arange(faces.size, dtype=np.int32).reshape(-1, 3).T)


def _walls(n: int) -> np.ndarray[tuple[int, int], np.dtype[np.int32]]:
    """Faces between ring 0..n-1 and ring n..2n-1."""
    here, there = np.arange(n), np.roll(np.arange(n), -1)
    return np.hstack([[here, there, there + n], [here, there + n, here + n]]).astype(np.int32)


def strokes(segments: FloatArray, width: float) -> Mesh:
    """Flat strokes of a given width in the plane z = 0, seen from +z.

    Args:
      segments: end points, m, shape (n, 2, 2); each stroke runs on past both by half its width.
      width: m.
    """
    start, end = segments[:, 0], segments[:, 1]
    along = end - start
    along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12) * (width / 2.0)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    ends = [start - along - across, end + along - across, end + along + across, start - along + across]
    corners = np.stack(ends, axis=1).reshape(-1, 2)
    first = 4 * np.arange(len(segments))
    faces = np.hstack([[first, first + 1, first + 2], [first, first + 2, first + 3]])
    return Mesh(np.vstack([corners.T, np.zeros(len(corners))]), faces.astype(np.int32))


def text(words: str, height: float, at: tuple[float, float], align: float = 0.0) -> FloatArray:
    """The strokes of a line of text, as segments for `strokes`, m, shape (n, 2, 2).

    Args:
      words: of the characters in GLYPHS.
      height: of a capital or a digit, m.
      at: where the text's anchor stands, m.
      align: which point of the base line is the anchor: 0 its start, 0.5 its middle, 1 its end.
    """
    placed = [(segment, place) for place, character in enumerate(words) for segment in GLYPHS[character]]
    segments = np.array([segment for segment, _ in placed], dtype=float).reshape(-1, 2, 2)
    length = (len(words) - 1) * ADVANCE + 1.0
    segments[..., 0] += ADVANCE * np.array([[place] for _, place in placed]).reshape(-1, 1) - align * length
    return segments * (height / 2.0) + np.array(at)
