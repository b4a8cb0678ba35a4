"""The attitude that makes both rays add up: phase sensitivity, fringe candidates, soft-min, fallbacks.

All candidates of one geometry lie on one line: eta_m = (C_m/||k||^2) k (Theorem 1), so a fringe is the scalar C_m, its
norm |C_m|/||k||, and the soft-min is a weighted mean of scalars. Pure functions first, vectorised over samples and open
to AutoDiffXd, then the block.
"""

from typing import Any

import numpy as np
from pydrake.autodiffutils import ExtractValue
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from a2s_drake.common.arrays import Array
from a2s_drake.common.rotations import skew
from a2s_drake.link.two_ray import path_lengths, phase_difference, ship_antenna_and_image
from a2s_drake.scenario.checks import refuse
from a2s_drake.scenario.parts import AttitudeLaw, Link

# Below this norm of k, rad of phase per rad of attitude, attitude cannot steer the phase and the law stays level. One
# radian of roll would then move the phase by a billionth of a radian; rounding of k itself is five orders smaller.
MIN_PHASE_SENSITIVITY = 1e-9

# What `attitude_reference` knows: the axes that each law turns about, and the fallbacks. These lists are its own, so
# that a name that only the scenario or the registry knows is refused here and never flown as another law.
_AXES = {"three_axis": (1.0, 1.0, 1.0), "pitch_only": (0.0, 1.0, 0.0), "level": (0.0, 0.0, 0.0)}
_FALLBACKS = ("nearest", "zero", "index_zero")


def _values(array: Array) -> Array:
    """Plain numbers of an array that may hold AutoDiffXd: decisions are taken on values, not on derivatives."""
    if array.dtype != object:
        return array
    return ExtractValue(array.ravel()).reshape(array.shape)


def affine_phase(position: Array, ship: Array, link: Link) -> tuple[Array, Array]:
    """The affine phase model dPhi(eta) = dPhi_0 + k^T eta about eta = 0 (Theorem 1 of the paper).

    k = (2 pi/lambda) J_a^T (u_los - u_ref) with J_a = -[r_a]_x. The columns of J_a are + e_i x r_a; the paper prints a
    minus, which contradicts its own J_a.

    Args:
      position: centre of mass, m, W, shape (..., 3).
      ship: the ship's reference point at sea level, m, W, shape (..., 3).
    Returns:
      dPhi_0, rad, shape (...); k, rad/rad over roll, pitch, yaw, shape (..., 3).
    """
    offset = np.asarray(link.antenna_offset)
    antenna = position + offset
    d_los, d_ref = path_lengths(antenna, ship, link)
    direct, image = ship_antenna_and_image(ship, link)
    u_los = (direct - antenna) / d_los[..., np.newaxis]
    u_ref = (image - antenna) / d_ref[..., np.newaxis]
    # J_a^T = -[r_a]_x^T = [r_a]_x.
    sensitivity = (2.0 * np.pi / link.wavelength) * (u_los - u_ref) @ skew(offset).T
    return phase_difference(d_los, d_ref, link), sensitivity


def nearest_fringe(phase: Array) -> Array:
    """Index m of the constructive fringe (2m+1) pi nearest to each phase, a whole number; shape as `phase`."""
    return np.rint((np.asarray(phase, dtype=float) / np.pi - 1.0) / 2.0)


def fringe_offsets(phase: Array, indices: Array) -> Array:
    """C_m = (2m+1) pi - dPhi_0, rad (eq. 12); shapes (...) and (M,) to (..., M)."""
    return (2.0 * np.asarray(indices) + 1.0) * np.pi - phase[..., np.newaxis]


def soft_min(offsets: Array, norm: Array, feasible: Array, temperature: float) -> Array:
    """Soft-min of the feasible fringe offsets: their mean under weights exp(-tau ||eta_m||^2) (Lemma 1, eq. 14).

    The smallest squared norm is subtracted before the exponential, so no temperature underflows the sum.

    Args:
      offsets: C_m, rad, shape (n, M).
      norm: ||k||, shape (n,), not zero.
      feasible: which candidates form M_f, bool, shape (n, M); rows without any give 0.
      temperature: tau, 1/rad^2.
    Returns:
      shape (n,), rad.
    """
    ratios = offsets / norm[:, np.newaxis]
    # Not `ratios**2`: recent NumPy warns of an invalid value when it raises a negative AutoDiffXd to a power.
    squares = ratios * ratios
    found = feasible.any(axis=-1)
    smallest = np.where(feasible, _values(squares), np.inf).min(axis=-1)
    # The mask stands inside the exponential too, so that no excluded candidate, smaller perhaps, can overflow it.
    excess = (squares - np.where(found, smallest, 0.0)[:, np.newaxis]) * feasible
    weights = np.exp(-temperature * excess) * feasible
    return (weights * offsets).sum(axis=-1) / np.where(found, weights.sum(axis=-1), 1.0)


def attitude_reference(position: Array, ship: Array, link: Link, law: AttitudeLaw, attitude_limit: float) -> Array:
    """The reference attitude eta of a law along a geometry (section III of the paper).

    `three_axis` uses k as it is, `pitch_only` k masked to its pitch component, `level` is zero. The soft-min runs over
    the candidates inside the box `law.candidate_limit_deg`. Where there is none, `law.fallback` decides:

    - `nearest`: the candidate of smallest norm, clipped to the attitude box;
    - `zero`: level;
    - `index_zero`: the candidate m = 0 clipped to the attitude box, the paper's literal words.

    Where ||k|| is below `MIN_PHASE_SENSITIVITY` the reference is level.

    Args:
      position: reference path of the centre of mass, m, W, shape (..., 3).
      ship: the ship's reference point at sea level, m, W, shape (..., 3).
      attitude_limit: half-width of the attitude box that the fallbacks clip to, rad.
    Returns:
      roll, pitch, yaw, rad, shape (..., 3).
    Raises:
      ScenarioError: for a law or a fallback that is not among these, such as the law `planned`, which follows from time
        alone; see `a2s_drake.guidance.plan.plan`.
    """
    _check(law)
    shape = np.broadcast_shapes(position.shape, ship.shape)
    if law.name == "level":
        return np.zeros(shape)
    phase, k = affine_phase(position.reshape(-1, 3), ship.reshape(-1, 3), link)
    k = k * np.array(_AXES[law.name])
    steerable = (_values(k) ** 2).sum(axis=-1) >= MIN_PHASE_SENSITIVITY**2
    eta = np.full(k.shape, 0.0, dtype=k.dtype)
    if steerable.any():
        eta[steerable] = _steered(phase[steerable], k[steerable], law, attitude_limit)
    return eta.reshape(shape)


def _check(law: AttitudeLaw) -> None:
    """Raises ScenarioError unless `attitude_reference` knows the law's name and its fallback."""
    if law.name == "planned":
        raise refuse("attitude_law.name", law.name, "a plan depends on time; see a2s_drake.guidance.plan.plan")
    for field, value, known in (("name", law.name, _AXES), ("fallback", law.fallback, _FALLBACKS)):
        if value not in known:
            raise refuse(f"attitude_law.{field}", value, f"must be one of {', '.join(known)}")


def _steered(phase: Array, k: Array, law: AttitudeLaw, attitude_limit: float) -> Array:
    """The reference where k is not zero; phase (n,) and k (n, 3) to (n, 3)."""
    norm_squared = (k * k).sum(axis=-1)
    direction = k / norm_squared[:, np.newaxis]
    offsets = fringe_offsets(phase, _reachable_indices(phase, direction, law))
    largest_angle = np.abs(_values(offsets)) * np.abs(_values(direction)).max(axis=-1)[:, np.newaxis]
    feasible = largest_angle <= law.candidate_limit
    eta = direction * soft_min(offsets, np.sqrt(norm_squared), feasible, law.temperature)[:, np.newaxis]

    empty = ~feasible.any(axis=-1)
    if law.fallback == "zero" or not empty.any():
        return eta
    if law.fallback == "nearest":
        nearest = np.clip(nearest_fringe(_values(phase)), law.index_min, law.index_max)
        stand_in = ((2.0 * nearest + 1.0) * np.pi - phase)[:, np.newaxis]
    else:
        stand_in = fringe_offsets(phase, np.array([0]))
    clipped = np.clip(direction * stand_in, -attitude_limit, attitude_limit)
    return np.where(empty[:, np.newaxis], clipped, eta)


def _reachable_indices(phase: Array, direction: Array, law: AttitudeLaw) -> Array:
    """The indices of the law's window that lie in the candidates' box for any of the samples, and then some."""
    reach = law.candidate_limit / np.abs(_values(direction)).max(axis=-1)
    ends = np.array([(_values(phase) - reach).min(), (_values(phase) + reach).max()])
    if not np.isfinite(ends).all():
        return np.arange(law.index_min, law.index_max + 1)
    first, last = nearest_fringe(ends)
    # Rounding must lose none at the edge of the box, and where there is none an empty column does no harm.
    first, last = np.clip([first - 1, last + 1], law.index_min, law.index_max)
    return np.arange(first, last + 1)


@TemplateSystem.define("AttitudeReference_")
def AttitudeReference_(T: Any) -> Any:  # noqa: N802 - Drake's way to name a template over scalar types
    """The block `AttitudeReference` for the scalar type T."""

    class AttitudeReference(LeafSystem_[T]):
        """The attitude law along the previewed geometry.

        ```
                                 +-------------------+
            position_preview  -->|                   |--> attitude_reference
                                 | AttitudeReference |
            ship_preview      -->|                   |--> attitude_preview
                                 +-------------------+
        ```

        - `position_preview` (3(N+1)): reference position of the centre of mass, m, W, row by row.
        - `ship_preview` (3(N+1)): the ship's reference point at sea level at the same instants, m, W.
        - `attitude_reference` (3): roll, pitch, yaw for the first instant, rad.
        - `attitude_preview` (3(N+1)): the same for all instants, rad, row by row.

        Stateless; on the mission's path it equals the paper's offline reference. Converts to AutoDiffXd.
        """

        def _construct(
            self, link: Link, law: AttitudeLaw, attitude_limit: float, horizon: int, converter: Any = None
        ) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            _check(law)
            self._link, self._law, self._attitude_limit, self._horizon = link, law, attitude_limit, horizon
            size = 3 * (horizon + 1)
            self._position_preview = self.DeclareVectorInputPort("position_preview", size)
            self._ship_preview = self.DeclareVectorInputPort("ship_preview", size)
            inputs = {self._position_preview.ticket(), self._ship_preview.ticket()}
            self.DeclareVectorOutputPort("attitude_reference", 3, self._calc_attitude_reference, inputs)
            self._attitude_preview = self.DeclareVectorOutputPort(
                "attitude_preview", size, self._calc_attitude_preview, inputs
            )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            self._construct(other._link, other._law, other._attitude_limit, other._horizon, converter=converter)

        def _calc_attitude_reference(self, context: Any, output: Any) -> None:
            # The preview is usually evaluated already; reuse its cache entry.
            output.SetFromVector(self._attitude_preview.Eval(context)[:3])

        def _calc_attitude_preview(self, context: Any, output: Any) -> None:
            position = self._position_preview.Eval(context).reshape(-1, 3)
            ship = self._ship_preview.Eval(context).reshape(-1, 3)
            eta = attitude_reference(position, ship, self._link, self._law, self._attitude_limit)
            output.SetFromVector(eta.ravel())

    return AttitudeReference


AttitudeReference = AttitudeReference_[None]
