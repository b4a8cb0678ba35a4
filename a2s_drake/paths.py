"""Where UAV and ship are meant to be: the circle with its time warp, the straight line, and their preview blocks."""

from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from a2s_drake.arrays import FloatArray
from a2s_drake.parameters import Mission, Mpc


def _progress(time: FloatArray, duration: float) -> FloatArray:
    """Elapsed share of the mission, clamped to [0, 1]: before take-off and after the end everything stands still."""
    return np.clip(np.asarray(time, dtype=float) / duration, 0.0, 1.0)


def uav_position(time: FloatArray, mission: Mission) -> FloatArray:
    """Planned position p_d of the UAV's centre of mass in W, m (section V of the paper).

    p_d = (x0 - R + R cos 2 pi s, y0 + R sin 2 pi s, z0) with the warp s = (1 - cos(pi t/T))/2.

    Args:
      time: s, shape (...).
    Returns:
      shape (..., 3).
    """
    angle = np.pi * (1.0 - np.cos(np.pi * _progress(time, mission.duration)))
    circle = np.stack([np.cos(angle) - 1.0, np.sin(angle), np.zeros_like(angle)], axis=-1)
    return np.asarray(mission.start) + mission.radius * circle


def uav_velocity(time: FloatArray, mission: Mission) -> FloatArray:
    """Time derivative of `uav_position`, m/s, W; shape (...) to (..., 3)."""
    progress = _progress(time, mission.duration)
    angle = np.pi * (1.0 - np.cos(np.pi * progress))
    rate = np.pi**2 / mission.duration * np.sin(np.pi * progress)
    tangent = np.stack([-np.sin(angle), np.cos(angle), np.zeros_like(angle)], axis=-1)
    return mission.radius * rate[..., np.newaxis] * tangent


def uav_acceleration(time: FloatArray, mission: Mission) -> FloatArray:
    """Second time derivative of `uav_position`, m/s^2, W; shape (...) to (..., 3).

    At both ends of the mission it jumps: the warp starts and stops at rest, but with an angular acceleration of
    pi^3/T^2. At 0 and at T this is the value on the mission's side.
    """
    inside = (np.asarray(time) >= 0.0) & (np.asarray(time) <= mission.duration)
    progress = _progress(time, mission.duration)
    angle = np.pi * (1.0 - np.cos(np.pi * progress))
    rate = np.pi**2 / mission.duration * np.sin(np.pi * progress)
    rate_slope = np.pi**3 / mission.duration**2 * np.cos(np.pi * progress) * inside
    tangent = np.stack([-np.sin(angle), np.cos(angle), np.zeros_like(angle)], axis=-1)
    outward = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    return mission.radius * (rate_slope[..., np.newaxis] * tangent - (rate**2)[..., np.newaxis] * outward)


def ship_position(time: FloatArray, mission: Mission) -> FloatArray:
    """The ship's reference point at sea level in W, m; it moves at constant speed. Shape (...) to (..., 3)."""
    start, end = (np.array([*point, mission.sea_level]) for point in (mission.ship_start, mission.ship_end))
    return start + _progress(time, mission.duration)[..., np.newaxis] * (end - start)


class _PreviewSource(LeafSystem):
    """A trajectory served as its present value and as N+1 samples T_s apart, stacked row by row."""

    def __init__(self, position_at: Callable[[FloatArray], FloatArray], mpc: Mpc, value: str, preview: str) -> None:
        LeafSystem.__init__(self)
        self._position_at = position_at
        self._offsets = mpc.period * np.arange(mpc.horizon + 1)
        time_only = {self.time_ticket()}
        self.DeclareVectorOutputPort(value, 3, self._calc_value, time_only)
        self._preview = self.DeclareVectorOutputPort(preview, 3 * (mpc.horizon + 1), self._calc_preview, time_only)

    def _calc_value(self, context: Context, output: BasicVector) -> None:
        # Who reads the value has mostly read the preview, which then stands in the cache.
        output.SetFromVector(self._preview.Eval(context)[:3])

    def _calc_preview(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._position_at(context.get_time() + self._offsets).ravel())


class UavPath(_PreviewSource):
    """The UAV's planned circle.

    ```
                 +---------+
                 |         |--> position_reference
                 | UavPath |
                 |         |--> position_preview
                 +---------+
    ```

    - `position_reference` (3): planned position of the centre of mass now, m, W.
    - `position_preview` (3(N+1)): the same at now, now + T_s, ..., now + N T_s, row by row; past T the last value.

    Stateless; depends on time alone.
    """

    def __init__(self, mission: Mission, mpc: Mpc) -> None:
        super().__init__(lambda time: uav_position(time, mission), mpc, "position_reference", "position_preview")


class ShipTrajectory(_PreviewSource):
    """The ship's straight line.

    ```
                 +----------------+
                 |                |--> ship_position
                 | ShipTrajectory |
                 |                |--> ship_preview
                 +----------------+
    ```

    - `ship_position` (3): the ship's reference point at sea level now, m, W.
    - `ship_preview` (3(N+1)): the same at now, now + T_s, ..., now + N T_s, row by row; past T the last value.

    Stateless; depends on time alone.
    """

    def __init__(self, mission: Mission, mpc: Mpc) -> None:
        super().__init__(lambda time: ship_position(time, mission), mpc, "ship_position", "ship_preview")
