"""Where the ship truly is: its straight line, and the block that serves it."""

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.preview import PreviewSource, elapsed_share
from a2s_drake.scenario.parts import Mission, Mpc


def ship_position(time: FloatArray, mission: Mission) -> FloatArray:
    """The ship's reference point at sea level in W, m; it moves at constant speed. Shape (...) to (..., 3)."""
    start, end = (np.array([*point, mission.sea_level]) for point in (mission.ship_start, mission.ship_end))
    return start + elapsed_share(time, mission.duration)[..., np.newaxis] * (end - start)


class ShipTrajectory(PreviewSource):
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
        super().__init__(
            lambda time: ship_position(time, mission), mpc.period, mpc.horizon, "ship_position", "ship_preview"
        )
