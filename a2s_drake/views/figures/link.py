"""The link: channel gain over time, and outage over thresholds."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from a2s_drake.flight.log import Flight
from a2s_drake.flight.metrics import OUTAGE_THRESHOLDS_DB, outage, outage_curve
from a2s_drake.guidance.laws import label_of, style_of
from a2s_drake.views.figures.style import column_figure, legend_above, styled


@styled
def channel_gain_figure(flights: Mapping[str, Flight]) -> Figure:
    """Channel gain |g|^2 in dB over time, one line per law."""
    figure = column_figure(2.1)
    axes = figure.add_subplot()
    for law, flight in flights.items():
        axes.plot(flight.time, 10.0 * np.log10(flight.channel_gain), label=label_of(law), **style_of(law))
    axes.set_xlabel("time (s)")
    axes.set_ylabel("channel gain $|g|^2$ (dB)")
    legend_above(figure, axes, len(flights))
    return figure


@styled
def outage_figure(flights: Mapping[str, Flight]) -> Figure:
    """Share of the mission below an SNR threshold, over thresholds; dots mark the paper's."""
    figure = column_figure(2.1)
    axes = figure.add_subplot()
    thresholds = np.linspace(-8.0, 16.0, 481)
    for law, flight in flights.items():
        axes.plot(thresholds, outage_curve(flight, thresholds), label=label_of(law), **style_of(law))
        marked = outage(flight)
        axes.plot(OUTAGE_THRESHOLDS_DB, list(marked.values()), "o", color=style_of(law)["color"], markersize=3)
    axes.set_xlabel("SNR threshold (dB)")
    axes.set_ylabel("share of time below")
    axes.set_ylim(0.0, 1.0)
    legend_above(figure, axes, len(flights))
    return figure
