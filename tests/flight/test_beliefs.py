"""Arrays that not every diagram gives: read from ports by their names, NaN without."""

from pathlib import Path

import numpy as np
import pytest

from a2s_drake import Flight, Scenario, WiringError, run_flight
from a2s_drake.common.files import DamagedFileError
from a2s_drake.flight.log import array_columns, array_names, optional_names
from diagrams import build_closed_loop, build_link_only
from tests.support.damage import content, rewrite
from tests.support.extended import FunctionOfTime, Sampled, extended_link
from tests.support.flights import made_up_flight

SCENARIO = Scenario().with_value("simulation.duration", 0.2)
TIMES = 0.02 * np.arange(11)
PORTS = {"ship_antenna_position": 3, "position_command": 3, "measured_state": 12, "phasor": 3, "force_estimate": 3}


def ramp(port: str, size: int) -> FunctionOfTime:
    """A port that shows t, 2 t, 3 t, and so on, each shifted by the length of its name."""
    return FunctionOfTime(port, size, lambda time: len(port) + time * np.arange(1, size + 1))


@pytest.mark.parametrize("port", PORTS)
def test_a_port_of_a_diagram_becomes_the_array_of_its_name(port: str) -> None:
    size = PORTS[port]
    flight = run_flight(extended_link(SCENARIO, ramp(port, size)), SCENARIO)
    np.testing.assert_allclose(getattr(flight, port), len(port) + np.outer(TIMES, np.arange(1, size + 1)), atol=1e-12)
    for name in optional_names() - {port, "position_command"}:
        assert np.isnan(getattr(flight, name)).all()


@pytest.mark.parametrize("build", [build_link_only, build_closed_loop])
def test_our_drawings_show_what_is_true_and_what_is_measured(build) -> None:
    scenario = SCENARIO.with_overrides(["simulation.duration=0.06", "mpc.horizon=5", "link.reflection_magnitude=0.7"])
    scenario = scenario.with_value("knowledge.ship_antenna_height_error", 0.31)
    flight = run_flight(build(scenario), scenario)
    np.testing.assert_allclose(flight.ship_antenna_position, flight.ship_position + np.array([0.0, 0.0, 10.31]))
    np.testing.assert_array_equal(flight.reflection_magnitude, 0.7)
    np.testing.assert_array_equal(flight.reflection_phase, np.pi)
    np.testing.assert_array_equal(flight.measured_state[:, :3], flight.position)


def test_reflection_is_a_magnitude_and_a_phase() -> None:
    flight = run_flight(
        extended_link(SCENARIO, FunctionOfTime("reflection", 2, lambda t: (0.5 + t, 3.0 - t))), SCENARIO
    )
    np.testing.assert_allclose(flight.reflection_magnitude, 0.5 + TIMES)
    np.testing.assert_allclose(flight.reflection_phase, 3.0 - TIMES)


def test_without_the_ports_all_is_nan_but_the_command_which_is_the_path() -> None:
    scenario = SCENARIO.with_overrides(["simulation.duration=0.06", "mpc.horizon=5"])
    flight = run_flight(extended_link(scenario), scenario)
    for name in optional_names() - {"position_command"}:
        values = getattr(flight, name)
        assert np.isnan(values).all()
        assert values.reshape(4, -1).shape[1] == len(array_columns()[name])
    np.testing.assert_array_equal(flight.position_command, flight.position_reference)


def test_what_a_decision_is_based_on_is_logged_not_what_comes_of_it() -> None:
    # A sampled block's update at t_k is not yet in what the controller decides on at t_k.
    period = SCENARIO.mpc.period
    dut = Sampled("phasor", period, lambda time: [time, 0.0, 0.0], [-1.0, 0.0, 0.0])
    flight = run_flight(extended_link(SCENARIO, dut), SCENARIO)
    np.testing.assert_allclose(flight.phasor[:, 0], [-1.0, *TIMES[:-1]], atol=1e-12)


def stamped(pattern: list[tuple[float, float]]) -> FunctionOfTime:
    """A receiver that shows (value, stamp) of each sample in turn."""
    return FunctionOfTime("snr_measurement", 2, lambda time: pattern[round(time / 0.02)])


def test_a_measurement_is_logged_where_it_is_first_delivered() -> None:
    nan = np.nan
    pattern = [(nan, nan), (nan, nan), (7.0, 0.0), (7.0, 0.0), (7.0, 0.04), (8.0, 0.06), (8.0, 0.06), (8.0, 0.06)]
    pattern += [(nan, 0.12), (9.0, 0.12), (9.0, 0.14)]
    flight = run_flight(extended_link(SCENARIO, stamped(pattern)), SCENARIO)
    expected = [nan, nan, 7.0, nan, 7.0, 8.0, nan, nan, nan, nan, 9.0]
    np.testing.assert_array_equal(flight.snr_measured_db, expected)


def test_each_flight_of_one_diagram_waits_for_its_own_first_measurement() -> None:
    diagram = extended_link(SCENARIO, stamped([(5.0, 0.0)] * 11))
    for _ in range(2):
        flight = run_flight(diagram, SCENARIO)
        np.testing.assert_array_equal(flight.snr_measured_db, [5.0] + 10 * [np.nan])


def test_an_observer_sees_the_beliefs_too() -> None:
    seen = []
    diagram = extended_link(SCENARIO, *(ramp(port, size) for port, size in PORTS.items()), stamped([(5.0, 0.0)] * 11))
    flight = run_flight(diagram, SCENARIO, observer=seen.append)
    for row, sample in enumerate(seen):
        for name in array_names():
            np.testing.assert_array_equal(sample[name], flight.sample(row)[name])


@pytest.mark.parametrize("port", [*PORTS, "reflection", "snr_measurement", "rotor_speed_squared", "solver_status"])
def test_a_port_of_another_size_is_refused_before_the_flight(port: str) -> None:
    seen: list[int] = []
    with pytest.raises(WiringError, match=rf"^extended \(Diagram\): output {port} has size 5, must have \d+$"):
        run_flight(extended_link(SCENARIO, ramp(port, 5)), SCENARIO, seen.append)
    assert seen == []


def test_a_flight_made_without_the_new_arrays_has_them_as_nan() -> None:
    flight = made_up_flight()
    for name in optional_names() - {"position_command"}:
        columns = array_columns()[name]
        assert getattr(flight, name).shape == ((5,) if len(columns) == 1 else (5, len(columns)))
        assert np.isnan(getattr(flight, name)).all()


def test_a_file_without_the_new_arrays_loads_with_nan(tmp_path: Path) -> None:
    made_up_flight().save(tmp_path)
    rewrite(tmp_path / "flight.npz", **dict.fromkeys(optional_names()))
    assert not optional_names() & set(content(tmp_path / "flight.npz"))
    loaded = Flight.load(tmp_path)
    for name in array_names():
        values = getattr(loaded, name)
        if name in optional_names():
            assert values.shape[0] == 5
            assert np.isnan(values).all()
        else:
            np.testing.assert_array_equal(values, getattr(made_up_flight(), name))


def test_the_new_arrays_are_saved_and_loaded_as_they_are(tmp_path: Path) -> None:
    diagram = extended_link(SCENARIO, *(ramp(port, size) for port, size in PORTS.items()), stamped([(5.0, 0.0)] * 11))
    flight = run_flight(diagram, SCENARIO)
    flight.save(tmp_path)
    loaded = Flight.load(tmp_path)
    for name in array_names():
        np.testing.assert_array_equal(getattr(loaded, name), getattr(flight, name))


def test_a_new_array_of_another_length_is_damage(tmp_path: Path) -> None:
    made_up_flight().save(tmp_path)
    rewrite(tmp_path / "flight.npz", phasor=np.zeros((4, 3)))
    with pytest.raises(
        DamagedFileError, match=r"phasor is float64 of shape \(4, 3\), must be float64 of shape \(5, 3\)"
    ):
        Flight.load(tmp_path)
