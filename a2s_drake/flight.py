"""Flight: the log of one run of a diagram, and how it is flown, saved and loaded."""

import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from time import perf_counter
from typing import Any, Self

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import Context, Diagram

from a2s_drake.arrays import FloatArray
from a2s_drake.files import written_whole
from a2s_drake.mpc.controller import SolverStatus
from a2s_drake.mpc.planner import Fallback as Fallback
from a2s_drake.scenario import Scenario


@dataclass(frozen=True)
class WallClock:
    """How long a run took on the machine that flew it, s. Kept apart from the log, which must be reproducible.

    Attributes:
      step: each controller sample, shape (n,); the first includes the cold start.
      total: the whole run.
    """

    step: FloatArray
    total: float


@dataclass(frozen=True, eq=False)
class Flight:
    """A run sampled at t_k = k T_s. Row k holds the state at t_k and the rotor speeds applied from t_k on.

    Diagrams without a vehicle of their own (`link_only`) leave rotor speeds NaN and the solver fields at zero.
    """

    scenario: Scenario
    time: FloatArray  # (n,) s
    position: FloatArray  # (n, 3) m, W
    attitude: FloatArray  # (n, 3) roll, pitch, yaw, rad
    velocity: FloatArray  # (n, 3) m/s, W
    angular_velocity: FloatArray  # (n, 3) rad/s, B
    rotor_speed: FloatArray  # (n, 6) Hz
    position_reference: FloatArray  # (n, 3) m, W
    attitude_reference: FloatArray  # (n, 3) rad
    ship_position: FloatArray  # (n, 3) m, W, at sea level
    channel_gain: FloatArray  # (n,) |g|^2
    snr_db: FloatArray  # (n,) dB
    spectral_efficiency: FloatArray  # (n,) bit/s/Hz
    phase_difference: FloatArray  # (n,) rad
    solver_success: FloatArray  # (n,) 1 where the problem as posed was solved, else 0
    solver_iterations: FloatArray  # (n,)
    solver_fallback: FloatArray  # (n,) see a2s_drake.mpc.planner.Fallback
    wall_clock: WallClock | None = None  # of this run; never saved

    @property
    def has_rotors(self) -> bool:
        """Whether a vehicle with rotors and a controller flew, rather than an ideal one."""
        return bool(np.isfinite(self.rotor_speed).any())

    def save(self, folder: Path | str) -> None:
        """Writes `scenario.yaml` and `flight.npz` into a folder, which is made where it is missing."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        with written_whole(folder / "scenario.yaml") as part:
            self.scenario.save(part)
        with written_whole(folder / "flight.npz") as part, part.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **{name: getattr(self, name) for name in array_names()})

    @classmethod
    def load(cls, folder: Path | str) -> Self:
        """Reads what `save` wrote.

        Raises:
          OSError: when a file is missing; ScenarioError or ValueError, which name the file: when one is damaged.
        """
        folder = Path(folder)
        settings, log = folder / "scenario.yaml", folder / "flight.npz"
        scenario = Scenario.from_yaml(settings.read_text(encoding="utf-8"), source=str(settings))
        try:
            with log.open("rb") as file, np.load(file) as archive:
                return cls(scenario, **{name: archive[name] for name in array_names()})
        except (ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as error:
            raise ValueError(f"{log}: {error}") from error


def array_names() -> list[str]:
    """The names of the arrays of a `Flight`, in order."""
    return [entry.name for entry in fields(Flight) if entry.name not in ("scenario", "wall_clock")]


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


def run_flight(diagram: Diagram, scenario: Scenario, progress: Callable[[int], Any] | None = None) -> Flight:
    """Simulates a diagram over a scenario's duration and logs the ports that it exports.

    Args:
      diagram: `closed_loop` or `link_only` of `diagrams.BUILDERS`, built for this scenario, or one of the user's that
        exports the same ports.
      progress: called with 1 after each sample.
    Raises:
      FlightEnded: when the vehicle's state is no longer finite, or Drake refuses to go on; names time and reason.
      FlightInterrupted: on KeyboardInterrupt.
    """
    simulator = Simulator(diagram)
    config = SimulatorConfig(
        integration_scheme=scenario.simulation.integrator,
        max_step_size=scenario.simulation.max_step_size,
        use_error_control=False,
    )
    ApplySimulatorConfig(config, simulator)
    context = simulator.get_context()
    rows: list[dict[str, Any]] = []
    begin = perf_counter()

    def log() -> Flight:
        return _assemble(scenario, rows, perf_counter() - begin)

    try:
        for time in scenario.sample_times():
            if time > 0.0:
                simulator.AdvanceTo(time)
                _check_state(context)
            row = {"time": time} | _read_state(diagram, context)
            start = perf_counter()
            if time == 0.0:
                simulator.Initialize()
            # The updates due at t_k happen now, so that row k holds the input applied from t_k on.
            simulator.AdvancePendingEvents()
            row["step"] = perf_counter() - start
            rows.append(row | _read_input(diagram, context))
            if progress is not None:
                progress(1)
    except KeyboardInterrupt:
        raise FlightInterrupted(f"interrupted at t = {context.get_time():.2f} s", log()) from None
    except (RuntimeError, FloatingPointError) as error:  # Drake's own complaints, and ours about the state
        if not rows:
            raise  # It never flew: the diagram is at fault, not the flight.
        raise FlightEnded(f"the flight ended at t = {context.get_time():.3f} s: {error}", log()) from error
    return log()


def _check_state(context: Context) -> None:
    """Raises FloatingPointError, which names the quantity, when the plant's state is not finite."""
    state = context.get_continuous_state_vector().CopyToVector()
    if not np.isfinite(state).all():
        broken = "position or attitude" if not np.isfinite(state[:7]).all() else "velocity"
        raise FloatingPointError(f"the vehicle's {broken} is not finite")


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
    columns = {name: np.array([row[name] for row in rows]) for name in array_names()}
    clock = WallClock(np.array([row["step"] for row in rows]), total)
    return Flight(scenario, **columns, wall_clock=clock)
