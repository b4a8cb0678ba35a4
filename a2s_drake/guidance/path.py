"""Where the UAV is meant to be: the paper's circle or a path of one's own, and the block that serves it."""

from dataclasses import dataclass

import numpy as np
from pydrake.trajectories import Trajectory

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.motion import Motion, TrajectoryMotion, as_motion, is_moving, through_points
from a2s_drake.common.preview import PreviewSource, elapsed_share
from a2s_drake.scenario.parts import Mission, Mpc
from a2s_drake.scenario.track_file import read_track


@dataclass(frozen=True)
class Circle:
    """Once around a circle from rest to rest (section V of the paper): `radius`, `start` and `duration` of a mission.

    p_d = (x0 - R + R cos 2 pi s, y0 + R sin 2 pi s, z0) with the warp s = (1 - cos(pi t/T))/2.
    """

    mission: Mission

    @property
    def end(self) -> float:
        """T, s."""
        return self.mission.duration

    def position(self, time: FloatArray) -> FloatArray:
        """Planned position p_d of the UAV's centre of mass, m, W; shape (...) to (..., 3)."""
        angle = np.pi * (1.0 - np.cos(np.pi * elapsed_share(time, self.end)))
        circle = np.stack([np.cos(angle) - 1.0, np.sin(angle), np.zeros_like(angle)], axis=-1)
        return np.asarray(self.mission.start) + self.mission.radius * circle

    def velocity(self, time: FloatArray) -> FloatArray:
        """Time derivative of `position`, m/s, W; shape (...) to (..., 3)."""
        progress = elapsed_share(time, self.end)
        angle = np.pi * (1.0 - np.cos(np.pi * progress))
        rate = np.pi**2 / self.end * np.sin(np.pi * progress)
        tangent = np.stack([-np.sin(angle), np.cos(angle), np.zeros_like(angle)], axis=-1)
        return self.mission.radius * rate[..., np.newaxis] * tangent

    def acceleration(self, time: FloatArray) -> FloatArray:
        """Second time derivative of `position`, m/s^2, W; shape (...) to (..., 3).

        At both ends of the mission it jumps: the warp starts and stops at rest, but with an angular acceleration of
        pi^3/T^2. At 0 and at T this is the value on the mission's side.
        """
        progress = elapsed_share(time, self.end)
        angle = np.pi * (1.0 - np.cos(np.pi * progress))
        rate = np.pi**2 / self.end * np.sin(np.pi * progress)
        rate_slope = np.pi**3 / self.end**2 * np.cos(np.pi * progress)[..., np.newaxis] * is_moving(time, 0.0, self.end)
        tangent = np.stack([-np.sin(angle), np.cos(angle), np.zeros_like(angle)], axis=-1)
        outward = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
        return self.mission.radius * (rate_slope * tangent - (rate**2)[..., np.newaxis] * outward)


def uav_path(mission: Mission, content: bytes | None = None) -> Motion:
    """The planned motion of the UAV's centre of mass: the circle, or the path in the mission's file.

    Args:
      content: of that file, where it is known; without it the file is read, once.
    Raises:
      ScenarioError: when the file cannot be read or holds no path.
    """
    if mission.path_file is None:
        return Circle(mission)
    return TrajectoryMotion(through_points(*read_track(mission, "path_file", content)))


class UavPath(PreviewSource):
    """The UAV's planned path: that of a mission, or any other motion.

    ```
                 +---------+
                 |         |--> position_reference
                 | UavPath |
                 |         |--> position_preview
                 +---------+
    ```

    - `position_reference` (3): planned position of the centre of mass now, m, W.
    - `position_preview` (3(N+1)): the same at now, now + T_s, ..., now + N T_s, row by row; past its
      end the last value.

    Stateless; depends on time alone.
    """

    def __init__(self, path: Mission | Motion | Trajectory, mpc: Mpc) -> None:
        """A block that serves a path over a controller's horizon.

        Args:
          path: a mission, whose file is read now where it names one; or a motion; or a Drake trajectory of positions.
        """
        self.motion = uav_path(path) if isinstance(path, Mission) else as_motion(path)
        super().__init__(self.motion.position, mpc.period, mpc.horizon, "position_reference", "position_preview")
