"""Flights with blocks of the user's own: whose name they go by, and what is said of rebuilding them."""

import json
import warnings
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from a2s_drake import Flight, Scenario, build_wired, compute_metrics, hover_input, run_flight
from a2s_drake.common.files import DamagedFileError
from a2s_drake.common.wiring import mark_own_blocks
from a2s_drake.flight.folder import write_results
from a2s_drake.study.store import FlightStore
from diagrams import Blocks, build_closed_loop, build_link_only
from scripts import flying
from tests.support.damage import content, rewrite
from tests.support.flights import made_up_flight

SCENARIO = Scenario().with_overrides(["simulation.duration=0.1", "mpc.horizon=5", "attitude_law.name=level"])
OWN = {"law": "MyLaw", "controller": "Hover"}


def marked(names: dict[str, str]) -> Diagram:
    diagram = build_link_only(SCENARIO)
    mark_own_blocks(diagram, names)
    return diagram


def hovering_loop(scenario: Scenario) -> Diagram:
    """A closed loop whose controller knows nothing but the speeds of hover: no solver, and no `solver_status`."""

    def hover(_: Scenario) -> Diagram:
        builder = DiagramBuilder()
        speeds = builder.AddSystem(ConstantVectorSource(hover_input(scenario.airframe)))
        builder.ExportOutput(speeds.get_output_port(), "rotor_speed_squared")
        return build_wired(builder, "Hover")

    return build_closed_loop(scenario, blocks=Blocks(controller=hover))


def test_a_flight_goes_by_the_name_of_its_own_law() -> None:
    dut = run_flight(marked(OWN), SCENARIO)
    assert (dut.law, dut.own_blocks, dut.rebuilds_from_scenario) == ("MyLaw", OWN, False)


@pytest.mark.parametrize("names", [{}, {"channel": "MyChannel"}])
def test_without_a_law_of_ones_own_it_goes_by_the_scenarios(names: dict[str, str]) -> None:
    dut = run_flight(marked(names), SCENARIO)
    assert (dut.law, dut.own_blocks, dut.rebuilds_from_scenario) == ("level", names, not names)


def test_own_blocks_are_saved_as_text_and_loaded(tmp_path: Path) -> None:
    own = {"law": "Gesetz ä", "path": "a b"}
    made_up_flight(own_blocks=own).save(tmp_path)
    with np.load(tmp_path / "flight.npz", allow_pickle=False) as archive:
        assert str(archive["own_block:law"]) == "Gesetz ä"
    loaded = Flight.load(tmp_path)
    assert (loaded.own_blocks, loaded.law) == (own, "Gesetz ä")


def test_a_flight_without_own_blocks_has_none_in_its_file(tmp_path: Path) -> None:
    made_up_flight().save(tmp_path)
    assert not [name for name in content(tmp_path / "flight.npz") if ":" in name]
    assert Flight.load(tmp_path).own_blocks == {}


@pytest.mark.parametrize("wrong", [np.zeros(3), np.array(["a", "b"]), np.array("two\nlines"), np.array(b"bytes")])
def test_a_name_that_is_no_line_of_text_is_damage(wrong: np.ndarray, tmp_path: Path) -> None:
    made_up_flight().save(tmp_path)
    rewrite(tmp_path / "flight.npz", **{"own_block:law": wrong})
    with pytest.raises(DamagedFileError, match=r"flight\.npz: own_block:law must be one line of text$"):
        Flight.load(tmp_path)


def test_metrics_and_summary_name_the_own_law() -> None:
    flight = made_up_flight(own_blocks=OWN)
    metrics = compute_metrics(flight)
    assert (metrics["law"], metrics["own_blocks"], metrics["rebuilds_from_scenario"]) == ("MyLaw", OWN, False)
    assert flying.summary(flight).startswith("MyLaw: ")
    metrics = compute_metrics(made_up_flight("level"))
    assert (metrics["law"], metrics["own_blocks"], metrics["rebuilds_from_scenario"]) == ("level", {}, True)


def test_who_writes_the_folder_says_that_the_scenario_does_not_rebuild_the_flight(tmp_path: Path) -> None:
    said = rf"^{tmp_path}/scenario\.yaml alone cannot rebuild this flight, .*: law = MyLaw, controller = Hover$"
    with pytest.warns(UserWarning, match=said) as warned:
        write_results(made_up_flight(own_blocks=OWN), tmp_path)
    assert len(warned) == 1
    written = json.loads((tmp_path / "metrics.json").read_text())
    assert (written["law"], written["rebuilds_from_scenario"]) == ("MyLaw", False)


def test_of_a_flight_of_the_scenario_alone_nothing_is_said(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        write_results(made_up_flight(), tmp_path)


def test_the_store_takes_no_flight_of_own_blocks_for_one_of_the_scenario(tmp_path: Path) -> None:
    store = FlightStore(tmp_path, "code")
    store.save(run_flight(build_closed_loop(SCENARIO), SCENARIO))
    assert store.find(SCENARIO) is not None
    diagram = build_closed_loop(SCENARIO)
    mark_own_blocks(diagram, OWN)
    store.save(run_flight(diagram, SCENARIO))
    with pytest.warns(UserWarning, match=r"flight\.npz: was flown with blocks that the scenario does not name"):
        assert store.find(SCENARIO) is None


def test_a_controller_without_a_solver_has_rotors() -> None:
    dut = run_flight(hovering_loop(SCENARIO), SCENARIO)
    assert dut.has_rotors
    assert not dut.has_solver
    speeds = np.tile(np.sqrt(hover_input(SCENARIO.airframe)), (6, 1))
    np.testing.assert_array_equal(dut.rotor_speed, speeds)
    for values in (dut.solver_success, dut.solver_iterations, dut.solver_fallback):
        np.testing.assert_array_equal(values, np.zeros(6))


def test_metrics_claim_nothing_of_a_solver_that_is_not_there() -> None:
    dut = compute_metrics(run_flight(hovering_loop(SCENARIO), SCENARIO))
    assert "rotor_speed" in dut["bounds"]
    assert dut["solver"]["present"] is False
    assert dut["solver"]["step_ms"] is None
    assert set(dut["solver"].pop("fallback_counts").values()) == {0}
    assert not any(dut["solver"].values())


def test_the_summary_says_that_there_is_no_solver() -> None:
    line = flying.summary(run_flight(hovering_loop(SCENARIO), SCENARIO))
    assert ", no solver, " in line
    assert "failures" not in line


def test_a_flight_with_a_solver_has_one_even_where_it_always_fails() -> None:
    failing = made_up_flight(solver_success=np.zeros(5), solver_fallback=np.full(5, 3.0))
    assert failing.has_solver
    dut = compute_metrics(failing)["solver"]
    assert (dut["present"], dut["failures"]) == (True, 5)
    assert dut["step_ms"] is not None
