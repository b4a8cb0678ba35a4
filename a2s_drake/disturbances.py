"""Blocks that stand for what the controller does not know of: gusts, measurement noise, delayed commands."""

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from a2s_drake.arrays import FloatArray
from a2s_drake.parameters import Disturbance

# A sample's number is found from its time; this much of a period is allowed for rounding.
_ROUNDING = 1e-6


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


class MeasurementNoise(LeafSystem):
    """White Gaussian noise on the measured state, drawn anew every period.

    ```
                        +------------------+
    vehicle_state    -->| MeasurementNoise |--> measured_state
                        +------------------+
    ```

    - `vehicle_state` (12), `measured_state` (12): [p (m, W), eta (rad), v (m/s, W), omega (rad/s, B)].

    Stateless: the noise is a function of the seed and the number of the period. Drake's own `RandomSource` draws its
    seed from the process it runs in, and Python cannot fix it.
    """

    def __init__(self, disturbance: Disturbance, period: float) -> None:
        LeafSystem.__init__(self)
        self._deviations = np.array(disturbance.noise_deviations)
        self._seed, self._period = disturbance.noise_seed, period
        self._vehicle_state = self.DeclareVectorInputPort("vehicle_state", 12)
        self.DeclareVectorOutputPort(
            "measured_state", 12, self._calc_measured_state, {self._vehicle_state.ticket(), self.time_ticket()}
        )

    def _calc_measured_state(self, context: Context, output: BasicVector) -> None:
        sample = int(context.get_time() / self._period + _ROUNDING)
        noise = np.random.default_rng([self._seed, sample]).standard_normal(12)
        output.SetFromVector(self._vehicle_state.Eval(context) + self._deviations * noise)


class InputDelay(LeafSystem):
    """Commands that reach the rotors some periods late; until the first one does, the rotors turn as at rest.

    ```
                              +------------+
    rotor_speed_command    -->| InputDelay |--> rotor_speed_squared
                              +------------+
    ```

    - `rotor_speed_command` (6), `rotor_speed_squared` (6): Omega^2 of each rotor, Hz^2.

    Sampled with the controller, but for its first sample: what the controller decides at t_k, this block takes in at
    t_k + T_s.
    """

    def __init__(self, delay_periods: int, period: float, at_rest: FloatArray) -> None:
        """A delay of one period or more; `at_rest` (6) is the command until the first one arrives, Hz^2."""
        LeafSystem.__init__(self)
        self._command = self.DeclareVectorInputPort("rotor_speed_command", 6)
        # Oldest first; the oldest is in force.
        self._empty = np.tile(at_rest, delay_periods)
        self._waiting = self.DeclareDiscreteState(self._empty)
        self.DeclareVectorOutputPort(
            "rotor_speed_squared", 6, self._calc_rotor_speed_squared, {self.discrete_state_ticket(self._waiting)}
        )
        # Not by an offset of one period: times n T_s + T_s differ by rounding from the controller's (n + 1) T_s.
        self._started = self.DeclareDiscreteState(1)
        self.DeclareInitializationDiscreteUpdateEvent(self._update_from_rest)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update_waiting)

    def _calc_rotor_speed_squared(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(context.get_discrete_state(self._waiting).value()[:6])

    def _update_from_rest(self, _context: Context, discrete_state: DiscreteValues) -> None:
        discrete_state.set_value(self._waiting, self._empty)
        discrete_state.set_value(self._started, [0.0])

    def _update_waiting(self, context: Context, discrete_state: DiscreteValues) -> None:
        if not context.get_discrete_state(self._started).value()[0]:
            discrete_state.set_value(self._started, [1.0])
            return
        waiting = context.get_discrete_state(self._waiting).value()
        discrete_state.set_value(self._waiting, np.concatenate([waiting[6:], self._command.Eval(context)]))
