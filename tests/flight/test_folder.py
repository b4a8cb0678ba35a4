"""What a run writes into its folder, by the library alone."""

from pathlib import Path

import pytest

from a2s_drake.common.files import ResultsError
from a2s_drake.flight.folder import PLAN, write_results
from tests.support.damage import full_disk
from tests.support.flights import made_up_flight


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_the_replay_is_written_by_whom_the_caller_names(tmp_path: Path) -> None:
    given = []

    def replay(flight, path: Path) -> None:
        given.append(flight)
        path.write_text("moving")

    flight = made_up_flight()
    write_results(flight, tmp_path / "new", csv=True, replay=replay)
    assert given == [flight]
    assert names(tmp_path / "new") == {"scenario.yaml", "flight.npz", "metrics.json", "flight.csv", "replay.html"}


def test_a_flight_without_a_sample_has_no_replay_and_no_metrics(tmp_path: Path) -> None:
    empty = {name: getattr(made_up_flight(), name)[:0] for name in ("time", "position", "snr_db")}
    write_results(made_up_flight(**empty), tmp_path, replay=lambda *_: pytest.fail("replayed"))
    assert names(tmp_path) == {"scenario.yaml", "flight.npz"}


def test_what_an_earlier_flight_left_goes(tmp_path: Path) -> None:
    write_results(made_up_flight(), tmp_path, csv=True, replay=lambda _, path: path.write_text("old"))
    (tmp_path / PLAN).write_text("of an earlier flight")
    write_results(made_up_flight("level"), tmp_path)
    assert names(tmp_path) == {"scenario.yaml", "flight.npz", "metrics.json"}


def test_a_replay_that_fails_leaves_the_flight_and_says_so(tmp_path: Path) -> None:
    def replay(_flight, _path) -> None:
        raise OSError("no Meshcat")

    with pytest.raises(ResultsError, match=rf"^no Meshcat; the flight itself is in {tmp_path}$"):
        write_results(made_up_flight(), tmp_path, replay=replay)
    assert names(tmp_path) == {"scenario.yaml", "flight.npz", "metrics.json"}


def test_a_full_disk_leaves_the_folder_as_it_was(tmp_path: Path) -> None:
    with full_disk(2000), pytest.raises(ResultsError, match=rf"File too large; {tmp_path} is as it was$"):
        write_results(made_up_flight(), tmp_path)
    assert names(tmp_path) == set()
