"""Figures of Flights. Plain matplotlib Figures, no pyplot state: save them with `figure.savefig`."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from a2s_drake.flight import Flight

# One colour and one dash per law, everywhere: Okabe and Ito's palette (2008), whose three picks here also differ in
# lightness, so that they survive colour blindness and grey print.
LAW_STYLES: dict[str, dict[str, Any]] = {
    "three_axis": {"color": "#0072B2", "linestyle": "-"},
    "pitch_only": {"color": "#E69F00", "linestyle": "--"},
    "level": {"color": "#555555", "linestyle": ":"},
}
LAW_LABELS = {"three_axis": "three axes", "pitch_only": "pitch only", "level": "level"}

_ANGLES = ("roll", "pitch", "yaw")


def channel_gain_figure(flights: Sequence[Flight]) -> Figure:
    """Channel gain |g|^2 in dB over time, one line per flight."""
    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    axes = figure.add_subplot()
    for flight in flights:
        law = flight.scenario.attitude_law.name
        axes.plot(flight.time, 10.0 * np.log10(flight.channel_gain), label=LAW_LABELS[law], **LAW_STYLES[law])
    axes.set_xlabel("time (s)")
    axes.set_ylabel("channel gain $|g|^2$ (dB)")
    axes.margins(x=0.0)
    axes.grid(alpha=0.3)
    figure.legend(loc="outside upper center", ncols=3, frameon=False)
    return figure


def attitude_figure(flight: Flight) -> Figure:
    """Roll, pitch and yaw of a flight against their references, deg, with the controller's attitude box."""
    figure = Figure(figsize=(7.0, 5.0), layout="constrained")
    rows = figure.subplots(3, 1, sharex=True)
    law, limit = flight.scenario.attitude_law.name, flight.scenario.mpc.attitude_limit_deg
    reference, flown = np.rad2deg(flight.attitude_reference), np.rad2deg(flight.attitude)
    for axis, (axes, name) in enumerate(zip(rows, _ANGLES, strict=True)):
        axes.plot(flight.time, reference[:, axis], color="black", linewidth=0.8, label="reference")
        axes.plot(flight.time, flown[:, axis], color=LAW_STYLES[law]["color"], linewidth=1.6, label="flown")
        for bound in (-limit, limit):
            axes.axhline(bound, color="#D55E00", linewidth=0.8, linestyle="--", label="limit" if bound > 0 else None)
        axes.set_ylabel(f"{name} (deg)")
        axes.margins(x=0.0)
        axes.grid(alpha=0.3)
    rows[-1].set_xlabel("time (s)")
    rows[0].legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
    rows[0].set_title(f"{LAW_LABELS[law]}: attitude against reference", pad=24.0, fontsize="medium")
    return figure
