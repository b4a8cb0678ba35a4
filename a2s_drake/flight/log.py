"""Flight: the log of one run of a diagram, and how it is saved and loaded."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import Field, dataclass, field, fields
from pathlib import Path
from typing import Any, Self

import numpy as np

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.files import DamagedFileError, read_table, write_arrays, written_whole
from a2s_drake.common.signals import Fallback as Fallback
from a2s_drake.scenario.scenario import Scenario
from a2s_drake.scenario.yaml_reader import read_text

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
      solver_fallback: see `a2s_drake.common.signals.Fallback`, dimensionless, shape (n,).
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
