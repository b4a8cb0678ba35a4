"""Where everything is: trajectories in space, and position against time."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from a2s_drake.flight.log import Flight
from a2s_drake.flight.metrics import position_error
from a2s_drake.guidance.laws import label_of, style_of
from a2s_drake.views.figures.style import SHIP_COLOUR, column_figure, legend_above, styled


@styled
def trajectory_figure(flight: Flight) -> Figure:
    """UAV and ship in space, with start and end; the UAV's circle again, enlarged, from above."""
    figure = column_figure(3.6)
    grid = figure.add_gridspec(2, 1, height_ratios=[2.2, 1.4])
    axes = figure.add_subplot(grid[0], projection="3d")
    uav, ship = flight.position, flight.ship_position
    colour = style_of(flight.law)["color"]
    axes.plot(*uav.T, color=colour, label="UAV")
    axes.plot(*ship.T, color=SHIP_COLOUR, label="ship")
    for track, track_colour in ((uav, colour), (ship, SHIP_COLOUR)):
        axes.plot(*track[[0]].T, "o", color=track_colour, markersize=6)
        axes.plot(*track[[-1]].T, "s", color=track_colour, markersize=4, markerfacecolor="white")
    axes.set_xlabel("x (m)", labelpad=0)
    axes.set_ylabel("y (m)", labelpad=-6)
    axes.set_zlabel("z (m)", labelpad=-6)
    axes.tick_params(pad=-3)
    axes.set_box_aspect((2.6, 1.0, 1.0), zoom=0.95)
    axes.set_yticks([0])
    axes.view_init(elev=22, azim=-62)

    above = figure.add_subplot(grid[1])
    reference = flight.position_reference
    above.plot(reference[:, 0], reference[:, 1], color="black", linewidth=0.7, linestyle="--", label="path")
    above.plot(uav[:, 0], uav[:, 1], color=colour, label="UAV")
    above.plot([], [], color=SHIP_COLOUR, label="ship")
    above.plot(uav[0, 0], uav[0, 1], "o", color=colour, markersize=7, label="start")
    above.plot(uav[-1, 0], uav[-1, 1], "s", color=colour, markersize=4, markerfacecolor="white", label="end")
    above.set_aspect("equal", adjustable="datalim")
    above.margins(0.08)
    above.set_xlabel("x (m)")
    above.set_ylabel("y (m)")
    legend_above(figure, above, 5)
    return figure


@styled
def position_figure(flights: Mapping[str, Flight]) -> Figure:
    """Position of the three-axis flight against its reference, and the distance from it under each law."""
    figure = column_figure(3.7)
    rows = figure.subplots(4, 1, sharex=True)
    flight = flights["three_axis"]
    for axis, axes in enumerate(rows[:3]):
        axes.plot(flight.time, flight.position_reference[:, axis], color="black", linewidth=0.7, label="path")
        axes.plot(flight.time, flight.position[:, axis], **style_of("three_axis"))
        axes.set_ylabel(f"{'xyz'[axis]} (m)")
    rows[2].set_ylim(min(-0.1, 1.2 * np.abs(flight.position[:, 2]).max() * -1), 0.1)
    for law, other in flights.items():
        rows[3].plot(other.time, 100.0 * position_error(other), label=label_of(law), **style_of(law))
    rows[3].set_ylabel("error (cm)")
    rows[3].set_ylim(bottom=0.0)
    rows[3].set_xlabel("time (s)")
    rows[3].plot([], [], color="black", linewidth=0.7, label="path")
    figure.align_ylabels()
    legend_above(figure, rows[3], 4)
    return figure
