"""Courses: the planned motions of UAV and ship over one flight."""

from collections.abc import Mapping
from dataclasses import dataclass

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.motion import Motion
from a2s_drake.common.quoting import quoted
from a2s_drake.guidance.path import uav_path
from a2s_drake.scenario.parts import Mission
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.world.ship import ship_track


@dataclass(frozen=True)
class Courses:
    """Where UAV and ship are meant to go.

    Attributes:
      uav: the motion of the UAV's centre of mass.
      ship: the motion of the ship's reference point at sea level.
      end: the instant, s, from which on both stand still, or which no flight and no preview of the scenario reaches.
      uav_name, ship_name: what to call them in errors; empty for the circle and the line of a mission.
    """

    uav: Motion
    ship: Motion
    end: float
    uav_name: str = ""
    ship_name: str = ""

    @classmethod
    def of(cls, scenario: Scenario, files: Mapping[str, bytes] | None = None) -> "Courses":
        """The courses of a scenario.

        Args:
          files: the content of the scenario's track files by field, as `Flight.files` holds it; a file that is not
            among them is read now.
        Raises:
          ScenarioError: when a file cannot be read or holds no track.
        """
        mission, files = scenario.mission, files or {}
        uav, ship = uav_path(mission, files.get("path_file")), ship_track(mission, files.get("ship_track_file"))
        names = (_name(mission, "path_file"), _name(mission, "ship_track_file"))
        return cls.along(scenario, uav, ship, *names)

    @classmethod
    def along(cls, scenario: Scenario, uav: Motion, ship: Motion, uav_name: str, ship_name: str) -> "Courses":
        """The courses of two motions, which may be others than a scenario's, over its flight."""
        flight = max(scenario.mission.duration, scenario.duration)
        looked_at = flight + scenario.mpc.horizon * scenario.mpc.period
        return cls(uav, ship, min(looked_at, max(uav.end, ship.end)), uav_name, ship_name)

    def positions(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions of UAV and ship, m, W; shape (...) to twice (..., 3)."""
        return self.uav.position(time), self.ship.position(time)


def _name(mission: Mission, field: str) -> str:
    """A track file as errors name it, or nothing where a mission has none."""
    file = getattr(mission, field)
    return "" if file is None else f"mission.{field} = {quoted(file)}"
