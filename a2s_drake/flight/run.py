"""How a diagram is flown and its signals are logged."""

from collections.abc import Callable, Collection, Sequence
from time import perf_counter
from typing import Any

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import Context, Diagram, OutputPort

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.signals import SolverStatus, State
from a2s_drake.common.wiring import check_ports, own_blocks, track_files
from a2s_drake.flight.arrays import shape_of
from a2s_drake.flight.divergence import DivergenceMonitor
from a2s_drake.flight.log import Flight, FlightEnded, FlightInterrupted, Sample, WallClock, array_columns
from a2s_drake.flight.signals import Signals, printable
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.scenario.track_file import read_files

# Output ports that a diagram may export or not, by size.
_OPTIONAL_PORTS = {
    "ship_antenna_position": 3,
    "reflection": 2,
    "position_command": 3,
    "snr_measurement": 2,
    "measured_state": 12,
    "phasor": 3,
    "force_estimate": 3,
    "rotor_speed_squared": 6,
    "solver_status": 4,
}
_UNKNOWN = {name: np.full(size, np.nan) for name, size in _OPTIONAL_PORTS.items()}


def run_flight(
    diagram: Diagram,
    scenario: Scenario,
    progress: Callable[[int], Any] | None = None,
    *,
    log: Sequence[OutputPort] = (),
    observer: Callable[[Sample], Any] | None = None,
    target_realtime_rate: float = 0.0,
) -> Flight:
    """Simulates a diagram over a scenario's duration and logs the ports that it exports.

    Args:
      diagram: `closed_loop` or `link_only` of `diagrams.BUILDERS`, built for this scenario, or one of the user's that
        exports the same ports. It may also export these, under exactly these names: `rotor_speed_squared` and
        `solver_status` of a controller, `ship_antenna_position`, `reflection` (magnitude, phase), `position_command`,
        `snr_measurement` (dB, time stamp), `measured_state`, `phasor` and `force_estimate`.
      progress: called with 1 after each sample; what it raises reaches the caller as it is.
      log: ports whose values the flight keeps as `Flight.signals`, vector-valued, of the diagram or of any block in it;
        `a2s_drake.flight.signals.Signals` says which names they get. Row k holds their values at the state at t_k. A
        sampled block shows the value that holds from t_k on, as the rotor speeds do.
      observer: called with each sample as soon as it is logged; it must not change what it is given. What it raises
        reaches the caller as it is.
      target_realtime_rate: how fast simulated time may pass over wall-clock time; 0 means as fast as it can.
    Raises:
      ScenarioError: when a track file must be read now, because the diagram holds no note of it, and cannot be.
      TypeError, WiringError: before the flight, when `log` is no list, an entry of it is no vector-valued port in this
        diagram, or a port with one of the names above has another size; names it.
      FlightEnded: when the vehicle's motion diverges, or Drake refuses to go on; names time and reason.
      FlightInterrupted: on KeyboardInterrupt.
    """
    exported = {name: size for name, size in _OPTIONAL_PORTS.items() if diagram.HasOutputPort(name)}
    check_ports(printable(diagram.get_name()), diagram, {}, exported)
    signals = Signals(diagram, log)
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
    reader, receiver = signals.reader(context), _Receiver()
    names = {role: printable(name) for role, name in own_blocks(diagram).items()}
    rows: list[dict[str, Any]] = []
    files = _files_flown(diagram, scenario)
    begin = perf_counter()

    def flown() -> Flight:
        clock = WallClock(np.array([row["step"] for row in rows]), perf_counter() - begin)
        kept = signals.stacked([row["signals"] for row in rows])
        return Flight(scenario, **_arrays(rows), signals=kept, own_blocks=names, wall_clock=clock, files=files)

    def fly_to(time: float) -> dict[str, Any]:
        if time > 0.0:
            simulator.AdvanceTo(time)
        row = {"time": time} | _read_state(diagram, context) | _read_beliefs(diagram, context, exported, receiver)
        start = perf_counter()
        if time == 0.0:
            simulator.Initialize()
        # The updates due at t_k happen now, so that row k holds the input applied from t_k on.
        simulator.AdvancePendingEvents()
        row["step"] = perf_counter() - start
        return row | _read_input(diagram, context, exported) | {"signals": reader.read()}

    try:
        for time in scenario.sample_times():
            try:
                rows.append(fly_to(time))
            except (RuntimeError, FloatingPointError) as error:  # of Drake, of a block, or of the monitor
                if not rows:
                    raise  # It never flew: the diagram is at fault, not the flight.
                # Within a step Drake sees an overflow first. Its message names a block, not the cause.
                reason = monitor.overflow() if monitor.has_overflowed(context) else error
                raise FlightEnded(f"the flight ended at t = {context.get_time():.3f} s: {reason}", flown()) from error
            # These calls stand outside the inner try, because an error in them does not mean that the flight failed.
            if progress is not None:
                progress(1)
            if observer is not None:
                observer(rows[-1])
    except KeyboardInterrupt:
        raise FlightInterrupted(f"interrupted at t = {context.get_time():.2f} s", flown()) from None
    return flown()


def _files_flown(diagram: Diagram, scenario: Scenario) -> dict[str, bytes]:
    """The content of each track file that a scenario names, by field, as the diagram was built with it.

    The file on the disk may have changed since the diagram was built, but the blocks have not. A diagram whose builder
    noted nothing leaves only the files as they are now.
    """
    noted = track_files(diagram)
    if noted is None:
        return read_files(scenario.mission)
    return {field: content for field, content in noted.items() if getattr(scenario.mission, field, None) is not None}


def _read(diagram: Diagram, context: Context, name: str) -> FloatArray:
    return np.array(diagram.GetOutputPort(name).Eval(context))


def _read_state(diagram: Diagram, context: Context) -> dict[str, Any]:
    """What the update at t_k does not change. Read before it, so that the controller finds its inputs in the cache."""
    state = State(_read(diagram, context, "vehicle_state"))
    row = {name: getattr(state, name) for name in ("position", "attitude", "velocity", "angular_velocity")}
    for name in ("position_reference", "attitude_reference", "ship_position"):
        row[name] = _read(diagram, context, name)
    for name in ("channel_gain", "snr_db", "spectral_efficiency", "phase_difference"):
        row[name] = _read(diagram, context, name)[0]
    return row


class _Receiver:
    """Tells the measurements of the SNR apart: a new time stamp is a new delivery."""

    def __init__(self) -> None:
        self._stamp = np.nan

    def new(self, value: float, stamp: float) -> float:
        """The measured value, dB, if it is new, else NaN. Before the first measurement the stamp is NaN."""
        if np.isnan(stamp) or stamp == self._stamp:
            return np.nan
        self._stamp = stamp
        return value


def _read_beliefs(diagram: Diagram, context: Context, exported: Collection[str], receiver: _Receiver) -> dict[str, Any]:
    """What not every diagram shows: more of the truth, what the law commands, and what the UAV believes.

    Read before the update at t_k as well, because the decision at t_k is based on it.
    """

    def read(name: str) -> FloatArray:
        return _read(diagram, context, name) if name in exported else _UNKNOWN[name]

    row: dict[str, Any] = {
        name: read(name) for name in ("ship_antenna_position", "measured_state", "phasor", "force_estimate")
    }
    row["reflection_magnitude"], row["reflection_phase"] = read("reflection")
    # A law without this port keeps the vehicle on its path.
    command = "position_command" if "position_command" in exported else "position_reference"
    row["position_command"] = _read(diagram, context, command)
    row["snr_measured_db"] = receiver.new(*read("snr_measurement"))
    return row


def _read_input(diagram: Diagram, context: Context, exported: Collection[str]) -> dict[str, Any]:
    """What the update at t_k decides. Rotor speeds are NaN without a controller, solver fields 0 without a solver."""
    has_rotors, has_solver = "rotor_speed_squared" in exported, "solver_status" in exported
    status = SolverStatus(_read(diagram, context, "solver_status") if has_solver else np.zeros(4))
    return {
        "rotor_speed": np.sqrt(_read(diagram, context, "rotor_speed_squared"))
        if has_rotors
        else _UNKNOWN["rotor_speed_squared"],
        "solver_success": status.success,
        "solver_iterations": status.iterations,
        "solver_fallback": status.fallback,
    }


def _arrays(rows: list[dict[str, Any]]) -> dict[str, FloatArray]:
    # Without a row NumPy could not tell how wide they are.
    shapes = {name: shape_of(len(rows), columns) for name, columns in array_columns().items()}
    return {name: np.array([row[name] for row in rows], float).reshape(shape) for name, shape in shapes.items()}
