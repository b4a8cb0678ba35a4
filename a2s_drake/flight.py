"""Flight: the log of one run of a diagram, and how it is flown, saved and loaded."""

import csv
from collections.abc import Callable, Mapping, Sequence
from dataclasses import Field, dataclass, field, fields
from pathlib import Path
from time import perf_counter
from typing import Any, Self

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import Context, Diagram

from a2s_drake.arrays import FloatArray
from a2s_drake.divergence import DivergenceMonitor
from a2s_drake.files import DamagedFileError, read_table, write_arrays, written_whole
from a2s_drake.mpc.controller import SolverStatus
from a2s_drake.mpc.planner import Fallback as Fallback
from a2s_drake.scenario import Scenario
from a2s_drake.yaml_reader import read_text

# One row of a flight: what was logged at one time, by the names of the arrays of `Flight`.
Sample = Mapping[str, Any]


@dataclass(frozen=True)
class WallClock:
    """How long a run took on the machine that flew it, s. Kept apart from the log, which must be reproducible.

    Attributes:
      step: each controller sample, shape (n,); the first includes the cold start.
      total: the whole run.
    """

    step: FloatArray
    total: float


def _logged(unit: str, column: str, parts: Sequence[str] = ("",)) -> dict[str, Any]:
    """What an array of the log holds: its unit, and the name of each of its columns, which ends in the unit."""
    suffix = f"_{unit.lower().replace('/', '_per_')}" if unit else ""
    return {"unit": unit, "columns": [column.format(part) + suffix for part in parts]}


_ANGLES = ("roll", "pitch", "yaw")


@dataclass(frozen=True, eq=False)
class Flight:
    """A run sampled at t_k = k T_s. Row k holds the state at t_k and the rotor speeds applied from t_k on.

    Diagrams without a vehicle of their own (`link_only`) leave rotor speeds NaN and the solver fields at zero.

    Attributes:
      scenario: what was flown.
      time: t_k, s, shape (n,).
      position: centre of mass, m, W, shape (n, 3).
      attitude: roll, pitch, yaw, rad, shape (n, 3).
      velocity: of the centre of mass, m/s, W, shape (n, 3).
      angular_velocity: of the body, rad/s, B, shape (n, 3).
      rotor_speed: of each rotor, Hz, shape (n, 6); the first stands on the body's +x axis.
      position_reference: planned centre of mass, m, W, shape (n, 3).
      attitude_reference: roll, pitch, yaw that the law asks for, rad, shape (n, 3).
      ship_position: the ship's reference point at sea level, m, W, shape (n, 3).
      channel_gain: |g|^2, dimensionless, shape (n,).
      snr_db: P_t |g|^2 / sigma^2, dB, shape (n,).
      spectral_efficiency: log2(1 + SNR), bit/s/Hz, shape (n,).
      phase_difference: dPhi, unwrapped, rad, shape (n,).
      solver_success: 1 where the problem as posed was solved, else 0, dimensionless, shape (n,).
      solver_iterations: of the solver, over all attempts, dimensionless, shape (n,).
      solver_fallback: see `a2s_drake.mpc.planner.Fallback`, dimensionless, shape (n,).
      wall_clock: how long this run took; never saved, so None for a flight loaded from disk.
    """

    scenario: Scenario
    time: FloatArray = field(metadata=_logged("s", "time"))
    position: FloatArray = field(metadata=_logged("m", "position_{}", "xyz"))
    attitude: FloatArray = field(metadata=_logged("rad", "{}", _ANGLES))
    velocity: FloatArray = field(metadata=_logged("m/s", "velocity_{}", "xyz"))
    angular_velocity: FloatArray = field(metadata=_logged("rad/s", "angular_velocity_{}", "xyz"))
    rotor_speed: FloatArray = field(metadata=_logged("Hz", "rotor_speed_{}", "123456"))
    position_reference: FloatArray = field(metadata=_logged("m", "position_reference_{}", "xyz"))
    attitude_reference: FloatArray = field(metadata=_logged("rad", "{}_reference", _ANGLES))
    ship_position: FloatArray = field(metadata=_logged("m", "ship_position_{}", "xyz"))
    channel_gain: FloatArray = field(metadata=_logged("", "channel_gain"))
    snr_db: FloatArray = field(metadata=_logged("dB", "snr"))
    spectral_efficiency: FloatArray = field(metadata=_logged("bit/s/Hz", "spectral_efficiency"))
    phase_difference: FloatArray = field(metadata=_logged("rad", "phase_difference"))
    solver_success: FloatArray = field(metadata=_logged("", "solver_success"))
    solver_iterations: FloatArray = field(metadata=_logged("", "solver_iterations"))
    solver_fallback: FloatArray = field(metadata=_logged("", "solver_fallback"))
    wall_clock: WallClock | None = None

    @property
    def has_rotors(self) -> bool:
        """Whether a vehicle with rotors and a controller flew, rather than an ideal one."""
        return bool(np.isfinite(self.rotor_speed).any())

    def sample(self, row: int) -> Sample:
        """What was logged at t_k, k being the row."""
        return {name: getattr(self, name)[row] for name in array_names()}

    def save(self, folder: Path | str) -> None:
        """Writes `scenario.yaml` and `flight.npz` into a folder, which is made where it is missing.

        Where the disk refuses (OSError, which names the file), both stay as they were.
        """
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        # Both take their places at the end, the log last: where it is missing, there is no flight.
        with written_whole(folder / "flight.npz") as log, written_whole(folder / "scenario.yaml") as settings:
            write_arrays(log, {name: getattr(self, name) for name in array_names()})
            self.scenario.save(settings)

    def columns(self) -> dict[str, FloatArray]:
        """Every scalar of the log by a name that ends in its unit, as `save_csv` writes them, each of shape (n,).

        `pandas.DataFrame(flight.columns())` makes a table of it.
        """
        table: dict[str, FloatArray] = {}
        for name, columns in array_columns().items():
            table |= zip(columns, getattr(self, name).reshape(len(self.time), len(columns)).T, strict=True)
        return table

    def save_csv(self, path: Path | str) -> None:
        """Writes `columns` as a table with one header line into a file, whose folder is made where it is missing.

        `float` of each entry is the logged value exactly; NaN reads `nan`.
        """
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        columns = self.columns()
        with written_whole(path) as part, part.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows(np.column_stack(list(columns.values())).tolist())

    @classmethod
    def load(cls, folder: Path | str) -> Self:
        """Reads what `save` wrote.

        Raises:
          OSError: when a file cannot be read; ScenarioError or ValueError, which name the file: when one is damaged.
        """
        folder = Path(folder)
        settings, log = folder / "scenario.yaml", folder / "flight.npz"
        scenario = Scenario.from_yaml(read_text(settings), source=str(settings))
        arrays = read_table(log, {name: len(columns) for name, columns in array_columns().items()})
        time = arrays["time"]
        if not (np.isfinite(time).all() and (time[:1] == 0.0).all() and (np.diff(time) > 0.0).all()):
            raise DamagedFileError(f"{log}: time must start at 0 and increase")
        return cls(scenario, **arrays, wall_clock=None)


def _logged_fields() -> list[Field[Any]]:
    return [entry for entry in fields(Flight) if "unit" in entry.metadata]


def array_names() -> list[str]:
    """The names of the arrays of a `Flight`, in order."""
    return [entry.name for entry in _logged_fields()]


def array_units() -> dict[str, str]:
    """The unit of each array of a `Flight`; an empty text for numbers without one."""
    return {entry.name: entry.metadata["unit"] for entry in _logged_fields()}


def array_columns() -> dict[str, list[str]]:
    """The names in `Flight.columns` of each array's columns."""
    return {entry.name: entry.metadata["columns"] for entry in _logged_fields()}


class FlightEnded(RuntimeError):
    """A flight that ended before its time. `flight` holds what was logged until then."""

    def __init__(self, message: str, flight: Flight) -> None:
        super().__init__(message)
        self.flight = flight

    def __reduce__(self) -> tuple[Any, ...]:
        """Both arguments travel, so that it can leave a worker process."""
        return type(self), (str(self), self.flight)


class FlightInterrupted(FlightEnded):
    """A flight that its user interrupted."""


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
