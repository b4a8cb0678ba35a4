import os
from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Scenario, ScenarioError
from a2s_drake.scenario import track_file
from a2s_drake.scenario.track_file import read_files, read_track
from diagrams import load_scenario

GOOD = "time,x,y,z\n0,1,2,3\n0.5,-1,2e0,3.5\n"


def mission_of(file: Path | str, field: str = "path_file"):
    return Scenario().with_value(f"mission.{field}", str(file)).mission


def read(tmp_path: Path, content: str | bytes, field: str = "path_file") -> tuple[np.ndarray, np.ndarray]:
    file = tmp_path / "track.csv"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_track(mission_of(file, field), field)


@pytest.mark.parametrize(
    "content",
    [
        GOOD,
        GOOD.rstrip(),
        GOOD + "\n  \n",
        GOOD.replace("\n", "\r\n"),
        "\ufeff" + GOOD,
        GOOD.replace(",", " , "),
        "\n" + GOOD,
        GOOD.replace("time", '"time"').replace("2e0", '"2"'),
    ],
    ids=["plain", "no last break", "blank lines", "crlf", "bom", "blanks", "blank first", "quotes"],
)
def test_a_track_is_read_however_a_spreadsheet_writes_it(content: str, tmp_path: Path) -> None:
    time, points = read(tmp_path, content)
    np.testing.assert_array_equal(time, [0.0, 0.5])
    np.testing.assert_array_equal(points, [[1.0, 2.0, 3.0], [-1.0, 2.0, 3.5]])


def test_a_ships_track_needs_no_z(tmp_path: Path) -> None:
    _, points = read(tmp_path, "time,x,y\n0,1,2\n1,3,4\n", "ship_track_file")
    np.testing.assert_array_equal(points, [[1.0, 2.0], [3.0, 4.0]])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "line 1: the header must be time,x,y,z, is ''"),
        ("0,1,2,3\n1,1,2,3\n", "line 1: the header must be time,x,y,z, is '0,1,2,3'"),
        ("time;x;y;z\n0;1;2;3\n", "line 1: the header must be time,x,y,z, is 'time;x;y;z'"),
        ("time,x,y\n0,1,2\n", "line 1: the header must be time,x,y,z, is 'time,x,y'"),
        ("time,y,x,z\n0,1,2,3\n", "line 1: the header must be time,x,y,z"),
        ("time,x,y,z\n", "line 1: must hold at least 2 rows of numbers, holds 0"),
        ("time,x,y,z\n0,1,2,3\n", "line 2: must hold at least 2 rows of numbers, holds 1"),
        ("time,x,y,z\n0,1,2,3\n1,1,2\n", "line 3: must hold 4 numbers (time,x,y,z), holds 3"),
        ("time,x,y,z\n0,1,2,3\n1,1,2,3,4\n", "line 3: must hold 4 numbers (time,x,y,z), holds 5"),
        ("time,x,y,z\n0,1,2,3\n\n1,far,2,3\n", "line 4: x must be a number of at most 1e+06 in magnitude, is 'far'"),
        ("time,x,y,z\n0,1,2,3\n1,,2,3\n", "line 3: x must be a number"),
        ("time,x,y,z\n0,1,2,nan\n", "line 2: z must be a number of at most 1e+06 in magnitude, is 'nan'"),
        ("time,x,y,z\n0,1,-inf,3\n", "line 2: y must be a number of at most 1e+06 in magnitude, is '-inf'"),
        ("time,x,y,z\n0,1_0,2,3\n", "line 2: x must be a number of at most 1e+06 in magnitude, is '1_0'"),
        ("time,x,y,z\n0,1,2,2e6\n", "line 2: z must be a number of at most 1e+06 in magnitude, is '2e6'"),
        ("time,x,y,z\n0,1,2,3\n1e5,1,2,3\n", "line 3: time must be a number of at most 86400 in magnitude, is '1e5'"),
        ("time,x,y,z\n1,1,2,3\n2,1,2,3\n", "line 2: time must start at 0, is 1.0"),
        ("time,x,y,z\n0,1,2,3\n1,1,2,3\n1,1,2,3\n", "line 4: time must increase by at least 1e-06 s, is 1.0 after 1.0"),
        ("time,x,y,z\n0,1,2,3\n2,1,2,3\n1,1,2,3\n", "line 4: time must increase by at least 1e-06 s, is 1.0 after 2.0"),
        (b"time,x,y,z\n0,1,2,3\n1,\xff,2,3\n", "line 3: must be UTF-8 text"),
        ("time,x,y,z\n0,1,2,3\n1," + "9" * 200_000 + ",2,3\n", "line 3: cannot be read as CSV: field larger than"),
    ],
)
def test_a_file_without_a_track_is_refused_in_one_line(content, words: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError) as refused:
        read(tmp_path, content)
    message = str(refused.value)
    assert message.startswith("mission.path_file = '")
    assert "track.csv': " + words in message
    assert "\n" not in message


def refusal(file: Path | str, field: str = "path_file") -> str:
    with pytest.raises(ScenarioError) as refused:
        read_files(mission_of(file, field))
    return str(refused.value)


def test_a_file_that_cannot_be_read_is_refused_by_name(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    expected = "mission.ship_track_file = 'missing.csv': No such file or directory"
    assert refusal("missing.csv", "ship_track_file") == expected
    assert refusal(tmp_path).endswith("Is a directory")
    assert refusal("/dev/zero").endswith("must be a regular file")
    os.mkfifo(tmp_path / "pipe")
    assert refusal(tmp_path / "pipe").endswith("must be a regular file")
    assert refusal("a\0b").endswith("the name is no file name")
    assert refusal("a" * 5000).endswith("File name too long")


def test_a_file_that_is_too_long_is_refused(tmp_path: Path, monkeypatch) -> None:
    with (tmp_path / "long.csv").open("wb") as file:
        file.truncate(track_file.MAX_BYTES + 1)
    assert refusal(tmp_path / "long.csv").endswith("must be at most 20 MB long")
    monkeypatch.setattr(track_file, "MAX_ROWS", 2)
    with pytest.raises(ScenarioError, match="line 4: a track must have at most 2 rows"):
        read(tmp_path, GOOD + "1,1,2,3\n")


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("mission.path_file=3", "must be a text, in quotes where it looks like a number, or null"),
        ("mission.path_file=[a.csv]", "must be a text, in quotes where it looks like a number, or null"),
        ("mission.ship_track_file=''", "mission.ship_track_file = '': must be the name of a file"),
        ('mission.path_file="a\\0b"', "must be the name of a file"),
    ],
)
def test_a_value_that_names_no_file_is_refused(override: str, words: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        Scenario().with_overrides([override]).validate()
    assert words in str(refused.value)


def test_a_name_may_be_set_and_taken_back() -> None:
    named = Scenario().with_overrides(["mission.path_file=my path.csv", "mission.ship_track_file='3'"])
    assert (named.mission.path_file, named.mission.ship_track_file) == ("my path.csv", "3")
    assert Scenario.from_yaml(named.to_yaml()) == named
    assert named.with_overrides(["mission.path_file=null", "mission.ship_track_file="]) == Scenario()


def test_names_in_a_scenario_file_are_relative_to_its_folder(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "mine").mkdir()
    file, absolute = tmp_path / "mine" / "mine.yaml", tmp_path / "elsewhere.csv"
    file.write_text(f"mission: {{path_file: data/path.csv, ship_track_file: {absolute}}}\n")
    for name in (str(file), "mine/mine.yaml", "../mine/mine.yaml"):
        monkeypatch.chdir(tmp_path if name == "mine/mine.yaml" else tmp_path / "mine")
        mission = load_scenario(name).mission
        assert Path(mission.path_file).resolve() == tmp_path / "mine" / "data" / "path.csv"
        assert mission.ship_track_file == str(absolute)
    # A name that is set goes by the working directory.
    assert load_scenario(str(file)).with_overrides(["mission.path_file=a.csv"]).mission.path_file == "a.csv"
    assert Scenario.from_yaml(file.read_text()).mission.path_file == "data/path.csv"


def test_a_saved_scenario_names_the_same_files(tmp_path: Path, monkeypatch) -> None:
    for folder in ("out", "data"):
        (tmp_path / folder).mkdir()
    monkeypatch.chdir(tmp_path)
    scenario = Scenario().with_overrides(["mission.path_file=data/path.csv", "mission.ship_track_file=/ship.csv"])
    scenario.save(Path("out/mine.yaml"))
    monkeypatch.chdir("/")
    again = Scenario.load(tmp_path / "out" / "mine.yaml").mission
    assert Path(again.path_file).resolve() == tmp_path / "data" / "path.csv"
    assert again.ship_track_file == "/ship.csv"


def test_the_names_in_the_header_may_be_written_large(tmp_path: Path) -> None:
    small, large = read(tmp_path, GOOD), read(tmp_path, GOOD.replace("time,x,y,z", "Time,X,Y,Z"))
    for mine, theirs in zip(large, small, strict=True):
        np.testing.assert_array_equal(mine, theirs)
