"""Attitude: what the law asks for, what is flown, and the difference."""

import numpy as np
from matplotlib.figure import Figure

from a2s_drake.flight.log import Flight
from a2s_drake.flight.metrics import attitude_error
from a2s_drake.guidance.laws import style_of
from a2s_drake.views.figures.style import AXIS_STYLES, BOUND_STYLE, column_figure, draw_bounds, legend_above, styled

ANGLES = ("roll", "pitch", "yaw")


@styled
def attitude_figure(flight: Flight) -> Figure:
    """Roll, pitch and yaw of a flight against their references, deg, with the controller's attitude box."""
    figure = column_figure(3.6)
    rows = figure.subplots(3, 1, sharex=True)
    colour, limit = style_of(flight.law)["color"], flight.scenario.mpc.attitude_limit_deg
    reference, flown = np.rad2deg(flight.attitude_reference), np.rad2deg(flight.attitude)
    for axis, axes in enumerate(rows):
        axes.plot(flight.time, reference[:, axis], color="black", linewidth=0.7, label="reference")
        axes.plot(flight.time, flown[:, axis], color=colour, linewidth=1.4, label="flown")
        draw_bounds(axes, -limit, limit)
        axes.set_ylabel(f"{ANGLES[axis]} (deg)")
    rows[-1].set_xlabel("time (s)")
    figure.align_ylabels()
    legend_above(figure, rows[0], 3)
    return figure


@styled
def reference_figure(flight: Flight) -> Figure:
    """The Euler angles that a flight's law asked for, deg."""
    figure = column_figure(2.1)
    axes = figure.add_subplot()
    limit = flight.scenario.mpc.attitude_limit_deg
    for axis, name in enumerate(ANGLES):
        axes.plot(flight.time, np.rad2deg(flight.attitude_reference[:, axis]), label=name, **AXIS_STYLES[axis])
    draw_bounds(axes, -limit, limit)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("reference (deg)")
    legend_above(figure, axes, 4)
    return figure


@styled
def attitude_error_figure(flight: Flight) -> Figure:
    """Flown minus asked-for Euler angles, deg."""
    figure = column_figure(2.1)
    axes = figure.add_subplot()
    error = np.rad2deg(attitude_error(flight))
    for axis, name in enumerate(ANGLES):
        axes.plot(flight.time, error[:, axis], label=name, **AXIS_STYLES[axis])
    axes.axhline(0.0, **(BOUND_STYLE | {"color": "0.6"}))
    axes.set_xlabel("time (s)")
    axes.set_ylabel("tracking error (deg)")
    legend_above(figure, axes, 3)
    return figure
