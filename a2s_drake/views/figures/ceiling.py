"""How much of what any attitude could win is won."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from a2s_drake.common.arrays import FloatArray
from a2s_drake.guidance.laws import LAW_LABELS, LAW_STYLES
from a2s_drake.study.paper.attribution import Step
from a2s_drake.study.paper.results import CeilingRow
from a2s_drake.views.figures.style import column_figure, styled


@styled
def ceiling_figure(rows: Mapping[str, Sequence[CeilingRow]]) -> Figure:
    """Gain over `level` of each way to choose the attitude, with its share of the best, one panel a scenario.

    Args:
      rows: by scenario, from the top, of `reproduction.ceiling_rows`.
    """
    shown = {name: [row for row in entries if row.kind != "other"] for name, entries in rows.items()}
    heights = [len(entries) for entries in shown.values()]
    figure = column_figure(0.9 + 0.2 * sum(heights))
    panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    for axes, (name, entries) in zip(panels, shown.items(), strict=True):
        labels = [" ".join(filter(None, (LAW_LABELS.get(row.law, ""), row.name))) for row in entries]
        for place, row in enumerate(entries):
            colour = LAW_STYLES[row.law]["color"] if row.law else "black"
            solid = row.kind == "flown"
            axes.barh(
                -place,
                row.gain_percent,
                height=0.62,
                facecolor=colour if solid else "white",
                edgecolor=colour,
                hatch={"ceiling": "////", "held": "....", "flown": ""}[row.kind],
                linewidth=0.7,
            )
            text = f"{row.gain_percent:.1f} % ({100 * row.share:.0f} %)"
            axes.text(row.gain_percent + 0.7, -place, text, va="center", fontsize=6.5)
        axes.set_yticks(-np.arange(len(entries)), labels, fontsize=6.5)
        axes.tick_params(axis="y", length=0)
        axes.set_axisbelow(True)
        axes.grid(axis="y", visible=False)
        axes.set_title(name, pad=3)
    largest = max(row.gain_percent for entries in shown.values() for row in entries)
    panels[-1].set_xlim(0.0, 1.8 * largest)
    panels[-1].set_xlabel("throughput gain over level (%)")
    return figure


@styled
def attribution_figure(steps: Sequence[Step]) -> Figure:
    """Gain over `level` that is left after each effect, and what the effect costs, one panel a law.

    Args:
      steps: of `attribution.attribution`, from the top.
    """
    by_law = {law: [step for step in steps if step.law == law] for law in dict.fromkeys(s.law for s in steps)}
    heights = [len(entries) for entries in by_law.values()]
    figure = column_figure(0.9 + 0.2 * sum(heights))
    panels = figure.subplots(len(by_law), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    for axes, (law, entries) in zip(panels, by_law.items(), strict=True):
        colour = LAW_STYLES[law]["color"]
        for place, step in enumerate(entries):
            left, lost = step.gain_percent, step.cost
            axes.barh(-place, left, height=0.62, facecolor=colour, edgecolor=colour, linewidth=0.7, alpha=0.75)
            axes.barh(-place, lost, left=left, height=0.62, facecolor="white", edgecolor=colour, hatch="////", lw=0.7)
            # Adding zero takes the sign off a loss that rounds to nothing.
            text = f"{left:.1f} %" if place == 0 else f"{left:.1f} % ({0.0 + round(-lost, 1):+.1f})"
            axes.text(left + max(lost, 0.0) + 0.7, -place, text, va="center", fontsize=6.5)
        labels = [step.effect or step.attitude for step in entries]
        axes.set_yticks(-np.arange(len(entries)), labels, fontsize=6.5)
        axes.tick_params(axis="y", length=0)
        axes.set_axisbelow(True)
        axes.grid(axis="y", visible=False)
        axes.set_title(LAW_LABELS[law], pad=3)
    panels[-1].set_xlim(0.0, 1.6 * max(step.gain_percent for step in steps))
    panels[-1].set_xlabel("throughput gain over level (%)")
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
