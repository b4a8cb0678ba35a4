"""The sensors of the UAV: blocks between the truth and what the UAV knows of it."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from a2s_drake.scenario.parts import Disturbance

# A sample's number is found from its time; this much of a period is allowed for rounding.
_ROUNDING = 1e-6


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
