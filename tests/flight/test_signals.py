"""Signals of the user's own: the values of ports anywhere in a diagram, and their names."""

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.common.value import AbstractValue
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput

from a2s_drake import Flight, FlightInterrupted, Scenario, WiringError, run_flight
from a2s_drake.common.files import DamagedFileError
from a2s_drake.common.wiring import find_block
from a2s_drake.flight.log import array_names
from a2s_drake.flight.signals import Signals
from diagrams import build_closed_loop, build_link_only
from tests.support.damage import content, rewrite
from tests.support.extended import FunctionOfTime, Sampled, extended_link, nested
from tests.support.flights import SAMPLES, made_up_flight

SCENARIO = Scenario().with_overrides(["simulation.duration=0.2", "mpc.horizon=5"])
PERIOD = SCENARIO.mpc.period
TIMES = PERIOD * np.arange(11)


def wave(port: str = "y", size: int = 2) -> FunctionOfTime:
    return FunctionOfTime(port, size, lambda time: np.sin(np.arange(1, size + 1) * time))


def test_a_block_deep_inside_shows_the_state_of_the_same_row() -> None:
    diagram = build_closed_loop(SCENARIO)
    plant = find_block(diagram, "plant")
    flight = run_flight(diagram, SCENARIO, log=[plant.GetOutputPort("state")])
    # A free body's state is its quaternion, its position, and its velocities in W.
    np.testing.assert_array_equal(flight.signals["plant.state"][:, 4:7], flight.position)
    np.testing.assert_array_equal(flight.signals["plant.state"][:, 10:13], flight.velocity)


def test_a_sampled_block_shows_what_holds_from_its_update_on() -> None:
    diagram = build_closed_loop(SCENARIO)
    mpc = find_block(diagram, "mpc")
    ports = [mpc.GetOutputPort(name) for name in ("rotor_speed_squared", "solver_status", "predicted_state")]
    flight = run_flight(diagram, SCENARIO, log=ports)
    np.testing.assert_allclose(flight.signals["mpc.rotor_speed_squared"], flight.rotor_speed**2, rtol=1e-14)
    np.testing.assert_array_equal(flight.signals["mpc.solver_status"][:, 1], flight.solver_iterations)
    # A plan decided at t_k starts from the state at t_k.
    np.testing.assert_allclose(flight.signals["mpc.predicted_state"][:, :3], flight.position, atol=1e-9)


def test_own_signals_agree_with_drakes_own_logger() -> None:
    # Drake's log is taken before the update at t_k, so that a sampled block lags by one row in it.
    held = Sampled("held", PERIOD, lambda time: [np.cos(time), time], [7.0, 7.0])
    builder = DiagramBuilder()
    inner = [
        builder.AddSystem(nested(block, "block", name)) for name, block in (("left", wave("wave")), ("right", held))
    ]
    link = builder.AddSystem(build_link_only(SCENARIO))
    for name in map(link.get_output_port, range(link.num_output_ports())):
        builder.ExportOutput(name, name.get_name())
    sinks = [LogVectorOutput(block.get_output_port(), builder, PERIOD) for block in inner]
    diagram = builder.Build()
    flight = run_flight(diagram, SCENARIO, log=[block.GetSystems()[0].get_output_port() for block in inner])
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.2)
    waved, sampled = (sink.FindLog(simulator.get_context()).data().T for sink in sinks)
    np.testing.assert_allclose(flight.signals["block.wave"], waved, atol=1e-12)
    np.testing.assert_allclose(flight.signals["block.held"][:-1], sampled[1:], atol=1e-12)
    np.testing.assert_allclose(flight.signals["block.held"], np.column_stack([np.cos(TIMES), TIMES]), atol=1e-12)


def test_logging_changes_no_array() -> None:
    diagram = build_closed_loop(SCENARIO)
    mpc = find_block(diagram, "mpc")
    plain, kept = run_flight(diagram, SCENARIO), run_flight(diagram, SCENARIO, log=[mpc.GetOutputPort("solver_status")])
    assert plain.signals == {}
    for name in array_names():
        np.testing.assert_array_equal(getattr(plain, name), getattr(kept, name))


def test_a_signal_has_a_row_a_sample_and_a_column_an_entry() -> None:
    diagram = extended_link(SCENARIO, inside={"wide": wave(size=7), "one": wave(size=1), "none": wave(size=0)})
    ports = [diagram.GetSubsystemByName(name).get_output_port() for name in ("wide", "one", "none")]
    flight = run_flight(diagram, SCENARIO, log=ports)
    shapes = {name: values.shape for name, values in flight.signals.items()}
    assert shapes == {"wide.y": (11, 7), "one.y": (11, 1), "none.y": (11, 0)}


def test_a_flight_that_never_began_has_signals_without_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("a2s_drake.flight.run._read_state", interrupt)
    diagram = build_link_only(SCENARIO)
    with pytest.raises(FlightInterrupted) as ended:
        run_flight(diagram, SCENARIO, log=[diagram.GetOutputPort("vehicle_state")])
    assert ended.value.flight.signals["vehicle_state"].shape == (0, 12)


def test_an_observer_sees_signals_by_their_names() -> None:
    seen = []
    diagram = build_link_only(SCENARIO)
    flight = run_flight(diagram, SCENARIO, log=[diagram.GetOutputPort("ship_position")], observer=seen.append)
    for row, sample in enumerate(seen):
        np.testing.assert_array_equal(sample["signals"]["ship_position"], flight.ship_position[row])
        np.testing.assert_array_equal(flight.sample(row)["signals"]["ship_position"], flight.ship_position[row])


def names_of(diagram, ports) -> list[str]:
    return list(Signals(diagram, ports).stacked([]))


def test_a_port_of_the_diagram_goes_by_its_own_name_a_blocks_by_both() -> None:
    dut = build_closed_loop(SCENARIO)
    airframe = find_block(dut, "airframe")
    ports = [dut.GetOutputPort("snr_db"), airframe.GetOutputPort("vehicle_state"), dut.GetOutputPort("vehicle_state")]
    assert names_of(dut, ports) == ["snr_db", "airframe.vehicle_state", "vehicle_state"]


def test_blocks_of_one_name_are_told_apart_by_those_around_them() -> None:
    left, right = (nested(nested(wave(), "block", "pair"), "pair", side) for side in ("left", "right"))
    dut = extended_link(SCENARIO, inside={"left": left, "right": right, "alone": wave()})
    ports = [side.GetSystems()[0].GetSystems()[0].get_output_port() for side in (left, right)]
    ports.append(dut.GetSubsystemByName("alone").get_output_port())
    assert names_of(dut, ports) == ["left.pair.block.y", "right.pair.block.y", "alone.y"]
    assert names_of(dut, ports[1:]) == ["block.y", "alone.y"]


def test_a_block_without_a_name_goes_by_its_class_and_the_next_by_a_number() -> None:
    blocks = [ConstantVectorSource([1.0]), ConstantVectorSource([2.0]), wave("odd\n\0port")]
    builder = DiagramBuilder()
    for block in blocks:
        builder.AddSystem(block)
    dut = builder.Build()
    names = names_of(dut, [block.get_output_port() for block in blocks])
    assert names == ["ConstantVectorSource.y0", "ConstantVectorSource.y0_2", "FunctionOfTime.odd__port"]


def test_a_port_given_twice_is_kept_once() -> None:
    dut = build_link_only(SCENARIO)
    assert names_of(dut, [dut.GetOutputPort("snr_db"), dut.GetOutputPort("snr_db")]) == ["snr_db"]


class Abstract(LeafSystem):
    """Puts out something that is no vector."""

    def __init__(self) -> None:
        LeafSystem.__init__(self)
        self.DeclareAbstractOutputPort("thing", lambda: AbstractValue.Make({}), lambda *_: None)


def test_what_cannot_be_logged_is_refused_before_the_flight() -> None:
    other = nested(wave("free"), "stranger", "elsewhere")
    diagram = extended_link(SCENARIO, inside={"odd": Abstract()})
    fine, seen = diagram.GetOutputPort("snr_db"), []
    for entry, kind, message in (
        (diagram.GetSubsystemByName("odd").get_output_port(), WiringError, "'odd.thing': is abstract, must be vector"),
        (other.GetSystems()[0].get_output_port(), WiringError, "'stranger.free': belongs to no block of the diagram "),
        (other.get_output_port(), WiringError, "'elsewhere.free': belongs to no block of the diagram 'extended'"),
        ("snr_db", TypeError, "'snr_db': must be an output port of the diagram or of a block in it"),
        (diagram.GetSubsystemByName("link"), TypeError, ".*: must be an output port of the diagram"),
    ):
        with pytest.raises(kind, match=rf"^log\[1\] = {message}") as refused:
            run_flight(diagram, SCENARIO, seen.append, log=[fine, entry])
        assert "\n" not in str(refused.value)
    assert seen == []


def test_a_log_that_is_no_list_is_refused_by_its_name() -> None:
    diagram = build_link_only(SCENARIO)
    block = find_block(diagram, "channel").GetOutputPort("snr_db")
    for log, shown in ((block, r"'channel\.snr_db'"), ("snr_db", "'snr_db'"), (None, "None"), (3, "3")):
        with pytest.raises(
            TypeError, match=rf"^log = {shown}: must be a list of output ports, \[port\] for a single one$"
        ):
            run_flight(diagram, SCENARIO, log=log)
    assert list(run_flight(diagram, SCENARIO, log=iter([block])).signals) == ["channel.snr_db"]


NAMES = st.text(st.characters(exclude_categories=("C", "Z")) | st.just(" "), max_size=20)
VALUES = st.integers(0, 3).flatmap(
    lambda width: st.lists(st.floats(width=64), min_size=SAMPLES * width, max_size=SAMPLES * width)
)


@given(
    st.dictionaries(NAMES | st.sampled_from(["time", "a/b", "../x", "x.npy", "file", "signal:", "a,b", '"']), VALUES)
)
def test_signals_of_any_printable_name_are_saved_loaded_and_listed_exactly(tmp_path_factory, named) -> None:
    folder: Path = tmp_path_factory.mktemp("kept")
    signals = {name: np.array(values).reshape(SAMPLES, -1) for name, values in named.items()}
    made_up_flight(signals=signals).save(folder)
    loaded = Flight.load(folder)
    assert set(loaded.signals) == set(signals)
    for name, values in signals.items():
        np.testing.assert_array_equal(loaded.signals[name], values)
    loaded.save_csv(folder / "flight.csv")
    with (folder / "flight.csv").open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert len(set(header)) == len(header) == len(made_up_flight().columns()) + sum(map(np.size, signals.values())) // 5
    table = dict(zip(header, np.array(rows, float).T, strict=True))
    for name, values in signals.items():
        for place, column in enumerate(values.T, 1):
            np.testing.assert_array_equal(table[f"{name}_{place}"], column)


@pytest.mark.parametrize("name", ["line\nbreak", "nul\0", "\ud800"])
def test_a_name_that_cannot_be_printed_is_refused_and_writes_nothing(name: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="must consist of characters that can be printed"):
        made_up_flight(signals={name: np.zeros((SAMPLES, 1))}).save(tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_signals_follow_a_prefix_in_the_file(tmp_path: Path) -> None:
    made_up_flight(signals={"mpc.cost": np.ones((SAMPLES, 2))}).save(tmp_path)
    np.testing.assert_array_equal(content(tmp_path / "flight.npz")["signal:mpc.cost"], np.ones((SAMPLES, 2)))


@pytest.mark.parametrize("wrong", [np.zeros(SAMPLES), np.zeros((4, 2)), np.zeros((SAMPLES, 2), int), np.zeros(())])
def test_a_damaged_signal_is_refused_by_name(wrong: np.ndarray, tmp_path: Path) -> None:
    made_up_flight().save(tmp_path)
    rewrite(tmp_path / "flight.npz", **{"signal:mine": wrong})
    with pytest.raises(DamagedFileError, match=r"signal:mine is .*, must be float64 of shape \(5, m\)"):
        Flight.load(tmp_path)
