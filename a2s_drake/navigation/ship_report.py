"""What the UAV is told of the ship's track."""

from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from a2s_drake.common.arrays import FloatArray


class ShipReport(LeafSystem):
    """The ship's track as the UAV believes it: the positions to come, as the ship reported them some time ago.

    ```
    +------------+
    | ShipReport |--> ship_preview
    +------------+
    ```

    - `ship_preview` (3(N+1)): the ship's believed reference point at mean sea level at N+1 instants, T_s apart, the
      first one now, row by row, m, W.

    A report of age L tells at t where the ship was meant to be at t - L. Stateless; depends on time alone.
    """

    def __init__(
        self, position_at: Callable[[FloatArray], FloatArray], period: float, horizon: int, latency: float = 0.0
    ) -> None:
        """A report of a track over a horizon of periods.

        Args:
          position_at: the track: times (n,), s, to positions (n, 3), m, W.
          period: T_s, s.
          horizon: N.
          latency: the report's age L, s.
        """
        LeafSystem.__init__(self)
        self._position_at, self._offsets = position_at, period * np.arange(horizon + 1) - latency
        self.DeclareVectorOutputPort("ship_preview", 3 * (horizon + 1), self._calc_ship_preview, {self.time_ticket()})

    def _calc_ship_preview(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._position_at(context.get_time() + self._offsets).ravel())
