"""A trajectory served as a block: its present value, and N+1 samples of what comes."""

from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from a2s_drake.common.arrays import FloatArray


def elapsed_share(time: FloatArray, duration: float) -> FloatArray:
    """Elapsed share of the mission, clamped to [0, 1]: before take-off and after the end everything stands still."""
    return np.clip(np.asarray(time, dtype=float) / duration, 0.0, 1.0)


class PreviewSource(LeafSystem):
    """A trajectory served as its present value and as N+1 samples T_s apart, stacked row by row."""

    def __init__(
        self, position_at: Callable[[FloatArray], FloatArray], period: float, horizon: int, value: str, preview: str
    ) -> None:
        LeafSystem.__init__(self)
        self._position_at = position_at
        self._offsets = period * np.arange(horizon + 1)
        time_only = {self.time_ticket()}
        self.DeclareVectorOutputPort(value, 3, self._calc_value, time_only)
        self._preview = self.DeclareVectorOutputPort(preview, 3 * (horizon + 1), self._calc_preview, time_only)

    def _calc_value(self, context: Context, output: BasicVector) -> None:
        # The preview is usually evaluated already; reuse its cache entry.
        output.SetFromVector(self._preview.Eval(context)[:3])

    def _calc_preview(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._position_at(context.get_time() + self._offsets).ravel())
