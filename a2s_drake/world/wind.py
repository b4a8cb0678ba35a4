"""Gusts of wind, which push the vehicle."""

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context, LeafSystem

from a2s_drake.common.arrays import FloatArray
from a2s_drake.scenario.parts import Disturbance


def gust_force(time: float, disturbance: Disturbance) -> FloatArray:
    """Force of the wind on the vehicle at a time (s), N, W, shape (3,): F (1 - cos(2 pi tau/duration))/2 in a gust."""
    gusts, elapsed = divmod(time, disturbance.gust_interval)
    if gusts < 1.0 or elapsed >= disturbance.gust_duration:
        return np.zeros(3)
    swell = 0.5 * (1.0 - np.cos(2.0 * np.pi * elapsed / disturbance.gust_duration))
    return swell * np.asarray(disturbance.gust_force)


class WindGust(LeafSystem):
    """Gusts of wind as an external force on the centre of mass.

    ```
    +----------+
    | WindGust |--> spatial_forces
    +----------+
    ```

    - `spatial_forces`: Drake's list of `ExternallyAppliedSpatialForce`, one entry; see `gust_force`.

    Stateless; depends on time alone.
    """

    def __init__(self, disturbance: Disturbance, body: BodyIndex) -> None:
        LeafSystem.__init__(self)
        self._disturbance, self._body = disturbance, body
        self.DeclareAbstractOutputPort(
            "spatial_forces",
            lambda: Value[list[ExternallyAppliedSpatialForce]](),
            self._calc_spatial_forces,
            {self.time_ticket()},
        )

    def _calc_spatial_forces(self, context: Context, output: AbstractValue) -> None:
        force = ExternallyAppliedSpatialForce()
        force.body_index = self._body
        force.F_Bq_W = SpatialForce(np.zeros(3), gust_force(context.get_time(), self._disturbance))
        output.set_value([force])
