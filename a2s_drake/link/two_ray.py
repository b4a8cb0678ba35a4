"""The air-to-sea two-ray channel: a direct ray, a ray reflected by the sea, and the antenna that attitude moves.

Pure functions, vectorised over leading axes and open to AutoDiffXd, then the block that serves them. Complex numbers
do not pass through AutoDiffXd, so the gain is computed from real and imaginary parts kept apart.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from a2s_drake.common.arrays import Array, FloatArray
from a2s_drake.common.rotations import rotation_matrix
from a2s_drake.common.signals import NUM_STATES, State
from a2s_drake.scenario.parts import Link


def antenna_position(position: Array, eta: Array, link: Link) -> Array:
    """Position of the UAV antenna's phase centre, p_a = p + R(eta) r_a, m, W (eq. 2 of the paper).

    Args:
      position: centre of mass, m, W, shape (..., 3).
      eta: roll, pitch, yaw, rad, shape (..., 3).
    """
    return position + rotation_matrix(eta) @ np.asarray(link.antenna_offset)


def mirror_image(ship_antenna: Array, sea_level: Array | float) -> Array:
    """The image of the ship's antenna in the plane of the mean sea, m, W, shape (..., 3): z becomes 2 z_sea - z.

    Heave moves the antenna, not the plane.

    Args:
      ship_antenna: m, W, shape (..., 3).
      sea_level: z_sea, m, W, one number or shape (...).
    """
    x, y, z = ship_antenna[..., 0], ship_antenna[..., 1], ship_antenna[..., 2]
    return np.stack([x, y, 2.0 * sea_level - z], axis=-1)


def ray_lengths(antenna: Array, ship_antenna: Array, sea_level: Array | float) -> tuple[Array, Array]:
    """Lengths d_los and d_ref of the direct and the reflected ray, m, each shape (...) (eq. 3 of the paper).

    Args:
      antenna: the UAV antenna's phase centre, m, W, shape (..., 3).
      ship_antenna: where the ship's antenna is, m, W, shape (..., 3).
      sea_level: z of the mean sea, m, W, one number or shape (...).
    """
    direct, image = ship_antenna - antenna, mirror_image(ship_antenna, sea_level) - antenna
    return np.sqrt((direct * direct).sum(axis=-1)), np.sqrt((image * image).sum(axis=-1))


def ship_antenna_and_image(ship: Array, link: Link) -> tuple[Array, Array]:
    """The ship's antenna on an upright mast of the believed height, and its image, m, W, each shape (..., 3).

    The paper writes them as (x, y, h) and (x, y, -h), which holds only where z = 0 is the sea. Its own world frame has
    the sea at z = -20 m, so both are measured here from the ship's reference point at sea level.

    Args:
      ship: the ship's reference point at sea level, m, W, shape (..., 3).
    """
    up = np.array([0.0, 0.0, link.ship_antenna_height])
    return ship + up, ship - up


def path_lengths(antenna: Array, ship: Array, link: Link) -> tuple[Array, Array]:
    """As `ray_lengths`, from the ship's reference point at sea level, m, W, shape (..., 3), and the believed mast."""
    return ray_lengths(antenna, ship_antenna_and_image(ship, link)[0], ship[..., 2])


def specular_point(antenna: Array, ship_antenna: Array, sea_level: float) -> Array:
    """Where the reflected ray meets the sea, m, W, shape (..., 3): on the straight line to the image, at sea level.

    Args:
      antenna: the UAV antenna's phase centre, above the sea, m, W, shape (..., 3).
      ship_antenna: where the ship's antenna is, above the sea, m, W, shape (..., 3).
      sea_level: z of the mean sea, m, W.
    """
    near, far = antenna[..., 2:] - sea_level, ship_antenna[..., 2:] - sea_level
    return antenna + near / (near + far) * (mirror_image(ship_antenna, sea_level) - antenna)


def phase_difference(d_los: Array, d_ref: Array, link: Link) -> Array:
    """Phase lag dPhi of the reflected behind the direct ray by path length alone, rad, unwrapped (eq. 4)."""
    return (2.0 * np.pi / link.wavelength) * (d_ref - d_los)


def unit_gain(link: Link) -> float:
    """(lambda/4 pi)^2, m^2: the gain of one ray alone is this over its squared length."""
    return (link.wavelength / (4.0 * np.pi)) ** 2


def channel_gain(d_los: Array, d_ref: Array, link: Link) -> Array:
    """|g|^2 of g = (lambda/4 pi)(1/d_los + (gamma/d_ref) exp(-j(dPhi + pi))), dimensionless (eq. 5)."""
    phase = phase_difference(d_los, d_ref, link) + np.pi
    reflected = link.reflection_magnitude / d_ref
    real = 1.0 / d_los + reflected * np.cos(phase)
    imag = -reflected * np.sin(phase)
    return unit_gain(link) * (real * real + imag * imag)


@dataclass(frozen=True)
class GainModel:
    """q = |g|^2 / `unit_gain`, 1/m^2, and its derivatives by the path lengths, per m of each, all of shape (...)."""

    q: FloatArray
    by_los: FloatArray
    by_ref: FloatArray
    by_los_los: FloatArray
    by_los_ref: FloatArray
    by_ref_ref: FloatArray


def gain_model(d_los: FloatArray, d_ref: FloatArray, link: Link) -> GainModel:
    """`channel_gain` over `unit_gain` with its first and second derivatives in closed form.

    The derivatives are those of the square multiplied out,
    q = 1/d_los^2 + gamma^2/d_ref^2 - 2 gamma cos(dPhi)/(d_los d_ref).

    So the gain is written down twice. The two agree but for rounding, and neither is computed from the other: the
    rounding of either would change, and a plan would move by about 1e-11. `tests/link/test_gain_model.py` holds values
    and slopes of both equal.
    """
    gamma, wave = link.reflection_magnitude, 2.0 * np.pi / link.wavelength
    phase = phase_difference(d_los, d_ref, link)
    cross = 2.0 * gamma / (d_los * d_ref)
    even, odd = cross * np.cos(phase), cross * wave * np.sin(phase)
    return GainModel(
        q=1.0 / d_los**2 + (gamma / d_ref) ** 2 - even,
        by_los=-2.0 / d_los**3 + even / d_los - odd,
        by_ref=-2.0 * gamma**2 / d_ref**3 + even / d_ref + odd,
        by_los_los=6.0 / d_los**4 - 2.0 * even / d_los**2 + 2.0 * odd / d_los + wave**2 * even,
        by_los_ref=-even / (d_los * d_ref) - odd / d_los + odd / d_ref - wave**2 * even,
        by_ref_ref=6.0 * gamma**2 / d_ref**4 - 2.0 * even / d_ref**2 - 2.0 * odd / d_ref + wave**2 * even,
    )


def snr(gain: Array, link: Link) -> Array:
    """Signal-to-noise ratio P_t |g|^2 / sigma^2, linear."""
    return link.transmit_to_noise * gain


def snr_db(gain: Array, link: Link) -> Array:
    """Signal-to-noise ratio, dB."""
    return (10.0 / np.log(10.0)) * np.log(snr(gain, link))


def spectral_efficiency(gain: Array, link: Link) -> Array:
    """Shannon's log2(1 + SNR), bit/s/Hz."""
    return np.log(1.0 + snr(gain, link)) / np.log(2.0)


@TemplateSystem.define("TwoRayChannel_")
def TwoRayChannel_(T: Any) -> Any:  # noqa: N802 - Drake's way to name a template over scalar types
    """The block `TwoRayChannel` for the scalar type T."""

    class TwoRayChannel(LeafSystem_[T]):
        """The two-ray channel between the UAV's antenna and the ship's: the truth, whatever the UAV believes.

        ```
                                      +---------------+--> channel_gain
            vehicle_state          -->|               |--> snr_db
                                      | TwoRayChannel |--> spectral_efficiency
            ship_antenna_position  -->|               |--> phase_difference
                                      +---------------+--> reflection
        ```

        - `vehicle_state` (12): [p (m, W), eta (rad), v (m/s, W), omega (rad/s, B)]; only p and eta matter.
        - `ship_antenna_position` (3): where the ship's antenna is, m, W.
        - `channel_gain` (1): |g|^2, dimensionless.
        - `snr_db` (1): P_t |g|^2 / sigma^2, dB.
        - `spectral_efficiency` (1): log2(1 + SNR), bit/s/Hz.
        - `phase_difference` (1): dPhi, rad, unwrapped; geometry alone.
        - `reflection` (2): magnitude, and phase in (-pi, pi], rad, of the sea's reflection coefficient Gamma.

        Stateless. Converts to AutoDiffXd. `TwoRayChannel(link, sea_level)` takes the link as it truly is, of which
        `ship_antenna_height` is not read, and z of the mean sea, m, W.
        """

        def _construct(self, link: Link, sea_level: float = -20.0, converter: Any = None) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self._link, self._sea_level = link, sea_level
            self._vehicle_state = self.DeclareVectorInputPort("vehicle_state", NUM_STATES)
            self._ship_antenna_position = self.DeclareVectorInputPort("ship_antenna_position", 3)
            inputs = {self._vehicle_state.ticket(), self._ship_antenna_position.ticket()}
            self._channel_gain = self.DeclareVectorOutputPort("channel_gain", 1, self._calc_channel_gain, inputs)
            self.DeclareVectorOutputPort("snr_db", 1, self._calc_snr_db, inputs)
            self.DeclareVectorOutputPort("spectral_efficiency", 1, self._calc_spectral_efficiency, inputs)
            self.DeclareVectorOutputPort("phase_difference", 1, self._calc_phase_difference, inputs)
            self.DeclareVectorOutputPort("reflection", 2, self._calc_reflection, inputs)

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            self._construct(other._link, other._sea_level, converter=converter)

        def _ray_lengths(self, context: Any) -> tuple[Array, Array]:
            state = State(self._vehicle_state.Eval(context))
            antenna = antenna_position(state.position, state.attitude, self._link)
            return ray_lengths(antenna, self._ship_antenna_position.Eval(context), self._sea_level)

        def _calc_channel_gain(self, context: Any, output: Any) -> None:
            output[0] = channel_gain(*self._ray_lengths(context), self._link)

        def _calc_snr_db(self, context: Any, output: Any) -> None:
            output[0] = snr_db(self._channel_gain.Eval(context)[0], self._link)

        def _calc_spectral_efficiency(self, context: Any, output: Any) -> None:
            output[0] = spectral_efficiency(self._channel_gain.Eval(context)[0], self._link)

        def _calc_phase_difference(self, context: Any, output: Any) -> None:
            output[0] = phase_difference(*self._ray_lengths(context), self._link)

        def _calc_reflection(self, _context: Any, output: Any) -> None:
            output.SetFromVector(np.array([self._link.reflection_magnitude, np.pi]))

    return TwoRayChannel


TwoRayChannel = TwoRayChannel_[None]
