"""Flight: the log of one run of a diagram, and how it is saved and loaded."""

import csv
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import Field, dataclass, field, fields
from pathlib import Path
from typing import Any, Self

import numpy as np

from a2s_drake.common.arrays import Array, FloatArray
from a2s_drake.common.files import (
    DamagedFileError,
    check_rows,
    entries_after,
    read_arrays,
    read_text_entry,
    write_arrays,
    written_whole,
)
from a2s_drake.common.quoting import quoted
from a2s_drake.common.signals import Fallback as Fallback
from a2s_drake.flight.arrays import ANGLES, STATE_UNIT, columns_of, logged, optional, shape_of, state_columns
from a2s_drake.flight.copies import Copies, read_copies
from a2s_drake.scenario.scenario import Scenario

# One row of a flight: what was logged at one time, by the names of the arrays of `Flight`. `signals` holds the user's
# own, by their names.
Sample = Mapping[str, Any]

# In `flight.npz` these prefixes stand before the names of a flight's signals and of the user's own blocks.
SIGNAL, OWN_BLOCK = "signal:", "own_block:"


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
    """A run sampled at t_k = k T_s.

    Row k holds the state at t_k, what the UAV believed then, and the rotor speeds applied from t_k on. Beliefs and the
    values of an attitude law are those that the decision at t_k was based on: they are read before the blocks update.

    Diagrams without rotors (`link_only`) leave rotor speeds NaN. Without a solver its fields are zero. The arrays from
    `ship_antenna_position` on are read from output ports that not every diagram exports. They are NaN without the port,
    and in files of earlier versions. `position_command` without a port is the path.

    A flight with blocks of the user's own cannot be rebuilt from its scenario alone: `own_blocks` names them.

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
      solver_fallback: see `a2s_drake.common.signals.Fallback`, dimensionless, shape (n,).
      ship_antenna_position: where the ship's antenna truly is, m, W, shape (n, 3).
      reflection_magnitude: of the coherent reflection coefficient Gamma, dimensionless, shape (n,).
      reflection_phase: of Gamma, in (-pi, pi], rad, shape (n,).
      position_command: where the law wants the centre of mass, m, W, shape (n, 3).
      snr_measured_db: the SNR as measured, where it is first delivered, else NaN, dB, shape (n,).
      measured_state: position, attitude, velocity, angular velocity as measured, m, rad, m/s, rad/s, shape (n, 12).
      phasor: A, B, C of the interference as the UAV estimates it, dimensionless, shape (n, 3).
      force_estimate: the outer force as the UAV estimates it, N, W, shape (n, 3).
      signals: the user's own, `log` of `run_flight`, each of shape (n, width), by name.
      own_blocks: the blocks of the user's own that flew, name by role, `{"law": "MyLaw"}`.
      wall_clock: how long this run took; never saved, so None for a flight loaded from disk.
      files: the content of each track file that the scenario names, by field, such as `path_file`, as the diagram was
        built with it; where the diagram's builder noted none, as it was at take-off.
    """

    scenario: Scenario
    time: FloatArray = field(metadata=logged("s", "time"))
    position: FloatArray = field(metadata=logged("m", "position_{}", "xyz"))
    attitude: FloatArray = field(metadata=logged("rad", "{}", ANGLES))
    velocity: FloatArray = field(metadata=logged("m/s", "velocity_{}", "xyz"))
    angular_velocity: FloatArray = field(metadata=logged("rad/s", "angular_velocity_{}", "xyz"))
    rotor_speed: FloatArray = field(metadata=logged("Hz", "rotor_speed_{}", "123456"))
    position_reference: FloatArray = field(metadata=logged("m", "position_reference_{}", "xyz"))
    attitude_reference: FloatArray = field(metadata=logged("rad", "{}_reference", ANGLES))
    ship_position: FloatArray = field(metadata=logged("m", "ship_position_{}", "xyz"))
    channel_gain: FloatArray = field(metadata=logged("", "channel_gain"))
    snr_db: FloatArray = field(metadata=logged("dB", "snr"))
    spectral_efficiency: FloatArray = field(metadata=logged("bit/s/Hz", "spectral_efficiency"))
    phase_difference: FloatArray = field(metadata=logged("rad", "phase_difference"))
    solver_success: FloatArray = field(metadata=logged("", "solver_success"))
    solver_iterations: FloatArray = field(metadata=logged("", "solver_iterations"))
    solver_fallback: FloatArray = field(metadata=logged("", "solver_fallback"))
    ship_antenna_position: FloatArray = optional("m", columns_of("m", "ship_antenna_position_{}", "xyz"))
    reflection_magnitude: FloatArray = optional("", ["reflection_magnitude"])
    reflection_phase: FloatArray = optional("rad", ["reflection_phase_rad"])
    position_command: FloatArray = optional("m", columns_of("m", "position_command_{}", "xyz"))
    snr_measured_db: FloatArray = optional("dB", ["snr_measured_db"])
    measured_state: FloatArray = optional(STATE_UNIT, state_columns("measured_"))
    phasor: FloatArray = optional("", columns_of("", "phasor_{}", "abc"))
    force_estimate: FloatArray = optional("N", columns_of("N", "force_estimate_{}", "xyz"))
    signals: Mapping[str, FloatArray] = field(default_factory=dict)
    own_blocks: Mapping[str, str] = field(default_factory=dict)
    wall_clock: WallClock | None = None
    files: Mapping[str, bytes] = field(default_factory=dict)

    def __post_init__(self) -> None:
        rows = len(self.time)
        for name, columns in array_columns().items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, np.full(shape_of(rows, columns), np.nan))

    @property
    def law(self) -> str:
        """The name of the attitude law that flew: of the user's own block, else of the scenario's law."""
        return self.own_blocks.get("law", self.scenario.attitude_law.name)

    @property
    def rebuilds_from_scenario(self) -> bool:
        """Whether the scenario says all of what flew: no block was the user's own."""
        return not self.own_blocks

    @property
    def has_rotors(self) -> bool:
        """Whether a vehicle with rotors and a controller flew, rather than an ideal one."""
        return bool(np.isfinite(self.rotor_speed).any())

    @property
    def has_solver(self) -> bool:
        """Whether a controller with `solver_status` flew: at each sample it succeeds or says what stood in."""
        return bool(self.solver_success.any() or self.solver_fallback.any())

    def sample(self, row: int) -> Sample:
        """What was logged at t_k, k being the row."""
        signals = {name: values[row] for name, values in self.signals.items()}
        return {name: getattr(self, name)[row] for name in array_names()} | {"signals": signals}

    def save(self, folder: Path | str) -> None:
        """Writes `scenario.yaml` and `flight.npz` into a folder, which is made where it is missing.

        The scenario's track files, as the diagram was built with them, are copied beside them, and `scenario.yaml`
        names the copies. `flight.npz` notes what was copied. So copies of an earlier flight in this folder go, but no
        other file is removed or overwritten: where one stands in the way, the copy is called `path_2.csv` and so on.

        A flight with blocks of the user's own cannot be flown again from `scenario.yaml` alone; `flight.npz` names
        these blocks.

        Raises:
          OSError: when the disk refuses; names the file. All stays as it was.
          ScenarioError: when a track file is not in `files` and cannot be read; names it.
          ValueError: when the name of a signal or block holds a character that cannot be printed; names it.
        """
        folder = Path(folder)
        arrays = self._saved()
        folder.mkdir(parents=True, exist_ok=True)
        copies = Copies.placed(folder, self.scenario, self.files)
        # The files are moved into place at the end, the log last, because a folder without a log holds no flight.
        with ExitStack() as stack:
            parts = ("flight.npz", "scenario.yaml", *copies.written)
            log, settings, *tracks = (stack.enter_context(written_whole(folder / name)) for name in parts)
            write_arrays(log, arrays | copies.notes())
            settings.write_text(copies.scenario.to_yaml(), encoding="utf-8")
            for track, content in zip(tracks, copies.written.values(), strict=True):
                track.write_bytes(content)
        copies.remove_left_over()

    def _saved(self) -> dict[str, Array]:
        """What `flight.npz` holds, by name."""
        arrays: dict[str, Array] = {name: getattr(self, name) for name in array_names()}
        arrays |= {SIGNAL + name: values for name, values in self.signals.items()}
        arrays |= {OWN_BLOCK + role: np.array(name) for role, name in self.own_blocks.items()}
        for name in (*arrays, *self.own_blocks.values()):
            if not name.isprintable():
                raise ValueError(f"{quoted(name)}: a name in flight.npz must consist of characters that can be printed")
        return arrays

    def columns(self) -> dict[str, FloatArray]:
        """Every scalar of the log by a name, as `save_csv` writes them, each of shape (n,).

        The name of an array's column ends in its unit, if it has one. A signal of the user's own has no known unit: its
        columns are its name with `_1`, `_2` and so on.
        `pandas.DataFrame(flight.columns())` makes a table of it.
        """
        table: dict[str, FloatArray] = {}
        for name, columns in array_columns().items():
            table |= zip(columns, getattr(self, name).reshape(len(self.time), len(columns)).T, strict=True)
        for name, values in self.signals.items():
            table |= {f"{name}_{place}": column for place, column in enumerate(values.T, 1)}
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

        A track file that cannot be read is left out of `files`, and a UserWarning names it.

        Raises:
          OSError: when a file cannot be read; ScenarioError or ValueError, which name the file: when one is damaged.
        """
        folder = Path(folder)
        settings, log = folder / "scenario.yaml", folder / "flight.npz"
        scenario = Scenario.load(settings)
        arrays = read_arrays(log)
        widths: dict[str, int | None] = {
            name: len(columns)
            for name, columns in array_columns().items()
            if name in arrays or name not in optional_names()
        }
        signals = entries_after(SIGNAL, arrays)
        table = check_rows(log, arrays, widths | dict.fromkeys(signals.values()))
        time = table["time"]
        if not (np.isfinite(time).all() and (time[:1] == 0.0).all() and (np.diff(time) > 0.0).all()):
            raise DamagedFileError(f"{log}: time must start at 0 and increase")
        own_blocks = {
            role: read_text_entry(log, arrays, name) for role, name in entries_after(OWN_BLOCK, arrays).items()
        }
        own_signals = {name: table.pop(entry) for name, entry in signals.items()}
        files = read_copies(scenario.mission)
        return cls(scenario, **table, signals=own_signals, own_blocks=own_blocks, wall_clock=None, files=files)


def _logged_fields() -> list[Field[Any]]:
    return [entry for entry in fields(Flight) if "unit" in entry.metadata]


def array_names() -> list[str]:
    """The names of the arrays of a `Flight`, in order."""
    return [entry.name for entry in _logged_fields()]


def optional_names() -> set[str]:
    """The arrays of a `Flight` that may be NaN throughout, and that files of earlier versions lack."""
    return {entry.name for entry in _logged_fields() if entry.metadata["optional"]}


def array_units() -> dict[str, str]:
    """The unit of each array of a `Flight`; an empty text for numbers without one, several where columns differ."""
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
        """Pickles both arguments, so that a worker process can hand the error on."""
        return type(self), (str(self), self.flight)


class FlightInterrupted(FlightEnded):
    """A flight that its user interrupted."""
