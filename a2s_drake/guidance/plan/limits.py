"""What a plan may ask of the vehicle: the scenario's limits, less a margin that is left to the controller."""

from dataclasses import dataclass

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.scenario.checks import ScenarioError
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.vehicle.airframe import hover_input
from a2s_drake.vehicle.flatness import FlatMap

# Rows of `use`: three angles, three body rates, six rotors.
NUM_USES = 12
_ANGLES, _RATES, _ROTORS = slice(0, 3), slice(3, 6), slice(6, 12)


@dataclass(frozen=True)
class Limits:
    """Largest Euler angle (rad), largest body angular velocity (rad/s), and range of squared rotor speeds (Hz^2)."""

    angle: float
    rate: float
    input_low: float
    input_high: float

    @classmethod
    def of(cls, scenario: Scenario) -> "Limits":
        """The limits of a scenario with the margins of its planning.

        Raises:
          ScenarioError: when the vehicle cannot even hover level within them.
        """
        planning = scenario.planning
        low = scenario.airframe.rotor_speed_min + planning.rotor_speed_min_margin
        high = scenario.airframe.rotor_speed_max - planning.rotor_speed_max_margin
        hover = np.sqrt(hover_input(scenario.airframe))
        if not (low < hover.min() and hover.max() < high):
            raise ScenarioError(
                f"planning.rotor_speed_min_margin = {planning.rotor_speed_min_margin!r} and rotor_speed_max_margin = "
                f"{planning.rotor_speed_max_margin!r}: leave {low:.4g}..{high:.4g} Hz, which must hold the hover speed "
                f"of {hover.max():.4g} Hz"
            )
        angle = (1.0 - planning.attitude_margin) * scenario.mpc.attitude_limit
        rate = (1.0 - planning.angular_velocity_margin) * scenario.mpc.angular_velocity_limit
        return cls(angle, rate, low**2, high**2)

    def tightened(self, share: float) -> "Limits":
        """These limits drawn in by a share of each, and of the rotors' range on both sides."""
        reserve = share * (self.input_high - self.input_low)
        kept = 1.0 - share
        return Limits(kept * self.angle, kept * self.rate, self.input_low + reserve, self.input_high - reserve)

    def use(self, flat: FlatMap, motion: FloatArray, acceleration: FloatArray) -> FloatArray:
        """How much of each limit is used, from -1 to 1 where it is kept, shape (..., 12).

        Args:
          motion: eta, its rate and its acceleration, SI units, shape (..., 9).
          acceleration: of the centre of mass, m/s^2, W, shape (..., 3).
        """
        omega, u = flat.needs(motion, acceleration)
        middle, half = (self.input_high + self.input_low) / 2.0, (self.input_high - self.input_low) / 2.0
        return np.concatenate([motion[..., :3] / self.angle, omega / self.rate, (u - middle) / half], axis=-1)

    def use_slopes(self, flat: FlatMap, motion: FloatArray, acceleration: FloatArray) -> FloatArray:
        """Derivative of `use` by the motion, shape (..., 12, 9)."""
        omega_by, u_by = flat.slopes(motion, acceleration)
        slopes = np.zeros((*motion.shape[:-1], NUM_USES, 9))
        slopes[..., _ANGLES, :3] = np.eye(3) / self.angle
        slopes[..., _RATES, :] = omega_by / self.rate
        slopes[..., _ROTORS, :] = 2.0 * u_by / (self.input_high - self.input_low)
        return slopes
