"""Where the UAV is meant to be: the circle with its time warp, and the block that serves it."""

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.preview import PreviewSource, elapsed_share
from a2s_drake.scenario.parts import Mission, Mpc


def uav_position(time: FloatArray, mission: Mission) -> FloatArray:
    """Planned position p_d of the UAV's centre of mass in W, m (section V of the paper).

    p_d = (x0 - R + R cos 2 pi s, y0 + R sin 2 pi s, z0) with the warp s = (1 - cos(pi t/T))/2.

    Args:
      time: s, shape (...).
    Returns:
      shape (..., 3).
    """
    angle = np.pi * (1.0 - np.cos(np.pi * elapsed_share(time, mission.duration)))
    circle = np.stack([np.cos(angle) - 1.0, np.sin(angle), np.zeros_like(angle)], axis=-1)
    return np.asarray(mission.start) + mission.radius * circle


def uav_velocity(time: FloatArray, mission: Mission) -> FloatArray:
    """Time derivative of `uav_position`, m/s, W; shape (...) to (..., 3)."""
    progress = elapsed_share(time, mission.duration)
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
    progress = elapsed_share(time, mission.duration)
    angle = np.pi * (1.0 - np.cos(np.pi * progress))
    rate = np.pi**2 / mission.duration * np.sin(np.pi * progress)
    rate_slope = np.pi**3 / mission.duration**2 * np.cos(np.pi * progress) * inside
    tangent = np.stack([-np.sin(angle), np.cos(angle), np.zeros_like(angle)], axis=-1)
    outward = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    return mission.radius * (rate_slope[..., np.newaxis] * tangent - (rate**2)[..., np.newaxis] * outward)


class UavPath(PreviewSource):
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
        super().__init__(
            lambda time: uav_position(time, mission), mpc.period, mpc.horizon, "position_reference", "position_preview"
        )
