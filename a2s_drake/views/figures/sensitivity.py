"""Sensitivity: how far each reading of the paper moves the headline."""

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure

from a2s_drake.study.paper.results import PaperGains, ReadingRow
from a2s_drake.views.figures.style import column_figure, legend_above, styled

_BASES: dict[str, dict[str, Any]] = {
    "paper": {"marker": "D", "markeredgecolor": "#D55E00", "markerfacecolor": "white", "markersize": 4.5},
    "paper_calibrated": {"marker": "o", "color": "#009E73", "markersize": 3},
}


@styled
def readings_figure(rows: Sequence[ReadingRow], paper: PaperGains) -> Figure:
    """Gain of three axes over both baselines under each reading.

    Args:
      rows: one a reading and base.
      paper: what the paper prints.
    """
    labels: list[tuple[str, str]] = []
    for row in rows:
        if (row.question, row.answer) not in labels:
            labels.append((row.question, row.answer))
    heights, y, last = {}, 0.0, labels[0][0]
    for label in labels:
        y -= 1.0 if label[0] == last else 1.6
        heights[label], last = y, label[0]

    figure = column_figure(3.9)
    panels = figure.subplots(1, 2, sharey=True)
    for axes, key in zip(panels, ("over_level", "over_pitch_only"), strict=True):
        axes.axvline(getattr(paper, key), color="black", linewidth=0.9, linestyle="--", label="printed in the paper")
        for base, style in _BASES.items():
            mine = [row for row in rows if row.base == base]
            values = [getattr(row, key) for row in mine]
            places = [heights[row.question, row.answer] for row in mine]
            axes.plot(values, places, linestyle="none", label=f"from {base}", **style)
        axes.set_title(key.replace("_", " "), pad=3)
        axes.margins(x=0.08)
        axes.grid(axis="y", visible=False)
    panels[0].set_yticks(list(heights.values()), [f"{question}: {answer}" for question, answer in labels], fontsize=6.5)
    for axes in panels:
        axes.tick_params(axis="y", length=0)
    figure.supxlabel("throughput gain of three axes (%)", fontsize=7.5)
    legend_above(figure, panels[0], 2)
    return figure
