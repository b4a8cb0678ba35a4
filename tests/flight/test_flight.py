import csv
import re
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput

from a2s_drake import Flight, FlightEnded, FlightInterrupted, Scenario, build_wired, run_flight
from a2s_drake.common.wiring import NamedWiring
from a2s_drake.control.controller import MpcController
from a2s_drake.flight.log import Sample, array_columns, array_names, array_units
from diagrams import Blocks, build_closed_loop, build_link_only, load_scenario
from tests.support.flights import made_up_flight


@pytest.fixture
def short(scenario: Scenario) -> Scenario:
    return scenario.with_overrides(["simulation.duration=0.5", "mpc.horizon=8"])


def shapes(flight: Flight) -> dict[str, tuple[int, ...]]:
    return {name: getattr(flight, name).shape for name in array_names()}


def test_a_flight_has_one_row_a_sample(short: Scenario) -> None:
    flight = run_flight(build_closed_loop(short), short)
    n = 26
    three = ("position", "attitude", "velocity", "angular_velocity")
    three += ("position_reference", "attitude_reference", "ship_position")
    three += ("ship_antenna_position", "position_command", "phasor", "force_estimate")
    wide = {"rotor_speed": (n, 6), "measured_state": (n, 12)}
    expected = {name: (n, 3) if name in three else (n,) for name in array_names()} | wide
    assert shapes(flight) == expected
    np.testing.assert_allclose(flight.time, 0.02 * np.arange(n), atol=1e-15)
    assert flight.wall_clock is not None
    assert flight.wall_clock.step.shape == (n,)


def test_row_k_holds_the_state_before_and_the_input_after_the_update(short: Scenario) -> None:
    # Replayed by the prediction model, the logged inputs must lead from each logged state to the next.
    flight = run_flight(build_closed_loop(short), short)
    model = MpcController(short.airframe, short.mpc)._planner.model
    state = np.hstack([flight.position, flight.attitude, flight.velocity, flight.angular_velocity])
    following = model.step(state[:-1], flight.rotor_speed[:-1] ** 2, short.mpc.period)
    np.testing.assert_allclose(following, state[1:], atol=1e-6)
    late = model.step(state[1:-1], flight.rotor_speed[:-2] ** 2, short.mpc.period)
    assert np.abs(late - state[2:]).max() > 1e-4


def test_log_agrees_with_drakes_own_logger(short: Scenario) -> None:
    # LogVectorOutput publishes at t_k before the update there, so its inputs lag the flight's by one row.
    builder = DiagramBuilder()
    loop = builder.AddSystem(build_closed_loop(short))
    period = short.mpc.period
    sinks = {name: LogVectorOutput(loop.GetOutputPort(name), builder, period) for name in ("vehicle_state", "snr_db")}
    outer = builder.Build()

    simulator = Simulator(outer)
    simulator.get_mutable_integrator().set_fixed_step_mode(True)
    simulator.get_mutable_integrator().set_maximum_step_size(short.simulation.max_step_size)
    simulator.AdvanceTo(0.5)
    flight = run_flight(build_closed_loop(short), short)
    logged = {name: sink.FindLog(simulator.get_context()).data() for name, sink in sinks.items()}
    np.testing.assert_allclose(logged["vehicle_state"][:3].T, flight.position, atol=1e-9)
    np.testing.assert_allclose(logged["snr_db"][0], flight.snr_db, atol=1e-6)


def test_an_ideal_flight_has_no_rotors(short: Scenario) -> None:
    flight = run_flight(build_link_only(short), short)
    assert not flight.has_rotors
    assert np.isnan(flight.rotor_speed).all()


def test_save_and_load_are_exact(short: Scenario, tmp_path: Path) -> None:
    flight = run_flight(build_closed_loop(short), short)
    flight.save(tmp_path)
    loaded = Flight.load(tmp_path)
    assert loaded.scenario == short
    assert loaded.wall_clock is None
    for name in array_names():
        np.testing.assert_array_equal(getattr(loaded, name), getattr(flight, name))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["flight.npz", "scenario.yaml"]


def test_one_diagram_flies_many_times_alike(short: Scenario) -> None:
    diagram = build_closed_loop(short)
    first, second = (run_flight(diagram, short) for _ in range(2))
    for name in array_names():
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_progress_counts_samples(short: Scenario) -> None:
    steps: list[int] = []
    run_flight(build_link_only(short), short, steps.append)
    assert sum(steps) == 26


class Saboteur(LeafSystem):
    """Passes rotor commands through until a time, and then something else."""

    def __init__(self, time: float, action) -> None:
        LeafSystem.__init__(self)
        self._command = self.DeclareVectorInputPort("command", 6)
        self._time, self._action = time, action
        self.DeclareVectorOutputPort("sabotaged", 6, self._calc_sabotaged)

    def _calc_sabotaged(self, context, output) -> None:
        late = context.get_time() >= self._time
        output.SetFromVector(self._action() if late else self._command.Eval(context))


def sabotaged_loop(scenario: Scenario, time: float, action) -> Diagram:
    def controller(_: Scenario) -> Diagram:
        builder = DiagramBuilder()
        wiring = NamedWiring(builder)
        wiring.add("mpc", MpcController(scenario.airframe, scenario.mpc))
        port = "rotor_speed_squared"
        wiring.add("saboteur", Saboteur(time, action), {"command": port}, {"sabotaged": port})
        wiring.export()
        return build_wired(builder, "sabotaged")

    return build_closed_loop(scenario, blocks=Blocks(controller=controller))


@pytest.mark.parametrize(
    ("thrust", "reason"),
    [
        (np.nan, r"Spatial force applied on body hexarotor contains NaN"),  # Drake's own guard
        (1e20, r"the body turns at \d\.\d*e\+15 rad/s, more than half a turn in an integration step of 0\.01 s"),
        (1e170, r"the vehicle's state overflowed in integration steps of 0\.01 s"),
    ],
)
def test_a_state_that_is_not_finite_ends_the_flight_and_keeps_the_log(thrust, reason, short: Scenario) -> None:
    diagram = sabotaged_loop(short, 0.2, lambda: np.full(6, thrust) * [1, 2, 3, 4, 5, 6])
    with pytest.raises(FlightEnded, match=rf"the flight ended at t = 0\.2\d* s: {reason}") as ended:
        run_flight(diagram, short)
    kept = ended.value.flight
    assert 10 <= len(kept.time) <= 11
    assert np.isfinite(kept.position).all()


def test_an_interrupt_keeps_the_log(short: Scenario) -> None:
    def interrupt() -> np.ndarray:
        raise KeyboardInterrupt

    with pytest.raises(FlightInterrupted, match=r"interrupted at t = 0\.") as ended:
        run_flight(sabotaged_loop(short, 0.2, interrupt), short)
    assert 10 <= len(ended.value.flight.time) <= 11


def test_other_errors_are_not_swallowed(short: Scenario) -> None:
    def fail() -> np.ndarray:
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        run_flight(sabotaged_loop(short, 0.2, fail), short)


def test_an_observer_sees_each_sample_and_changes_nothing() -> None:
    scenario = load_scenario("paper").with_value("simulation.duration", 0.3)
    diagram, seen = build_link_only(scenario), []
    watched = run_flight(diagram, scenario, observer=seen.append, target_realtime_rate=1.0)
    unwatched = run_flight(diagram, scenario)
    assert watched.wall_clock.total >= 0.29
    assert len(seen) == len(watched.time)
    for name in array_names():
        np.testing.assert_array_equal(getattr(watched, name), getattr(unwatched, name))
        for row, sample in enumerate(seen):
            np.testing.assert_array_equal(sample[name], watched.sample(row)[name])


@pytest.mark.parametrize("watcher", ["progress", "observer"])
@pytest.mark.parametrize("kind", [RuntimeError, FloatingPointError, ZeroDivisionError])
def test_an_error_of_a_watcher_is_not_the_flights_end(watcher: str, kind: type[Exception], short: Scenario) -> None:
    calls = []

    def fail(_: object) -> None:
        calls.append(True)
        if len(calls) == 3:
            raise kind("my own bug")

    with pytest.raises(kind, match=r"^my own bug$") as caught:
        run_flight(build_link_only(short), short, **{watcher: fail})
    assert caught.type is kind
    assert len(calls) == 3


def test_a_watchers_interrupt_keeps_the_log(short: Scenario) -> None:
    def interrupt(sample: Sample) -> None:
        if sample["time"] > 0.19:
            raise KeyboardInterrupt

    with pytest.raises(FlightInterrupted, match=r"interrupted at t = 0\.20 s") as ended:
        run_flight(build_link_only(short), short, observer=interrupt)
    assert len(ended.value.flight.time) == 11


def table_of(path: Path) -> dict[str, np.ndarray]:
    """A CSV file by Python's own reader, columns by name."""
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return {name: np.array([float(row[place]) for row in rows]) for place, name in enumerate(header)}


def test_csv_holds_every_value_exactly(short: Scenario, tmp_path: Path) -> None:
    run_flight(build_closed_loop(short), short).save(tmp_path)
    flight = Flight.load(tmp_path)
    flight.save_csv(tmp_path / "new" / "flight.csv")
    table = table_of(tmp_path / "new" / "flight.csv")
    for name, columns in array_columns().items():
        logged = getattr(flight, name).reshape(26, -1)
        np.testing.assert_array_equal(np.column_stack([table.pop(column) for column in columns]), logged)
    assert table == {}
    assert [p.name for p in (tmp_path / "new").iterdir()] == ["flight.csv"]


def test_csv_header_names_quantity_axis_and_unit() -> None:
    assert list(made_up_flight().columns()) == [
        "time_s",
        *("position_x_m", "position_y_m", "position_z_m"),
        *("roll_rad", "pitch_rad", "yaw_rad"),
        *("velocity_x_m_per_s", "velocity_y_m_per_s", "velocity_z_m_per_s"),
        *("angular_velocity_x_rad_per_s", "angular_velocity_y_rad_per_s", "angular_velocity_z_rad_per_s"),
        *("rotor_speed_1_hz", "rotor_speed_2_hz", "rotor_speed_3_hz"),
        *("rotor_speed_4_hz", "rotor_speed_5_hz", "rotor_speed_6_hz"),
        *("position_reference_x_m", "position_reference_y_m", "position_reference_z_m"),
        *("roll_reference_rad", "pitch_reference_rad", "yaw_reference_rad"),
        *("ship_position_x_m", "ship_position_y_m", "ship_position_z_m"),
        *("channel_gain", "snr_db", "spectral_efficiency_bit_per_s_per_hz", "phase_difference_rad"),
        *("solver_success", "solver_iterations", "solver_fallback"),
        *("ship_antenna_position_x_m", "ship_antenna_position_y_m", "ship_antenna_position_z_m"),
        *("reflection_magnitude", "reflection_phase_rad"),
        *("position_command_x_m", "position_command_y_m", "position_command_z_m"),
        "snr_measured_db",
        *("measured_position_x_m", "measured_position_y_m", "measured_position_z_m"),
        *("measured_roll_rad", "measured_pitch_rad", "measured_yaw_rad"),
        *("measured_velocity_x_m_per_s", "measured_velocity_y_m_per_s", "measured_velocity_z_m_per_s"),
        *("measured_angular_velocity_x_rad_per_s", "measured_angular_velocity_y_rad_per_s"),
        "measured_angular_velocity_z_rad_per_s",
        *("phasor_a", "phasor_b", "phasor_c"),
        *("force_estimate_x_n", "force_estimate_y_n", "force_estimate_z_n"),
    ]


def test_csv_of_a_flight_without_rotors_reads_nan(short: Scenario, tmp_path: Path) -> None:
    flight = run_flight(build_link_only(short), short)
    flight.save_csv(tmp_path / "flight.csv")
    table = table_of(tmp_path / "flight.csv")
    assert all(np.isnan(table[f"rotor_speed_{i}_hz"]).all() for i in range(1, 7))
    np.testing.assert_array_equal(table["snr_db"], flight.snr_db)


def test_csv_of_a_flight_that_never_began_is_its_header(tmp_path: Path) -> None:
    full = made_up_flight()
    empty = Flight(full.scenario, **{name: np.array([]) for name in array_names()})
    empty.save_csv(tmp_path / "flight.csv")
    assert (tmp_path / "flight.csv").read_text().splitlines() == [",".join(full.columns())]


def test_csv_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch) -> None:
    made_up_flight().save_csv(tmp_path / "flight.csv")
    before = (tmp_path / "flight.csv").read_bytes()

    class Breaking:
        def __init__(self, file, **_) -> None:
            self.file = file

        def writerow(self, _) -> None:
            self.file.write("half a")
            raise KeyboardInterrupt

    monkeypatch.setattr(csv, "writer", Breaking)
    with pytest.raises(KeyboardInterrupt):
        made_up_flight().save_csv(tmp_path / "flight.csv")
    assert (tmp_path / "flight.csv").read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["flight.csv"]


def test_the_docstring_states_shape_and_unit_of_every_array() -> None:
    documented = re.findall(r"^ +(\w+): (.*), shape \((n,|n, \d+)\)", Flight.__doc__ or "", re.MULTILINE)
    flight = made_up_flight()
    assert [name for name, _, _ in documented] == array_names()
    for name, text, shape in documented:
        width = {"n,": 1, "n, 3": 3, "n, 6": 6, "n, 12": 12}[shape]
        assert getattr(flight, name).size == width * len(flight.time)
        assert {*(array_units()[name] or "dimensionless").split(", ")} <= {*text.split(", ")}
