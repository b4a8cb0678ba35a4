"""The pictures of the examples: drawing apart, so that the examples can keep to the library."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from a2s_drake import Flight, Scenario
from a2s_drake.common.arrays import BoolArray, FloatArray
from a2s_drake.common.signals import State
from a2s_drake.control.horizon import Plan, Reference
from a2s_drake.flight.metrics import position_error
from a2s_drake.guidance.laws import LAW_STYLES
from a2s_drake.views.figures.style import AXIS_STYLES, BOUND_STYLE, COLUMN, draw_bounds, legend_above, styled

# Okabe and Ito's palette, for what is neither a law nor an axis.
_PALETTE = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9")
_EXACT, _AFFINE, _ANSWER = "#0072B2", "#D55E00", "#F0E442"


def _square(half_width: float) -> FloatArray:
    return half_width * np.array([[-1.0, 1.0, 1.0, -1.0, -1.0], [-1.0, -1.0, 1.0, 1.0, -1.0]])


@styled
def channel_map_figure(
    angles: FloatArray,
    gain: FloatArray,
    phase: FloatArray,
    fringes: FloatArray,
    lines: FloatArray,
    candidates: FloatArray,
    answer: FloatArray,
    box: float,
) -> Figure:
    """The channel gain over roll and pitch with what the law knows of it.

    Args:
      angles: roll and pitch alike, deg, shape (n,).
      gain, phase: |g|^2 and phase difference (rad) over pitch by roll, shape (n, n).
      fringes: phases at which both rays add up, rad, increasing, shape (M,).
      lines: where the roll and pitch axes meet each affine fringe, deg, shape (M, 2).
      candidates, answer: the law's, roll, pitch, yaw, deg, shapes (M, 3) and (3,).
      box: half-width of the candidates' box, deg.
    """
    figure = Figure(figsize=(1.3 * COLUMN, 1.2 * COLUMN), layout="constrained")
    axes = figure.add_subplot(aspect="equal", xlabel="roll (deg)", ylabel="pitch (deg)")
    image = axes.pcolormesh(angles, angles, 10.0 * np.log10(gain), cmap="gray", vmin=-95.0, rasterized=True)
    figure.colorbar(image, label=r"channel gain $|g|^2$ at yaw 0 (dB)", extend="min", shrink=0.85)
    axes.contour(angles, angles, phase, fringes, colors=_EXACT, linewidths=1.4)
    axes.plot([], [], color=_EXACT, label="fringe of the channel")
    for roll, pitch in lines:
        axes.axline((roll, 0.0), (0.0, pitch), color=_AFFINE, linestyle="--")
    axes.plot([], [], color=_AFFINE, linestyle="--", label=r"affine fringe $k^T\eta = C_m$")
    axes.plot(*candidates[:, :2].T, "o", color=_AFFINE, markeredgecolor="white", label=r"candidate $\eta_m$")
    axes.plot(*answer[:2], "*", color=_ANSWER, markersize=11, markeredgecolor="black", label="the law's answer")
    axes.plot(*_square(box), color="#009E73", label=f"candidates' box, ±{box:g} deg")
    axes.set(xlim=angles[[0, -1]], ylim=angles[[0, -1]])
    legend_above(figure, axes, 2)
    return figure


@styled
def plan_figure(scenario: Scenario, plan: Plan, reference: Reference, terms: Mapping[str, FloatArray]) -> Figure:
    """One plan of the MPC over its horizon, dots where a rotor is on a bound; `terms` as of `cost_terms`."""
    time = scenario.mpc.period * np.arange(len(plan.state))
    position, attitude, velocity, rate = State(plan.state).parts
    figure = Figure(figsize=(2.1 * COLUMN, 1.75 * COLUMN), layout="constrained")
    grid = figure.subplots(3, 2, sharex=True)
    rows: tuple[tuple[Axes, FloatArray, str, str], ...] = (
        (grid[0, 0], 100.0 * (position - reference.position), "position error (cm)", "x y z"),
        (grid[0, 1], velocity, "velocity (m/s)", "$v_x$ $v_y$ $v_z$"),
        (grid[1, 0], np.rad2deg(attitude), "attitude (deg)", "roll pitch yaw"),
        (grid[1, 1], rate, "angular velocity (rad/s)", r"$\omega_x$ $\omega_y$ $\omega_z$"),
    )
    for axes, values, label, names in rows:
        for column, (style, name) in enumerate(zip(AXIS_STYLES, names.split(), strict=True)):
            axes.plot(time, values[:, column], label=name, **style)
        axes.set_ylabel(label)
    for style, asked in zip(AXIS_STYLES, np.rad2deg(reference.attitude).T, strict=True):
        grid[1, 0].plot(time, asked, color=style["color"], linewidth=0.5)
    grid[1, 0].plot([], [], color="0.4", linewidth=0.5, label="asked for")
    draw_bounds(grid[0, 1], -scenario.mpc.velocity_limit, scenario.mpc.velocity_limit)

    low, high = scenario.airframe.rotor_speed_min, scenario.airframe.rotor_speed_max
    for rotor, (speed, colour) in enumerate(zip(np.sqrt(plan.input).T, _PALETTE, strict=True)):
        label, bound = f"rotor {rotor + 1}", (speed < low + 0.01) | (speed > high - 0.01)
        grid[2, 0].step(time, np.append(speed, speed[-1]), where="post", color=colour, label=label)
        dots = {"color": colour, "markersize": 3, "clip_on": False, "in_layout": False}
        grid[2, 0].plot(time[:-1][bound], speed[bound], "o", **dots)
    draw_bounds(grid[2, 0], low, high)
    grid[2, 0].set(ylabel="rotor speed (Hz)", ylim=(0.0, 1.1 * high))
    grid[2, 1].stackplot(time, list(terms.values()), labels=[name.replace("_", " ") for name in terms], colors=_PALETTE)
    grid[2, 1].set_ylabel("cost per stage (1)")
    for axes in grid.ravel():
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), handlelength=1.6)
    for axes in grid[-1]:
        axes.set_xlabel("time from now (s)")
    return figure


@styled
def poles_figure(A: FloatArray, errors: FloatArray, moved: FloatArray) -> Figure:
    """The airframe's matrix A, and how far errors in it move its poles.

    Args:
      A: of the plant's state [q_WB, p_WB, w_WB_W, v_WB_W], shape (13, 13).
      errors: size of the error of every entry, shape (n,).
      moved: the largest |pole| of each draw of errors, 1/s, shape (n, draws).
    """
    names = [
        f"${name}_{axis}$"
        for name, axes in (("q", "wxyz"), ("p", "xyz"), (r"\omega", "xyz"), ("v", "xyz"))
        for axis in axes
    ]
    figure = Figure(figsize=(2.1 * COLUMN, 1.05 * COLUMN), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.imshow(np.abs(A) > 1e-9, cmap="Blues", vmax=3.0)
    for row, column in np.argwhere(np.abs(A) > 1e-9):
        left.text(column, row, f"{A[row, column]:.3g}", ha="center", va="center", fontsize=5.5)
    left.set_title("A: the row's rate by the column (SI units)")
    left.set(xticks=range(13), yticks=range(13), xticklabels=names, yticklabels=names)
    right.loglog(errors, np.median(moved, axis=1), "o", color=_EXACT, label="median of the draws")
    right.loglog(errors, 2.0 * errors**0.25, "--", color=_AFFINE, label="proportional to error$^{1/4}$")
    right.set(xlabel="random error of every entry of A (SI units)", ylabel="largest |eigenvalue| (1/s)")
    right.set_title("zeros at the end of a chain of four")
    right.margins(x=0.03)
    right.legend(loc="lower right")
    return figure


@styled
def laws_figure(flights: Mapping[str, Flight]) -> Figure:
    """SNR and position error of up to three flights, by name."""
    figure = Figure(figsize=(1.6 * COLUMN, 1.2 * COLUMN), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    styles = (LAW_STYLES["level"], LAW_STYLES["three_axis"], {"color": "#D55E00", "linestyle": "-"})
    for (name, flight), style in zip(flights.items(), styles, strict=False):
        above.plot(flight.time, flight.snr_db, label=name, **style)
        below.plot(flight.time, 100.0 * position_error(flight), **style)
    above.set_ylabel("SNR (dB)")
    below.set(xlabel="time (s)", ylabel="position error (cm)", ylim=(0.0, None))
    legend_above(figure, above, 3)
    return figure


@styled
def reach_figure(
    angles: FloatArray, outlines: Mapping[float, BoolArray], tilts: FloatArray, reach: FloatArray, limit: float
) -> Figure:
    """Attitudes at which an airframe can hover.

    Args:
      angles: roll and pitch alike, deg, shape (n,).
      outlines: by tilt, deg: whether it can, over pitch by roll, shape (n, n).
      tilts: deg, shape (m,).
      reach: lowest and highest roll, highest pitch, each with the other angle zero, deg, shape (m, 3).
      limit: half-width of the controller's box, deg.
    """
    figure = Figure(figsize=(2.1 * COLUMN, 1.0 * COLUMN), layout="constrained")
    left, right = figure.subplots(1, 2)
    for (tilt, rests), colour in zip(outlines.items(), _PALETTE, strict=False):
        if not rests.any():
            continue
        left.contour(angles, angles, rests, [0.5], colors=colour, linewidths=1.3)
        row, column = np.argwhere(rests)[-1]  # the highest pitch
        left.text(
            angles[column], angles[row] + 0.7, f"{tilt:g} deg", color=colour, ha="center", va="bottom", fontsize=6
        )
    left.plot(*_square(limit), label="controller's box", **BOUND_STYLE)
    left.set(aspect="equal", xlabel="roll (deg)", ylabel="pitch (deg)", title="attitudes to hover at, by tilt")
    left.set(xlim=(-35.0, 40.0), ylim=(-37.5, 37.5))
    left.legend(loc="lower right")
    for column, (name, style) in enumerate(
        zip(("roll, negative", "roll, positive", "pitch"), AXIS_STYLES, strict=True)
    ):
        right.plot(tilts, np.abs(reach[:, column]), label=name, **style)
    draw_bounds(right, limit, label="controller's box")
    right.set(
        xlabel="tilt of the rotors (deg)", ylabel="reach from level (deg)", title="one angle alone", ylim=(0.0, None)
    )
    right.legend(loc="upper left")
    return figure
