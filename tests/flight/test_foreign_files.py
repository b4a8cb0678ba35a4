"""Saving a flight removes and overwrites copies that flights have written, and never a file of the user's own."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Flight, Scenario
from scripts import simulate
from tests.support.damage import content, rewrite
from tests.support.flights import made_up_flight
from tests.support.tracks import circle, write_track

TIME = np.linspace(0.0, 40.0, 201)
MINE = b"time,x,y,z\n0,0,0,0\n40,1,0,0\n"
OTHER = b"time,x,y,z\n0,0,0,0\n40,2,0,0\n"


def on_path(points: bytes | None) -> Flight:
    """A flight on a path from a file that held some bytes, or on none."""
    scenario = Scenario().with_value("mission.path_file", None if points is None else "elsewhere.csv")
    return replace(made_up_flight(), scenario=scenario, files={} if points is None else {"path_file": points})


def tracks_in(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.glob("*.csv")}


def flown_in(folder: Path) -> bytes:
    return Flight.load(folder).files["path_file"]


def test_a_file_that_no_flight_has_written_stays(tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_bytes(MINE)
    for _ in range(2):
        made_up_flight().save(tmp_path)
    # Neither does a scenario of the user's own make it a copy, with a log beside it or without.
    (tmp_path / "scenario.yaml").write_text("mission: {path_file: path.csv}\n")
    made_up_flight().save(tmp_path)
    (tmp_path / "flight.npz").unlink()
    (tmp_path / "scenario.yaml").write_text("mission: {path_file: path.csv}\n")
    made_up_flight().save(tmp_path)
    assert tracks_in(tmp_path) == {"path.csv": MINE}


def test_where_a_file_of_the_users_stands_the_copy_takes_the_next_free_name(tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_bytes(MINE)
    (tmp_path / "path_2.csv").write_bytes(b"mine too")
    on_path(OTHER).save(tmp_path)
    assert tracks_in(tmp_path) == {"path.csv": MINE, "path_2.csv": b"mine too", "path_3.csv": OTHER}
    assert "path_file: path_3.csv\n" in (tmp_path / "scenario.yaml").read_text()
    assert flown_in(tmp_path) == OTHER
    # The copy is known by its note, so the next flight takes its place, and one without a path removes it.
    on_path(OTHER + b"\n").save(tmp_path)
    assert tracks_in(tmp_path) == {"path.csv": MINE, "path_2.csv": b"mine too", "path_3.csv": OTHER + b"\n"}
    on_path(None).save(tmp_path)
    assert tracks_in(tmp_path) == {"path.csv": MINE, "path_2.csv": b"mine too"}


def test_a_file_of_the_users_that_was_flown_is_its_own_copy(tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_bytes(MINE)
    before = (tmp_path / "path.csv").stat()
    on_path(MINE).save(tmp_path)
    assert tracks_in(tmp_path) == {"path.csv": MINE}
    assert (tmp_path / "path.csv").stat().st_ino == before.st_ino
    assert flown_in(tmp_path) == MINE
    on_path(OTHER).save(tmp_path)
    assert tracks_in(tmp_path) == {"path.csv": MINE, "path_2.csv": OTHER}
    on_path(None).save(tmp_path)
    assert tracks_in(tmp_path) == {"path.csv": MINE}


def test_a_copy_that_was_edited_is_the_users(tmp_path: Path) -> None:
    on_path(MINE).save(tmp_path)
    (tmp_path / "path.csv").write_bytes(b"edited")
    on_path(MINE).save(tmp_path)
    assert tracks_in(tmp_path) == {"path.csv": b"edited", "path_2.csv": MINE}
    on_path(None).save(tmp_path)
    assert tracks_in(tmp_path) == {"path.csv": b"edited"}


def test_an_edited_copy_that_is_left_over_stays(tmp_path: Path) -> None:
    on_path(MINE).save(tmp_path)
    (tmp_path / "path.csv").write_bytes(b"edited")
    on_path(None).save(tmp_path)
    assert tracks_in(tmp_path) == {"path.csv": b"edited"}


def test_a_link_of_the_users_is_neither_followed_nor_removed(tmp_path: Path) -> None:
    (tmp_path / "precious.csv").write_bytes(MINE)
    on_path(MINE).save(tmp_path / "out")
    (tmp_path / "out" / "path.csv").unlink()
    (tmp_path / "out" / "path.csv").symlink_to(tmp_path / "precious.csv")
    on_path(OTHER).save(tmp_path / "out")
    on_path(None).save(tmp_path / "out")
    assert (tmp_path / "precious.csv").read_bytes() == MINE
    assert (tmp_path / "out" / "path.csv").is_symlink()


@pytest.mark.parametrize("name", ["../mine.csv", "mine.csv"])
def test_a_note_of_a_name_that_no_flight_chooses_is_not_believed(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    on_path(MINE).save(folder)
    (tmp_path / "mine.csv").write_bytes(MINE)
    (folder / "mine.csv").write_bytes(MINE)
    rewrite(folder / "flight.npz", **{f"copy:{name}": content(folder / "flight.npz")["copy:path.csv"]})
    on_path(None).save(folder)
    assert (tmp_path / "mine.csv").read_bytes() == MINE
    assert tracks_in(folder) == {"mine.csv": MINE}


def test_a_damaged_log_gives_no_file_away(tmp_path: Path) -> None:
    on_path(MINE).save(tmp_path)
    (tmp_path / "flight.npz").write_bytes(b"damaged")
    on_path(OTHER).save(tmp_path)
    assert tracks_in(tmp_path) == {"path.csv": MINE, "path_2.csv": OTHER}


def test_simulate_leaves_the_path_that_it_flies_where_it_lies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_track(tmp_path / "path.csv", TIME, circle(TIME, radius=2.0))
    mine = (tmp_path / "path.csv").read_bytes()
    assert simulate.main(["--set", "mission.path_file=path.csv", "--duration", "0.1", "--out", "."]) == 0
    assert simulate.main(["--duration", "0.1", "--out", "."]) == 0
    assert (tmp_path / "path.csv").read_bytes() == mine
