"""What the vehicle does within its bounds: velocities, angular rates, rotor speeds."""

from matplotlib.figure import Figure

from a2s_drake.common.arrays import FloatArray
from a2s_drake.flight.log import Flight
from a2s_drake.guidance.laws import style_of
from a2s_drake.views.figures.style import AXIS_STYLES, column_figure, draw_bounds, legend_above, styled


def _components(flight: Flight, values: FloatArray, names: tuple[str, ...], bound: float, label: str) -> Figure:
    figure = column_figure(2.1)
    axes = figure.add_subplot()
    for axis, name in enumerate(names):
        axes.plot(flight.time, values[:, axis], label=name, **AXIS_STYLES[axis])
    draw_bounds(axes, -bound, bound)
    axes.set_xlabel("time (s)")
    axes.set_ylabel(label)
    legend_above(figure, axes, 4)
    return figure


@styled
def velocity_figure(flight: Flight) -> Figure:
    """Velocity of the centre of mass in W with its bounds, m/s."""
    names = ("$v_x$", "$v_y$", "$v_z$")
    return _components(flight, flight.velocity, names, flight.scenario.mpc.velocity_limit, "velocity (m/s)")


@styled
def angular_velocity_figure(flight: Flight) -> Figure:
    """Angular velocity in the body frame with its bounds, rad/s."""
    names = (r"$\omega_x$", r"$\omega_y$", r"$\omega_z$")
    limit = flight.scenario.mpc.angular_velocity_limit
    return _components(flight, flight.angular_velocity, names, limit, "angular velocity (rad/s)")


@styled
def rotor_speed_figure(flight: Flight) -> Figure:
    """The six rotor speeds with their bounds, Hz."""
    figure = column_figure(3.4)
    grid = figure.subplots(3, 2, sharex=True, sharey=True)
    airframe, colour = flight.scenario.airframe, style_of(flight.law)["color"]
    for rotor, axes in enumerate(grid.ravel()):
        axes.plot(flight.time, flight.rotor_speed[:, rotor], color=colour, label="rotor speed")
        draw_bounds(axes, airframe.rotor_speed_min, airframe.rotor_speed_max)
        axes.set_title(f"rotor {rotor + 1}, at {60 * rotor} deg", pad=3)
    for axes in grid[-1]:
        axes.set_xlabel("time (s)")
    figure.supylabel("rotor speed (Hz)", fontsize=7.5)
    legend_above(figure, grid[0, 0], 2)
    return figure
