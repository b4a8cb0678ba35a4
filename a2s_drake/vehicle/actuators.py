"""How late a command reaches the rotors."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from a2s_drake.common.arrays import FloatArray


class InputDelay(LeafSystem):
    """Commands that reach the rotors some periods late; until the first one does, the rotors turn as at rest.

    ```
                              +------------+
    rotor_speed_command    -->| InputDelay |--> rotor_speed_squared
                              +------------+
    ```

    - `rotor_speed_command` (6), `rotor_speed_squared` (6): Omega^2 of each rotor, Hz^2.

    The block is sampled with the controller, except for the first sample. It takes in at t_k + T_s what the controller
    decides at t_k.
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
        # An offset of one period would not do: n T_s + T_s differs by rounding from the controller's (n + 1) T_s.
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
