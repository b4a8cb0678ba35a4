"""How much of what any attitude could win is won."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from a2s_drake.arrays import FloatArray
from a2s_drake.figures.style import LAW_STYLES, column_figure, styled

_KINDS = {
    "ceiling": ("black", "////"),
    "ideal": ("#56B4E9", ""),
    "flown": (LAW_STYLES["three_axis"]["color"], ""),
}


@styled
def ceiling_figure(rows: Sequence[tuple[str, str, float]], ceiling: float) -> Figure:
    """Gain over `level` of each way to choose the attitude, as bars.

    Args:
      rows: name, kind (`ceiling`, `ideal` or `flown`) and gain, %, from the top.
      ceiling: the gain of which the labels state each one's share in brackets, %.
    """
    figure = column_figure(0.55 + 0.2 * len(rows))
    axes = figure.add_subplot()
    for place, (_, kind, gain) in enumerate(rows):
        colour, hatch = _KINDS[kind]
        fill = "none" if hatch else colour
        axes.barh(-place, gain, height=0.62, facecolor=fill, edgecolor=colour, hatch=hatch, linewidth=0.7)
        axes.text(gain + 0.7, -place, f"{gain:.1f} % ({100 * gain / ceiling:.0f} %)", va="center", fontsize=6.5)
    axes.set_yticks(-np.arange(len(rows)), [name for name, _, _ in rows], fontsize=6.5)
    axes.tick_params(axis="y", length=0)
    axes.set_xlim(0.0, 1.75 * max(gain for _, _, gain in rows))
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("throughput gain over level (%)")
    return figure


@styled
def affine_error_figure(time: FloatArray, error: FloatArray) -> Figure:
    """Largest and typical error of the affine phase on the boundary of the attitude box, over the mission.

    Args:
      time: s, shape (n,).
      error: exact minus affine phase, rad, shape (n, points on the boundary).
    """
    figure = column_figure(1.9)
    axes = figure.add_subplot()
    axes.fill_between(time, 0.0, np.abs(error).max(axis=1), color="#56B4E9", alpha=0.5, linewidth=0, label="largest")
    axes.plot(time, np.sqrt((error**2).mean(axis=1)), color="#0072B2", label="root mean square")
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("phase error (rad)")
    axes.legend(loc="lower right", ncols=2)
    return figure
