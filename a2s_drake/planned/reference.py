"""The block that serves a planned attitude in place of the paper's law."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from a2s_drake.parameters import Mpc
from a2s_drake.planned.spline import AttitudeSpline


class PlannedReference(LeafSystem):
    """An attitude planned before take-off, along the preview.

    ```
                             +------------------+
        position_preview  -->|                  |--> attitude_reference
                             | PlannedReference |
        ship_preview      -->|                  |--> attitude_preview
                             +------------------+
    ```

    - `position_preview` (3(N+1)), `ship_preview` (3(N+1)): as of `AttitudeReference`, in whose place it stands. A plan
      hangs on time alone: they are not read, and may stay unconnected.
    - `attitude_reference` (3): roll, pitch, yaw now, rad.
    - `attitude_preview` (3(N+1)): the same at N+1 instants, T_s apart, the first one now, row by row, rad.

    Stateless.
    """

    def __init__(self, spline: AttitudeSpline, mpc: Mpc) -> None:
        """A block that serves a spline over a controller's horizon."""
        LeafSystem.__init__(self)
        self._spline = spline
        self._ahead = mpc.period * np.arange(mpc.horizon + 1)
        size = 3 * (mpc.horizon + 1)
        self._position_preview = self.DeclareVectorInputPort("position_preview", size)
        self._ship_preview = self.DeclareVectorInputPort("ship_preview", size)
        time = {self.time_ticket()}
        self.DeclareVectorOutputPort("attitude_reference", 3, self._calc_attitude_reference, time)
        self.DeclareVectorOutputPort("attitude_preview", size, self._calc_attitude_preview, time)

    def _calc_attitude_reference(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._spline.eta(np.array(context.get_time())))

    def _calc_attitude_preview(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._spline.eta(context.get_time() + self._ahead).ravel())
