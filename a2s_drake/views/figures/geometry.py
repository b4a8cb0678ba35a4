"""The geometry: a vertical cross-section with antenna, ship, image and both rays."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from a2s_drake.common.arrays import FloatArray
from a2s_drake.views.figures.style import SEA_COLOUR, SHIP_COLOUR, column_figure, styled

# A drawing, not to scale: heights and distances in units of the page.
_UAV, _PITCH, _ARM = np.array([1.9, 4.6]), np.deg2rad(14.0), np.array([0.8, 0.55])
_SHIP_X, _MAST = 8.6, 2.3
_DIRECT, _REFLECTED = "#009E73", "#D55E00"

_Point = tuple[float, float]


def _measure(axes: Axes, start: _Point, end: _Point, text: str, at: _Point) -> None:
    axes.annotate("", end, start, arrowprops={"arrowstyle": "<->", "linewidth": 0.6, "shrinkA": 0, "shrinkB": 0})
    axes.text(*at, text, ha="center", va="center", bbox={"pad": 0.6, "facecolor": "white", "edgecolor": "none"})


def _draw_uav(axes: Axes, turn: FloatArray) -> None:
    for side in (-1.0, 1.0):
        hub = _UAV + turn @ np.array([0.95 * side, 0.0])
        axes.plot(*np.array([_UAV, hub]).T, color="black", linewidth=2.0, solid_capstyle="round")
        # The rotors lean, as on the tilted hexarotor.
        top, blade = hub + turn @ np.array([0.0, 0.16]), turn @ np.array([0.42, -0.11 * side])
        axes.plot(*np.array([hub, top]).T, color="black", linewidth=0.9)
        axes.plot(*np.array([top - blade, top + blade]).T, color="black", linewidth=0.9)
    axes.plot(*_UAV, "o", color="black", markersize=3)
    axes.text(_UAV[0] - 0.1, _UAV[1] - 0.75, "UAV", ha="right")


@styled
def geometry_figure() -> Figure:
    """The two-ray geometry in the vertical plane of the link, pitch alone shown (section II of the paper)."""
    figure = column_figure(2.7)
    axes = figure.add_subplot()
    axes.set_axis_off()
    axes.set_aspect("equal")

    axes.fill_between([-0.2, 10.2], -2.9, 0.0, color=SEA_COLOUR, alpha=0.25, linewidth=0)
    axes.plot([-0.2, 10.2], [0.0, 0.0], color=SEA_COLOUR, linewidth=1.2)
    axes.text(-0.05, -0.35, "sea", color="#1b6ca8", va="center")

    turn = np.array([[np.cos(_PITCH), np.sin(_PITCH)], [-np.sin(_PITCH), np.cos(_PITCH)]])
    _draw_uav(axes, turn)
    level, antenna = _UAV + _ARM, _UAV + turn @ _ARM
    axes.plot(*np.array([_UAV, antenna]).T, color="black", linewidth=0.7)
    axes.plot(*level, "o", markersize=3.5, markerfacecolor="white", markeredgecolor="0.45", markeredgewidth=0.8)
    axes.text(level[0], level[1] + 0.3, r"antenna at $\mathbf{\eta} = 0$", color="0.4", ha="center", fontsize=6.5)

    ship, image = np.array([_SHIP_X, _MAST]), np.array([_SHIP_X, -_MAST])
    hull = np.array([[7.6, 0.45], [7.85, -0.12], [9.35, -0.12], [9.7, 0.45]])
    axes.fill(*hull.T, color=SHIP_COLOUR)
    axes.plot([_SHIP_X, _SHIP_X], [0.45, _MAST], color="black", linewidth=0.9)
    axes.plot([_SHIP_X, _SHIP_X], [-0.2, -_MAST], color="0.6", linewidth=0.8, linestyle=":")
    bounce = antenna + (image - antenna) * antenna[1] / (antenna[1] - image[1])
    axes.plot(*np.array([antenna, ship]).T, color=_DIRECT)
    axes.plot(*np.array([antenna, bounce, ship]).T, color=_REFLECTED, linestyle="--")
    axes.plot(*np.array([bounce, image]).T, color=_REFLECTED, linestyle=":", linewidth=0.9)
    axes.plot(*antenna, "o", color=_DIRECT, markersize=4.5, zorder=3)
    axes.text(antenna[0] + 0.15, antenna[1] + 0.12, r"$\mathbf{p}_a$", color=_DIRECT)
    axes.plot(*ship, "^", color=SHIP_COLOUR, markersize=5, zorder=3)
    axes.plot(*image, "^", markerfacecolor="white", markeredgecolor=SHIP_COLOUR, markersize=5, zorder=3)
    axes.text(_SHIP_X + 0.2, _MAST + 0.25, r"ship $\mathbf{p}_s$")
    axes.text(_SHIP_X + 0.2, -_MAST - 0.25, "image", va="center")

    axes.text(6.3, 4.05, r"direct, $d_\mathrm{LoS}$", color=_DIRECT, ha="center")
    axes.text(4.2, 1.5, r"reflected, $d_\mathrm{ref}$", color=_REFLECTED, ha="right")
    _measure(axes, (0.25, 0.0), (0.25, antenna[1]), "$H$", (0.25, 2.5))
    axes.plot([0.05, antenna[0]], [antenna[1]] * 2, color="0.75", linewidth=0.5, zorder=0)
    _measure(axes, (10.0, 0.0), (10.0, _MAST), "$h$", (10.0, 1.1))
    _measure(axes, (antenna[0], -2.55), (_SHIP_X, -2.55), "$L$", ((antenna[0] + _SHIP_X) / 2.0, -2.55))
    axes.plot([antenna[0]] * 2, [antenna[1], -2.6], color="0.75", linewidth=0.5, zorder=0)
    axes.set_xlim(-0.3, 10.5)
    axes.set_ylim(-3.0, 5.9)
    return figure
