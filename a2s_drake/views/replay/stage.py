"""Stage: where the scene's things are put and moved, on a live Meshcat page or in the frames of a recording."""

import logging
from collections.abc import Sequence

import numpy as np
from pydrake.geometry import Meshcat, MeshcatAnimation, MeshcatParams, Rgba
from pydrake.geometry import Shape as DrakeShape
from pydrake.math import RigidTransform

from a2s_drake.common.arrays import FloatArray
from a2s_drake.views.replay.shapes import Mesh

Color = tuple[float, float, float]


def start_meshcat(port: int | None = None) -> Meshcat:
    """A Meshcat server that this machine alone can reach, and that ends with the object; it says nothing.

    Args:
      port: 0 for any that is free, None for the first free one from 7000 to 7999.
    Raises:
      OSError: when there is none, or the environment forbids Meshcat (DRAKE_ALLOW_NETWORK).
    """
    logger = logging.getLogger("drake")
    level = logger.level
    logger.setLevel(logging.WARNING)
    try:
        return Meshcat(MeshcatParams(host="localhost", port=port, show_stats_plot=False))
    except RuntimeError as error:
        raise OSError(f"no Meshcat server can be started: {error}") from error
    finally:
        logger.setLevel(level)


class Stage:
    """Objects are put up once; from then on they are moved, scaled and revealed.

    Meshcat's own recorder asks for times and rounds them down to frames. It loses a frame wherever t times the rate is
    slightly below a whole number. So frames are counted here.

    Args:
      meshcat: where the objects go.
      recording: where the movements go; without one they happen on the page.
      last_frame: the recording's last frame.
    """

    def __init__(self, meshcat: Meshcat, recording: MeshcatAnimation | None = None, last_frame: int = 0) -> None:
        self.meshcat = meshcat
        self.frame = 0
        self._recording = recording
        self._last_frame = last_frame

    def put(
        self, path: str, thing: Mesh | DrakeShape, color: Color, *, glow: float = 0.0, opacity: float = 1.0
    ) -> None:
        """Puts up an object; `glow` is the part of its colour that it shows where no light falls on it."""
        rgba = Rgba(*color, opacity)
        if isinstance(thing, Mesh):
            self.meshcat.SetTriangleMesh(path, thing.vertices, thing.faces, rgba)
        else:
            self.meshcat.SetObject(path, thing, rgba)
        if glow == 0.0:
            return
        for channel, value in zip("rgb", color, strict=True):
            # Light adds up on a linear scale, but the colours of a palette are not linear.
            linear = value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
            self.meshcat.SetProperty(f"{path}/<object>", f"material.emissive.{channel}", glow * linear)

    def place(self, path: str, X: RigidTransform) -> None:
        """Places an object in its parent for good."""
        self.meshcat.SetTransform(path, X)

    def move(self, path: str, X: RigidTransform) -> None:
        """Moves an object in its parent."""
        if self._recording is None:
            self.meshcat.SetTransform(path, X)
        else:
            self._recording.SetTransform(self.frame, path, X)

    def scale(self, path: str, factors: Sequence[float]) -> None:
        """Scales an object along the axes of its own frame; a path that is scaled must not be moved."""
        if self._recording is None:
            self.meshcat.SetProperty(path, "scale", list(factors))
        else:
            self._recording.SetProperty(self.frame, path, "scale", list(factors))

    def reveal(self, path: str) -> None:
        """Shows an object from now on; in a recording it is hidden before."""
        if self._recording is not None and self.frame > 0:
            # The last key makes every track as long as the recording. Otherwise each track would start over by itself.
            for frame, visible in ((0, False), (self.frame, True), (self._last_frame, True)):
                self._recording.SetProperty(frame, path, "visible", visible)


def translation(p: Sequence[float] | FloatArray) -> RigidTransform:
    """The pose of a frame that is shifted by p (3), m, and not turned."""
    return RigidTransform(np.asarray(p, dtype=float))
