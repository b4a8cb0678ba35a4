"""Kept flights that are damaged or tampered with: they are as they were written, or they are refused."""

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Flight, FlightInterrupted, Scenario, ScenarioError, run_flight
from a2s_drake.common.files import DamagedFileError, read_arrays
from a2s_drake.flight.log import array_columns, array_names, optional_names
from diagrams import build_link_only
from tests.support.damage import FLIPS, archive_of, content, encrypted, flip_many, rewrite
from tests.support.flights import made_up_flight


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    """The folder of a flight."""
    made_up_flight().save(tmp_path / "kept")
    return tmp_path / "kept"


@pytest.fixture
def _scenario_read_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The damage is in the log alone, and reading YAML is slow."""
    monkeypatch.setattr(Scenario, "from_yaml", lambda *_, **__: made_up_flight().scenario)


@pytest.mark.usefixtures("_scenario_read_once")
def test_a_bit_turned_over_in_a_kept_flight_changes_no_number(kept: Path, rng: np.random.Generator) -> None:
    def load() -> list[np.ndarray]:
        flown = Flight.load(kept)
        return [getattr(flown, name) for name in array_names()]

    same, refused = flip_many(kept / "flight.npz", rng, load)
    assert same > 0  # the date of an entry, say
    assert refused > FLIPS // 2


def with_header(shape: str) -> bytes:
    """An archive whose one array says that it has some shape, and whose checksums are right."""
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}".ljust(117).encode() + b"\n"
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("time.npy", b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + bytes(64))
    return archive.getvalue()


def test_an_array_with_the_right_header_is_read(tmp_path: Path) -> None:
    (tmp_path / "right.npz").write_bytes(with_header("(8,)"))
    np.testing.assert_array_equal(read_arrays(tmp_path / "right.npz")["time"], np.zeros(8))


def npy() -> bytes:
    array = io.BytesIO()
    np.save(array, np.zeros(5))
    return array.getvalue()


WRONG = {
    "empty": b"",
    "text": b"time\n0.0\n",
    "one array": npy(),
    "encrypted": encrypted(),
    "too large to hold": with_header("(1000000000000000,)"),
    "too large to count": with_header("(9999999999999999999999999999999999999999,)"),
    "larger than it is": with_header("(999,)"),
    "smaller than it is": with_header("(3,)"),
    "no shape": with_header("(,)"),
    "no archive of arrays": archive_of(time=np.array([None])),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_what_is_no_archive_of_arrays_is_refused_on_one_line(wrong: str, tmp_path: Path) -> None:
    file = tmp_path / "flight.npz"
    file.write_bytes(WRONG[wrong])
    with pytest.raises(DamagedFileError, match=rf"^{file}: is damaged: .+$"):
        read_arrays(file)


@pytest.mark.parametrize("share", np.linspace(0.0, 0.999, 12))
def test_the_beginning_of_a_log_is_refused(share: float, kept: Path) -> None:
    log = kept / "flight.npz"
    log.write_bytes(log.read_bytes()[: int(share * log.stat().st_size)])
    with pytest.raises(DamagedFileError, match=f"^{log}"):
        Flight.load(kept)


def test_a_folder_in_the_place_of_a_log_is_an_error_of_the_system(kept: Path) -> None:
    (kept / "flight.npz").unlink()
    (kept / "flight.npz").mkdir()
    with pytest.raises(IsADirectoryError, match=r"flight\.npz"):
        Flight.load(kept)


def test_a_disk_that_fails_while_it_is_read_is_named(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class FailingDisk(io.BytesIO):
        def read(self, _size: int | None = -1, /) -> bytes:
            raise OSError(5, "Input/output error")  # as read() does it, without the file's name

    monkeypatch.setattr(Path, "open", lambda *_: FailingDisk())
    with pytest.raises(OSError, match=r"scenario\.yaml"):
        Flight.load(kept)


@pytest.mark.usefixtures("_scenario_read_once")
@pytest.mark.parametrize("kind", ["float32", "complex128", "int64", "bool", ">f8", "U8"])
def test_an_array_of_another_type_is_no_flight(kind: str, kept: Path) -> None:
    log = kept / "flight.npz"
    for name in array_names():
        made_up_flight().save(kept)
        rewrite(log, **{name: np.zeros(content(log)[name].shape, kind)})
        with pytest.raises(DamagedFileError, match=f"^{log}: {name} is .*, must be float64 of shape"):
            Flight.load(kept)


@pytest.mark.usefixtures("_scenario_read_once")
@pytest.mark.parametrize("shape", [(), (4,), (5, 1), (5, 2), (5, 4), (4, 3), (4, 6), (5, 3, 1), (0,), (1, 5)])
def test_an_array_of_another_shape_is_no_flight(shape: tuple[int, ...], kept: Path) -> None:
    log = kept / "flight.npz"
    for name in array_names():
        made_up_flight().save(kept)
        rewrite(log, **{name: np.zeros(shape)})
        with pytest.raises(DamagedFileError, match=f"^{log}: .* must be"):
            Flight.load(kept)


@pytest.mark.parametrize("name", [name for name in array_names() if name not in optional_names()])
def test_a_flight_without_one_of_its_arrays_is_refused(name: str, kept: Path) -> None:
    rewrite(kept / "flight.npz", **{name: None})
    with pytest.raises(DamagedFileError, match=f"{name} is missing"):
        Flight.load(kept)


@pytest.mark.parametrize(
    "time",
    [
        [0.02, 0.04, 0.06, 0.08, 0.1],
        [0.0, 0.02, 0.02, 0.06, 0.08],
        [0.0, 0.04, 0.02, 0.06, 0.08],
        [0.0, 0.02, np.nan, 0.06, 0.08],
        [0.0, 0.02, 0.04, 0.06, np.inf],
    ],
)
def test_time_starts_at_0_and_increases(time: list[float], kept: Path) -> None:
    rewrite(kept / "flight.npz", time=np.array(time))
    with pytest.raises(DamagedFileError, match="time must start at 0 and increase"):
        Flight.load(kept)


@pytest.mark.parametrize("damage", [b"\xff", b"[", b"mission: {radius: wide}", b"mission: {width: 1}"])
def test_a_damaged_scenario_names_its_file(damage: bytes, kept: Path) -> None:
    (kept / "scenario.yaml").write_bytes(damage)
    with pytest.raises(ValueError, match=rf"^{kept / 'scenario.yaml'}, line 1: [^\n]+$") as refused:
        Flight.load(kept)
    assert isinstance(refused.value, DamagedFileError | ScenarioError)


def test_a_flight_without_rotors_loads_as_it_was(tmp_path: Path) -> None:
    made_up_flight(rotor_speed=np.full((5, 6), np.nan)).save(tmp_path)
    assert not Flight.load(tmp_path).has_rotors


def test_a_flight_that_never_began_loads_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    scenario = Scenario().with_value("simulation.duration", 0.1)
    monkeypatch.setattr("a2s_drake.flight.run._read_state", interrupt)
    with pytest.raises(FlightInterrupted) as ended:
        run_flight(build_link_only(scenario), scenario)
    ended.value.flight.save(tmp_path)
    loaded = Flight.load(tmp_path)
    for name, columns in array_columns().items():
        assert getattr(loaded, name).shape == ((0,) if len(columns) == 1 else (0, len(columns)))
