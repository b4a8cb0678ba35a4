"""The block that serves a planned attitude in place of the paper's law."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from a2s_drake.common.arrays import FloatArray
from a2s_drake.guidance.path import uav_path
from a2s_drake.guidance.plan.spline import AttitudeSpline
from a2s_drake.scenario.checks import ScenarioError
from a2s_drake.scenario.parts import Airframe, Mission, Mpc
from a2s_drake.vehicle.flatness import FlatMap


class PlannedReference(LeafSystem):
    """An attitude planned before take-off, and all that follows from it and the path, along the preview.

    ```
                             +------------------+--> attitude_reference
        position_preview  -->|                  |--> attitude_preview
                             | PlannedReference |--> velocity_preview
        ship_preview      -->|                  |--> angular_velocity_preview
                             +------------------+--> rotor_speed_squared_preview
    ```

    - `position_preview` (3(N+1)), `ship_preview` (3(N+1)): as of `AttitudeReference`, in whose place it stands. A plan
      depends on time alone: they are not read, and may stay unconnected.
    - `attitude_reference` (3): roll, pitch, yaw now, rad.
    - `attitude_preview` (3(N+1)): the same at N+1 instants, T_s apart, the first one now, row by row, rad.
    - `velocity_preview` (3(N+1)): of the centre of mass along the planned path at the same instants, m/s, W.
    - `angular_velocity_preview` (3(N+1)): at the same instants, rad/s, B.
    - `rotor_speed_squared_preview` (6N): what the rotors need in the middle of each period, Hz^2.

    Stateless.
    """

    def __init__(self, spline: AttitudeSpline | None, airframe: Airframe, mission: Mission, mpc: Mpc) -> None:
        """A block that serves a spline, flown by a vehicle along a mission's path, over a controller's horizon.

        Without a spline the block can be wired and drawn. It raises ScenarioError where an output is evaluated.
        """
        LeafSystem.__init__(self)
        self._plan, self._path, self._flat = spline, uav_path(mission), FlatMap.of(airframe)
        self._ahead = mpc.period * np.arange(mpc.horizon + 1)
        self._middles = self._ahead[:-1] + mpc.period / 2.0
        size = 3 * (mpc.horizon + 1)
        self._position_preview = self.DeclareVectorInputPort("position_preview", size)
        self._ship_preview = self.DeclareVectorInputPort("ship_preview", size)
        time = {self.time_ticket()}
        for name, width, calc in (
            ("attitude_reference", 3, self._calc_attitude_reference),
            ("attitude_preview", size, self._calc_attitude_preview),
            ("velocity_preview", size, self._calc_velocity_preview),
            ("angular_velocity_preview", size, self._calc_angular_velocity_preview),
            ("rotor_speed_squared_preview", 6 * mpc.horizon, self._calc_rotor_speed_squared_preview),
        ):
            self.DeclareVectorOutputPort(name, width, calc, time)

    @property
    def _spline(self) -> AttitudeSpline:
        if self._plan is None:
            how = "make it first and hand it over: build_closed_loop(scenario, plan=kept_plan(scenario))"
            raise ScenarioError(f"attitude_law.name = 'planned': this diagram was built without a plan; {how}")
        return self._plan

    def _calc_attitude_reference(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._spline.eta(np.array(context.get_time())))

    def _calc_attitude_preview(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._spline.eta(context.get_time() + self._ahead).ravel())

    def _calc_velocity_preview(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._path.velocity(context.get_time() + self._ahead).ravel())

    def _calc_angular_velocity_preview(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._spline.angular_velocity(context.get_time() + self._ahead).ravel())

    def _calc_rotor_speed_squared_preview(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._inputs(context.get_time() + self._middles).ravel())

    def _inputs(self, time: FloatArray) -> FloatArray:
        """Squared rotor speeds that the plan needs at times (n,), Hz^2, shape (n, 6)."""
        spline = self._spline
        motion = np.hstack([spline.eta(time), spline.rate(time), spline.acceleration(time)])
        return self._flat.needs(motion, self._path.acceleration(time))[1]
