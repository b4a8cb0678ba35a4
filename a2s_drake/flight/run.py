"""How a diagram is flown and its signals are logged."""

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import Context, Diagram

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.signals import SolverStatus
from a2s_drake.flight.divergence import DivergenceMonitor
from a2s_drake.flight.log import Flight, FlightEnded, FlightInterrupted, Sample, WallClock, array_columns
from a2s_drake.scenario.scenario import Scenario


def run_flight(
    diagram: Diagram,
    scenario: Scenario,
    progress: Callable[[int], Any] | None = None,
    *,
    observer: Callable[[Sample], Any] | None = None,
    target_realtime_rate: float = 0.0,
) -> Flight:
    """Simulates a diagram over a scenario's duration and logs the ports that it exports.

    Args:
      diagram: `closed_loop` or `link_only` of `diagrams.BUILDERS`, built for this scenario, or one of the user's that
        exports the same ports.
      progress: called with 1 after each sample; what it raises reaches the caller as it is.
      observer: called with each sample as soon as it is logged; it must not change what it is given. What it raises
        reaches the caller as it is.
      target_realtime_rate: how fast simulated time may pass over wall-clock time; 0 means as fast as it can.
    Raises:
      FlightEnded: when the vehicle's motion diverges, or Drake refuses to go on; names time and reason.
      FlightInterrupted: on KeyboardInterrupt.
    """
    simulator = Simulator(diagram)
    config = SimulatorConfig(
        integration_scheme=scenario.simulation.integrator,
        max_step_size=scenario.simulation.max_step_size,
        use_error_control=False,
        target_realtime_rate=target_realtime_rate,
    )
    ApplySimulatorConfig(config, simulator)
    context = simulator.get_context()
    monitor = DivergenceMonitor(diagram, scenario.simulation, scenario.mpc.period)
    if context.num_continuous_states():  # An ideal vehicle has none, and may turn as it likes.
        simulator.set_monitor(monitor)
    rows: list[dict[str, Any]] = []
    begin = perf_counter()

    def log() -> Flight:
        return _assemble(scenario, rows, perf_counter() - begin)

    def fly_to(time: float) -> dict[str, Any]:
        if time > 0.0:
            simulator.AdvanceTo(time)
        row = {"time": time} | _read_state(diagram, context)
        start = perf_counter()
        if time == 0.0:
            simulator.Initialize()
        # The updates due at t_k happen now, so that row k holds the input applied from t_k on.
        simulator.AdvancePendingEvents()
        row["step"] = perf_counter() - start
        return row | _read_input(diagram, context)

    try:
        for time in scenario.sample_times():
            try:
                rows.append(fly_to(time))
            except (RuntimeError, FloatingPointError) as error:  # of Drake, of a block, or of the monitor
                if not rows:
                    raise  # It never flew: the diagram is at fault, not the flight.
                # In the middle of a step Drake notices first that a state has overflowed, and names what it came upon.
                reason = monitor.overflow() if monitor.has_overflowed(context) else error
                raise FlightEnded(f"the flight ended at t = {context.get_time():.3f} s: {reason}", log()) from error
            # Outside the inner try: errors of theirs are no end of the flight.
            if progress is not None:
                progress(1)
            if observer is not None:
                observer(rows[-1])
    except KeyboardInterrupt:
        raise FlightInterrupted(f"interrupted at t = {context.get_time():.2f} s", log()) from None
    return log()


def _read(diagram: Diagram, context: Context, name: str) -> FloatArray:
    return np.array(diagram.GetOutputPort(name).Eval(context))


def _read_state(diagram: Diagram, context: Context) -> dict[str, Any]:
    """What the update at t_k does not change. Read before it, so that the controller finds its inputs in the cache."""
    state = _read(diagram, context, "vehicle_state").reshape(4, 3)
    row = dict(zip(("position", "attitude", "velocity", "angular_velocity"), state, strict=True))
    for name in ("position_reference", "attitude_reference", "ship_position"):
        row[name] = _read(diagram, context, name)
    for name in ("channel_gain", "snr_db", "spectral_efficiency", "phase_difference"):
        row[name] = _read(diagram, context, name)[0]
    return row


def _read_input(diagram: Diagram, context: Context) -> dict[str, Any]:
    """What the update at t_k decides; a diagram without a controller has none of it."""
    has_mpc = diagram.HasOutputPort("solver_status")
    status = SolverStatus(_read(diagram, context, "solver_status") if has_mpc else np.zeros(4))
    return {
        "rotor_speed": np.sqrt(_read(diagram, context, "rotor_speed_squared")) if has_mpc else np.full(6, np.nan),
        "solver_success": status.success,
        "solver_iterations": status.iterations,
        "solver_fallback": status.fallback,
    }


def _assemble(scenario: Scenario, rows: list[dict[str, Any]], total: float) -> Flight:
    # Without a row NumPy could not tell how wide they are.
    shapes = {name: (len(rows), len(names))[: min(len(names), 2)] for name, names in array_columns().items()}
    columns = {name: np.array([row[name] for row in rows], float).reshape(shape) for name, shape in shapes.items()}
    clock = WallClock(np.array([row["step"] for row in rows]), total)
    return Flight(scenario, **columns, wall_clock=clock)
