"""The navigation sensor: what the UAV measures of its own state."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from a2s_drake.scenario.parts import Disturbance, Knowledge

# A sample's number is found from its time; this much of a period is allowed for rounding.
_ROUNDING = 1e-6


class NavigationSensor(LeafSystem):
    """The measured state: the true one minus a constant bias, with white Gaussian noise drawn anew every period.

    ```
                        +------------------+
    vehicle_state    -->| NavigationSensor |--> measured_state
                        +------------------+
    ```

    - `vehicle_state` (12), `measured_state` (12): [p (m, W), eta (rad), v (m/s, W), omega (rad/s, B)]. The bias of the
      attitude is subtracted from the Euler angles.

    Stateless: the noise is a function of the seed and the number of the period. Drake's own `RandomSource` draws its
    seed from the process it runs in, and Python cannot fix it.
    """

    def __init__(
        self, period: float, disturbance: Disturbance | None = None, knowledge: Knowledge | None = None
    ) -> None:
        """A sensor with the noise of a disturbance, drawn every period (s), and the biases of what is known."""
        LeafSystem.__init__(self)
        disturbance, knowledge = disturbance or Disturbance(), knowledge or Knowledge()
        self._bias = np.array([*knowledge.pose_bias, *[0.0] * 6])
        self._deviations = np.array(disturbance.noise_deviations)
        self._seed, self._period = disturbance.noise_seed, period
        self._vehicle_state = self.DeclareVectorInputPort("vehicle_state", 12)
        noisy = self._deviations.any()
        prerequisites = {self._vehicle_state.ticket(), *([self.time_ticket()] if noisy else [])}
        calc = self._calc_noisy if noisy else self._calc_biased
        self.DeclareVectorOutputPort("measured_state", 12, calc, prerequisites)

    def _calc_biased(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._vehicle_state.Eval(context) - self._bias)

    def _calc_noisy(self, context: Context, output: BasicVector) -> None:
        sample = int(context.get_time() / self._period + _ROUNDING)
        noise = np.random.default_rng([self._seed, sample]).standard_normal(12)
        output.SetFromVector(self._vehicle_state.Eval(context) - self._bias + self._deviations * noise)
