"""Where the ship truly is: its straight line or a track of one's own, and the block that serves it."""

from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem
from pydrake.trajectories import Trajectory

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.motion import Motion, TrajectoryMotion, as_motion, is_moving, through_points
from a2s_drake.common.preview import elapsed_share
from a2s_drake.scenario.checks import refuse
from a2s_drake.scenario.parts import Mission
from a2s_drake.scenario.track_file import read_track


@dataclass(frozen=True)
class Line:
    """Along a straight line at constant speed: `ship_start`, `ship_end` and `duration` of a mission."""

    mission: Mission

    @property
    def end(self) -> float:
        """T, s."""
        return self.mission.duration

    def position(self, time: FloatArray) -> FloatArray:
        """The ship's reference point at sea level, m, W; shape (...) to (..., 3)."""
        start, end = self._ends()
        return start + elapsed_share(time, self.end)[..., np.newaxis] * (end - start)

    def velocity(self, time: FloatArray) -> FloatArray:
        """Time derivative of `position`, m/s, W; shape (...) to (..., 3)."""
        start, end = self._ends()
        return is_moving(time, 0.0, self.end) * (end - start) / self.end

    def acceleration(self, time: FloatArray) -> FloatArray:
        """Zero, m/s^2, W; shape (...) to (..., 3)."""
        return np.zeros((*np.shape(time), 3))

    def _ends(self) -> tuple[FloatArray, FloatArray]:
        mission = self.mission
        start, end = (np.array([*point, mission.sea_level]) for point in (mission.ship_start, mission.ship_end))
        return start, end


def ship_track(mission: Mission, content: bytes | None = None) -> Motion:
    """The motion of the ship's reference point, which stays at sea level: the line, or the mission's file.

    Args:
      content: of that file, where it is known; without it the file is read, once.
    Raises:
      ScenarioError: when the file cannot be read or holds no track, or its column z leaves the sea level.
    """
    if mission.ship_track_file is None:
        return Line(mission)
    time, points = read_track(mission, "ship_track_file", content)
    sea = np.full(len(time), mission.sea_level)
    if points.shape[1] == 3 and (points[:, 2] != sea).any():
        row = int(np.argmax(points[:, 2] != sea))
        words = f"z = {float(points[row, 2])!r} at t = {float(time[row])!r} s: z is the ship's reference point, which"
        allowed = f"{words} stays at mission.sea_level = {mission.sea_level!r}; the column may be left out"
        raise refuse("mission.ship_track_file", mission.ship_track_file, allowed)
    return TrajectoryMotion(through_points(time, np.column_stack([points[:, :2], sea])))


class ShipTrajectory(LeafSystem):
    """The ship's track: that of a mission, or any other motion.

    ```
    +----------------+
    | ShipTrajectory |--> ship_position
    +----------------+
    ```

    - `ship_position` (3): the ship's reference point at mean sea level now, m, W.

    Stateless; depends on time alone. What the UAV believes of the ship's track is told by a `ShipReport`.
    """

    def __init__(self, track: Mission | Motion | Trajectory) -> None:
        """A block that serves a track.

        Args:
          track: a mission, whose file is read now where it names one; or a motion; or a Drake trajectory of positions.
        """
        LeafSystem.__init__(self)
        self.motion = ship_track(track) if isinstance(track, Mission) else as_motion(track)
        self.DeclareVectorOutputPort("ship_position", 3, self._calc_ship_position, {self.time_ticket()})

    def _calc_ship_position(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self.motion.position(np.array(context.get_time())))
