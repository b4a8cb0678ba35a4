"""A flight keeps the track files that its diagram was built with, not those that are on the disk when it flies."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.framework import Diagram

from a2s_drake import Flight, Scenario, ScenarioError, run_flight
from a2s_drake.common.wiring import mark_track_files, track_files
from a2s_drake.flight.log import array_names
from diagrams import build_link_only
from tests.support.extended import extended_link
from tests.support.tracks import circle, write_track

TIME = np.linspace(0.0, 40.0, 201)


@pytest.fixture
def scenario(tmp_path: Path) -> Scenario:
    """A short ideal flight on a path from a file."""
    path = write_track(tmp_path / "mine.csv", TIME, circle(TIME, radius=2.0))
    return Scenario().with_overrides([f"mission.path_file={path}", "simulation.duration=0.1"])


def noted(scenario: Scenario) -> Diagram:
    """A diagram that holds its builder's note of the file."""
    diagram = build_link_only(scenario)
    mark_track_files(diagram, {"path_file": Path(scenario.mission.path_file).read_bytes()})
    return diagram


def silent(diagram: Diagram) -> Diagram:
    """A diagram without the note of any builder."""
    vars(diagram).pop("a2s_track_files", None)
    return diagram


def test_a_diagram_says_only_what_its_builder_noted() -> None:
    dut = silent(build_link_only(Scenario()))
    assert track_files(dut) is None
    mark_track_files(dut, {})
    assert track_files(dut) == {}
    files = {"path_file": b"time"}
    mark_track_files(dut, files)
    files.clear()
    assert track_files(dut) == {"path_file": b"time"}


def test_a_diagram_around_another_was_built_from_the_same_files(scenario: Scenario) -> None:
    dut = extended_link(scenario)
    silent(dut.GetSubsystemByName("link"))
    assert track_files(dut) is None
    mark_track_files(dut.GetSubsystemByName("link"), {"path_file": b"inner"})
    assert track_files(dut) == {"path_file": b"inner"}
    mark_track_files(dut, {"path_file": b"outer"})
    assert track_files(dut) == {"path_file": b"outer"}


@pytest.mark.parametrize("later", ["other", "gone"])
def test_a_file_that_changes_before_take_off_is_kept_as_it_was_built(scenario, tmp_path: Path, later: str) -> None:
    diagram, file = noted(scenario), Path(scenario.mission.path_file)
    before = file.read_bytes()
    if later == "other":
        write_track(file, TIME, circle(TIME, radius=1.0))
    else:
        file.unlink()
    flight = run_flight(diagram, scenario)
    assert flight.files == {"path_file": before}
    flight.save(tmp_path / "out")
    assert (tmp_path / "out" / "path.csv").read_bytes() == before
    again = Flight.load(tmp_path / "out").scenario
    repeated = run_flight(build_link_only(again), again)
    for name in array_names():
        np.testing.assert_array_equal(getattr(repeated, name), getattr(flight, name), err_msg=name)


def test_a_note_of_a_file_that_the_scenario_does_not_name_is_left_out(scenario: Scenario) -> None:
    assert run_flight(noted(scenario), scenario.with_value("mission.path_file", None)).files == {}


def test_without_a_note_the_files_are_read_at_take_off(scenario: Scenario) -> None:
    diagram, file = silent(build_link_only(scenario)), Path(scenario.mission.path_file)
    assert run_flight(diagram, scenario).files == {"path_file": file.read_bytes()}
    file.unlink()
    with pytest.raises(ScenarioError, match=r"^mission.path_file = .*: No such file"):
        run_flight(diagram, scenario)
