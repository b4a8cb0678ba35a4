"""Where the ship truly is: its straight line, and the block that serves it."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.preview import elapsed_share
from a2s_drake.scenario.parts import Mission


def ship_position(time: FloatArray, mission: Mission) -> FloatArray:
    """The ship's reference point at sea level in W, m; it moves at constant speed. Shape (...) to (..., 3)."""
    start, end = (np.array([*point, mission.sea_level]) for point in (mission.ship_start, mission.ship_end))
    return start + elapsed_share(time, mission.duration)[..., np.newaxis] * (end - start)


class ShipTrajectory(LeafSystem):
    """The ship's straight line.

    ```
    +----------------+
    | ShipTrajectory |--> ship_position
    +----------------+
    ```

    - `ship_position` (3): the ship's reference point at mean sea level now, m, W.

    Stateless; depends on time alone. What the UAV believes of the ship's track is told by a `ShipReport`.
    """

    def __init__(self, mission: Mission) -> None:
        LeafSystem.__init__(self)
        self._mission = mission
        self.DeclareVectorOutputPort("ship_position", 3, self._calc_ship_position, {self.time_ticket()})

    def _calc_ship_position(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(ship_position(np.array(context.get_time()), self._mission))
