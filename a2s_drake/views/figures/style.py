"""Style: the one look of all figures: column width, one colour and dash per law, units on every axis."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from a2s_drake.common.files import written_whole

# Column width of a two-column paper, in.
COLUMN = 8.5 / 2.54

# Roll, pitch, yaw and x, y, z: none of them in the colour of a law.
AXIS_STYLES: tuple[dict[str, Any], ...] = (
    {"color": "#D55E00", "linestyle": "-"},
    {"color": "#009E73", "linestyle": "--"},
    {"color": "#56B4E9", "linestyle": "-."},
)
BOUND_STYLE: dict[str, Any] = {"color": "black", "linewidth": 0.8, "linestyle": (0, (1, 1.5))}
SHIP_COLOUR = "#CC79A7"
SEA_COLOUR = "#56B4E9"

_RC: Any = {
    "font.size": 7.5,
    "axes.titlesize": 7.5,
    "axes.labelsize": 7.5,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 7.0,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.5,
    "axes.xmargin": 0.0,
    # The same figure gives the same SVG, byte for byte.
    "svg.hashsalt": "a2s_drake",
}

P = ParamSpec("P")


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Draws a figure in the project's style without touching matplotlib's global settings."""

    @wraps(draw)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with mpl.rc_context(_RC):
            return draw(*args, **kwargs)

    return wrapper


def save_figure(figure: Figure, stem: Path) -> None:
    """Writes a figure as PNG (300 dpi) and SVG beside each other, `stem` with either suffix, each of them whole.

    Raises:
      OSError: when the disk refuses; names the file.
    """
    options: dict[str, dict[str, Any]] = {"png": {"dpi": 300}, "svg": {"metadata": {"Date": None}}}
    for kind, settings in options.items():
        with mpl.rc_context(_RC), written_whole(stem.with_suffix(f".{kind}")) as part:
            figure.savefig(part, format=kind, **settings)


def column_figure(height: float) -> Figure:
    """An empty figure of column width and the given height, in."""
    return Figure(figsize=(COLUMN, height), layout="constrained")


def draw_bounds(axes: Axes, *bounds: float, label: str = "bound") -> None:
    """Horizontal lines at bounds, the first of them labelled."""
    for index, bound in enumerate(bounds):
        axes.axhline(bound, label=label if index == 0 else None, **BOUND_STYLE)


def legend_above(figure: Figure, axes: Axes, columns: int) -> None:
    """One legend for the whole figure, above it, with the entries of one of its axes."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=columns, handlelength=1.9, columnspacing=1.2)
