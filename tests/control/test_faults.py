"""Never without an answer: the mission's loop, flown while something is wrong with it."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from a2s_drake import Flight, FlightEnded, Scenario, run_flight
from a2s_drake.common.signals import Fallback
from a2s_drake.common.wiring import find_block
from a2s_drake.control.horizon import Plan, Reference
from a2s_drake.control.ladder import Planner
from a2s_drake.control.solve import Solution, TrackingSolver, make_solver
from a2s_drake.guidance.path import uav_path
from diagrams import build_closed_loop, load_scenario
from tests.support.faults import Change, faulty_loop
from tests.support.tracking import model_of

START, END, RECOVERED = 1.0, 1.4, 2.4  # s; a second after the fault everything must be in order again


@pytest.fixture(params=["piqp", pytest.param("osqp", marks=pytest.mark.slow)])
def scenario(request: pytest.FixtureRequest) -> Scenario:
    overrides = ["simulation.duration=3.0", f"mpc.solver={request.param}"]
    return load_scenario("paper_calibrated").with_overrides(overrides).validate()


def during(flight: Flight) -> slice:
    """The samples at which the fault was there."""
    return slice(*np.searchsorted(flight.time, [START - 1e-9, END - 1e-9]))


def assert_answered_throughout(flight: Flight, scenario: Scenario) -> None:
    assert len(flight.time) == len(scenario.sample_times())
    assert flight.rotor_speed.min() >= scenario.airframe.rotor_speed_min - 1e-9
    assert flight.rotor_speed.max() <= scenario.airframe.rotor_speed_max + 1e-9
    np.testing.assert_array_equal(flight.solver_success, flight.solver_fallback == Fallback.NONE)
    before, after = flight.time < START - 1e-9, flight.time > RECOVERED + 1e-9
    assert (flight.solver_fallback[before] == Fallback.NONE).all()
    assert (flight.solver_fallback[after] == Fallback.NONE).all()


def replaced(index: int | slice, value: float) -> Change:
    def change(signal: np.ndarray) -> np.ndarray:
        signal[index] = value
        return signal

    return change


MEASURED = {
    "not a number": replaced(4, np.nan),
    "all not numbers": replaced(slice(0, 12), np.nan),
    "infinite": replaced(7, np.inf),
    "minus infinite": replaced(0, -np.inf),
    "a million kilometres off": replaced(slice(0, 3), 1e9),
    "sixty degrees of roll": replaced(3, 1.05),
    "upside down": replaced(3, np.pi),
    "upside down by pitch": replaced(4, np.pi),
    "at the Euler singularity": replaced(4, 0.5 * np.pi),
    "ten metres a second": replaced(slice(6, 9), 10.0),
    "eight turns a second": replaced(slice(9, 12), 50.0),
    "out of all bounds": replaced(slice(0, 12), 20.0),
}


@pytest.mark.parametrize("fault", MEASURED)
def test_a_wrong_measurement_is_ridden_out_on_the_plan(fault: str, scenario: Scenario) -> None:
    flight = run_flight(faulty_loop(scenario, START, END, vehicle_state=MEASURED[fault]), scenario)
    assert_answered_throughout(flight, scenario)
    assert (flight.solver_fallback[during(flight)] == Fallback.SHIFTED_PLAN).all()
    assert np.linalg.norm(flight.position - flight.position_reference, axis=1).max() < 0.1


@pytest.mark.parametrize("offset", [3.0, 50.0, 900.0])
def test_a_position_that_is_off_but_moves_as_it_should_is_believed_and_got_over(
    offset: float, scenario: Scenario
) -> None:
    # No measurement after the first betrays it. What the vehicle does about it stays within its bounds.
    flight = run_flight(faulty_loop(scenario, START, END, vehicle_state=lambda x: x + offset * np.eye(12)[0]), scenario)
    assert_answered_throughout(flight, scenario)
    assert flight.solver_fallback[during(flight)][0] == Fallback.SHIFTED_PLAN
    assert (flight.solver_fallback[during(flight)][1:] <= Fallback.SOFTENED).all()
    assert np.rad2deg(np.abs(flight.attitude).max()) < 16.5  # OSQP's answers are less exact out there
    assert np.abs(flight.velocity).max() < 2.0


@pytest.mark.parametrize("force", [1200.0, 1700.0])
def test_a_blow_is_believed_at_once_and_got_over(force: float, scenario: Scenario) -> None:
    # A blow of 20 ms that the controller sees nothing of but its effect: 4.7 and 6.6 m/s, below and above a surprise.
    overrides = [f"disturbance.gust_force=[0, {force}, 0]", "disturbance.gust_duration=0.02"]
    scenario = scenario.with_overrides([*overrides, "disturbance.gust_interval=1.6"])
    flight = run_flight(build_closed_loop(scenario), scenario)
    assert np.abs(flight.velocity[:, 1]).max() > 0.9 * force / 2.57 * 0.01
    assert (flight.solver_fallback == Fallback.SHIFTED_PLAN).sum() <= 2
    assert np.rad2deg(np.abs(flight.attitude).max()) < 25.0
    # 1.3 s later the vehicle is back within its bounds; close to them OSQP still needs a softened sample now and then.
    late = flight.solver_fallback[flight.time > 2.9]
    assert (late <= (Fallback.NONE if scenario.mpc.solver == "piqp" else Fallback.SOFTENED)).all()
    assert (late == Fallback.NONE).any()


TARGETS = {
    "a metre away": {"position_preview": lambda p: p + 1.0},
    "outside the operating region": {"position_preview": lambda p: p + 100.0},
    "on the moon": {"position_preview": lambda p: p + 4e8},
    "sixty degrees": {"attitude_preview": lambda eta: eta + 1.05},
    "many turns": {"attitude_preview": lambda eta: eta - 1e6},
    "beyond squaring": {"position_preview": lambda p: p + 1e200, "attitude_preview": lambda eta: eta - 1e200},
}


@pytest.mark.parametrize("fault", TARGETS)
def test_a_target_out_of_reach_is_approached_within_the_bounds(fault: str, scenario: Scenario) -> None:
    flight = run_flight(faulty_loop(scenario, START, END, **TARGETS[fault]), scenario)
    assert_answered_throughout(flight, scenario)
    # The box holds but for what a softened sample or two may give away, and the vehicle heads back.
    assert np.rad2deg(np.abs(flight.attitude).max()) < 15.5
    assert np.abs(flight.velocity).max() < 1.1
    late = flight.time > RECOVERED
    assert np.linalg.norm(flight.position - flight.position_reference, axis=1)[late].max() < 1.0


@pytest.mark.parametrize("port", ["position_preview", "attitude_preview"])
def test_a_target_that_is_no_number_is_ridden_out_on_the_plan(port: str, scenario: Scenario) -> None:
    flight = run_flight(faulty_loop(scenario, START, END, **{port: replaced(5, np.nan)}), scenario)
    assert_answered_throughout(flight, scenario)
    assert (flight.solver_fallback[during(flight)] == Fallback.SHIFTED_PLAN).all()


class FaultyForAWhile(TrackingSolver):
    """A sound solver that another stands in for between START and END; it tells the time by the planned position."""

    def __init__(self, scenario: Scenario, faulty: TrackingSolver) -> None:
        self._sound = make_solver(model_of(scenario), scenario.airframe, scenario.mpc)
        self._faulty, self._span = faulty, uav_path(scenario.mission).position(np.array([START, END]))[:, 1]

    def solve(self, x0: np.ndarray, reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:
        start, end = self._span - 1e-9
        solver = self._faulty if start <= reference.position[0, 1] < end else self._sound
        return solver.solve(x0, reference, guess, soft=soft)


class Raising(TrackingSolver):
    def __init__(self, error: BaseException) -> None:
        self._error = error

    def solve(self, x0: np.ndarray, reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:  # noqa: ARG002
        raise self._error


class Babbling(TrackingSolver):
    """Claims success with whatever comes."""

    def __init__(self, state: float, speed_squared: float) -> None:
        self._plan = Plan(np.full((31, 12), state), np.full((30, 6), speed_squared))

    def solve(self, x0: np.ndarray, reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:  # noqa: ARG002
        return Solution(self._plan, 1)


def stopped_early(scenario: Scenario) -> TrackingSolver:
    hasty = scenario.with_overrides(["mpc.qp_max_iterations=1"])
    return make_solver(model_of(hasty), hasty.airframe, hasty.mpc)


SOLVERS_AT_FAULT = {
    "stopped after one iteration": stopped_early,
    "raises": lambda _: Raising(RuntimeError("no")),
    "fails an assertion in C++": lambda _: Raising(SystemExit("condition failed")),
    "says not a number": lambda _: Babbling(np.nan, np.nan),
    "says infinite": lambda _: Babbling(0.0, np.inf),
}


def flown_with(faulty: TrackingSolver, scenario: Scenario) -> Flight:
    planner = Planner(scenario.airframe, scenario.mpc, FaultyForAWhile(scenario, faulty))
    return run_flight(faulty_loop(scenario, planner=planner), scenario)


@pytest.mark.parametrize("fault", SOLVERS_AT_FAULT)
@pytest.mark.filterwarnings("ignore:the solver raised")  # see test_solver_errors.py
def test_a_failing_solver_is_ridden_out_on_the_plan(fault: str, scenario: Scenario) -> None:
    flight = flown_with(SOLVERS_AT_FAULT[fault](scenario), scenario)
    assert_answered_throughout(flight, scenario)
    assert (flight.solver_fallback[during(flight)] == Fallback.SHIFTED_PLAN).all()
    assert np.linalg.norm(flight.position - flight.position_reference, axis=1).max() < 0.1


def test_a_solver_that_talks_nonsense_moves_no_rotor_out_of_bounds(scenario: Scenario) -> None:
    flight = flown_with(Babbling(0.0, -1e9), scenario)
    assert flight.rotor_speed[during(flight)] == pytest.approx(scenario.airframe.rotor_speed_min)
    assert flight.rotor_speed.min() >= scenario.airframe.rotor_speed_min - 1e-9


def test_beyond_the_plans_end_it_hovers_and_starts_afresh(scenario: Scenario) -> None:
    blind = faulty_loop(scenario, START, START + 1.0, vehicle_state=replaced(slice(0, 12), np.nan))
    flight = run_flight(blind, scenario)
    fallbacks = flight.solver_fallback[np.searchsorted(flight.time, START - 1e-9) :]
    assert (fallbacks[:30] == Fallback.SHIFTED_PLAN).all()
    assert (fallbacks[30:50] == Fallback.HOVER).all()
    assert (fallbacks[51:] == Fallback.NONE).all()


@pytest.mark.parametrize(
    "attitude_deg", [[180.0, 0.0, 0.0], [0.0, 90.0, 0.0], [0.0, 180.0, 0.0], [115.0, 30.0, 60.0]], ids=str
)
def test_a_vehicle_thrown_off_upright_rights_itself(attitude_deg: list[float], scenario: Scenario) -> None:
    # Not a wrong measurement: the vehicle is upside down, or at the singularity of its Euler angles, in mid-air.
    diagram = faulty_loop(scenario)
    plant = find_block(diagram, "plant")
    pose = RigidTransform(RollPitchYaw(np.deg2rad(attitude_deg)), np.zeros(3))
    plant.SetDefaultFloatingBaseBodyPose(plant.GetBodyByName("hexarotor"), pose)
    flight = run_flight(diagram, scenario)
    assert flight.solver_fallback[0] == Fallback.SOFTENED
    settled = flight.time > 2.2
    assert (flight.solver_fallback[settled] == Fallback.NONE).all()
    assert np.rad2deg(np.abs(flight.attitude[settled]).max()) < 15.1
    assert flight.rotor_speed.min() >= scenario.airframe.rotor_speed_min - 1e-9
    assert flight.rotor_speed.max() <= scenario.airframe.rotor_speed_max + 1e-9


def test_a_state_that_is_truly_lost_ends_the_flight_and_keeps_the_log(scenario: Scenario) -> None:
    crash = faulty_loop(scenario, START, END, rotor_speed_squared=lambda u: u * [1e40, 1, 1, 1, 1, 1])
    with pytest.raises(FlightEnded, match=r"the flight ended at t = 1\.0\d* s: the body turns at ") as ended:
        run_flight(crash, scenario)
    kept = ended.value.flight
    assert 50 <= len(kept.time) <= 52
    assert np.isfinite(kept.position).all()
