import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from a2s_drake import MpcController, Scenario, SolverStatus
from a2s_drake.common.signals import Fallback
from a2s_drake.control.horizon import Plan, Reference
from a2s_drake.control.ladder import Decision
from a2s_drake.vehicle.airframe import hover_input


class RecordingPlanner:
    """Decides whatever it is told, and remembers what it was asked."""

    def __init__(self, fallback: Fallback = Fallback.NONE) -> None:
        self.fallback = fallback
        self.asked: list[tuple[np.ndarray, Reference, Plan | None]] = []
        self.before: list[np.ndarray] = []

    def hover_plan(self, x0: np.ndarray) -> Plan:
        return Plan(np.tile(x0, (31, 1)), np.full((30, 6), 3800.0))

    def decide(self, x0: np.ndarray, reference: Reference, previous: Plan | None, before: np.ndarray) -> Decision:
        self.asked.append((x0, reference, previous))
        self.before.append(before.copy())
        count = len(self.asked)
        return Decision(Plan(np.full((31, 12), count), np.full((30, 6), 4000.0 + count)), self.fallback, count, 10.0)


def simulate(dut: MpcController, state: np.ndarray | None = None) -> Simulator:
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.GetInputPort("vehicle_state").FixValue(context, np.zeros(12) if state is None else state)
    dut.GetInputPort("position_preview").FixValue(context, np.zeros(93))
    dut.GetInputPort("attitude_preview").FixValue(context, np.zeros(93))
    return simulator


def status_of(dut: MpcController, simulator: Simulator) -> SolverStatus:
    return SolverStatus(dut.GetOutputPort("solver_status").Eval(simulator.get_context()))


def test_hover_is_the_answer_to_rest(scenario: Scenario) -> None:
    scenario.mpc.input_weight = 0.0  # with it the paper's cost trades 1.4 cm of height for thrust
    dut = MpcController(scenario.airframe, scenario.mpc)
    simulator = simulate(dut)
    simulator.Initialize()
    u = dut.GetOutputPort("rotor_speed_squared").Eval(simulator.get_context())
    np.testing.assert_allclose(u, hover_input(scenario.airframe), rtol=1e-3)
    status = status_of(dut, simulator)
    assert (status.success, status.fallback) == (1.0, 0.0)
    assert status.iterations > 0
    predicted = dut.GetOutputPort("predicted_state").Eval(simulator.get_context())
    assert predicted.shape == (12 * 31,)
    np.testing.assert_allclose(predicted, 0.0, atol=1e-3)


def test_output_at_the_start_is_already_a_decision(scenario: Scenario) -> None:
    dut = MpcController(scenario.airframe, scenario.mpc, RecordingPlanner())
    simulator = simulate(dut)
    simulator.Initialize()
    assert (dut.GetOutputPort("rotor_speed_squared").Eval(simulator.get_context()) == 4001.0).all()


def test_a_context_holds_its_plan(scenario: Scenario) -> None:
    dut = MpcController(scenario.airframe, scenario.mpc, RecordingPlanner())
    context, other = simulate(dut).get_context(), simulate(dut)
    other.Initialize()
    np.testing.assert_array_equal(dut.plan(context).input, np.full((30, 6), 3800.0))
    np.testing.assert_array_equal(dut.plan(other.get_context()).input, np.full((30, 6), 4001.0))
    np.testing.assert_array_equal(dut.plan(other.get_context()).state, np.ones((31, 12)))


def test_both_events_at_the_start_decide_once(scenario: Scenario) -> None:
    planner = RecordingPlanner()
    simulator = simulate(MpcController(scenario.airframe, scenario.mpc, planner))
    simulator.Initialize()
    simulator.AdvancePendingEvents()
    assert len(planner.asked) == 1
    simulator.AdvanceTo(0.021)
    assert len(planner.asked) == 2


def test_each_decision_gets_the_plan_before_it(scenario: Scenario) -> None:
    planner = RecordingPlanner()
    simulator = simulate(MpcController(scenario.airframe, scenario.mpc, planner))
    simulator.AdvanceTo(0.05)
    previous = [plan for _, _, plan in planner.asked]
    assert previous[0] is None
    assert previous[1] is not None
    assert previous[2] is not None
    assert (previous[1].input == 4001.0).all()
    assert (previous[2].input == 4002.0).all()
    assert (previous[2].state == 2.0).all()


def test_it_follows_a_pose_alone_unless_told(scenario: Scenario) -> None:
    dut = MpcController(scenario.airframe, scenario.mpc, RecordingPlanner())
    assert dut.num_input_ports() == 3
    reference = dut.reference(simulate(dut).get_context())
    assert not reference.state.any() and not reference.input.any()


def test_with_feedforward_it_follows_rates_and_inputs_too(scenario: Scenario, rng: np.random.Generator) -> None:
    planner = RecordingPlanner()
    dut = MpcController(scenario.airframe, scenario.mpc, planner, feedforward=True)
    simulator = simulate(dut)
    state, inputs = rng.normal(size=(31, 12)), rng.normal(size=(30, 6))
    names = ("position_preview", "attitude_preview", "velocity_preview", "angular_velocity_preview")
    values = [*np.split(state, 4, axis=1), inputs]
    for name, value in zip((*names, "rotor_speed_squared_preview"), values, strict=True):
        dut.GetInputPort(name).FixValue(simulator.get_mutable_context(), value.ravel())
    simulator.Initialize()
    asked = planner.asked[0][1]
    np.testing.assert_array_equal(asked.state, state)
    np.testing.assert_array_equal(asked.input, inputs)


def test_output_holds_between_samples(scenario: Scenario) -> None:
    dut = MpcController(scenario.airframe, scenario.mpc, RecordingPlanner())
    simulator = simulate(dut)
    seen = []
    for time in (0.0, 0.01, 0.0199, 0.0201, 0.039):
        simulator.AdvanceTo(time)
        seen.append(dut.GetOutputPort("rotor_speed_squared").Eval(simulator.get_context())[0])
    assert seen == [4001.0, 4001.0, 4001.0, 4002.0, 4002.0]


def test_plan_lives_in_the_context(scenario: Scenario) -> None:
    planner = RecordingPlanner()
    dut = MpcController(scenario.airframe, scenario.mpc, planner)
    first, second = simulate(dut), simulate(dut)
    first.AdvanceTo(0.05)
    second.Initialize()
    assert planner.asked[-1][2] is None
    assert (dut.GetOutputPort("rotor_speed_squared").Eval(first.get_context()) == 4003.0).all()


def test_previews_reach_the_planner_row_by_row(scenario: Scenario) -> None:
    planner = RecordingPlanner()
    dut = MpcController(scenario.airframe, scenario.mpc, planner)
    simulator = simulate(dut, state=np.arange(12.0))
    context = simulator.get_mutable_context()
    dut.GetInputPort("position_preview").FixValue(context, np.arange(93.0))
    dut.GetInputPort("attitude_preview").FixValue(context, -np.arange(93.0))
    simulator.Initialize()
    state, reference, _ = planner.asked[0]
    np.testing.assert_array_equal(state, np.arange(12.0))
    np.testing.assert_array_equal(reference.position[1], [3.0, 4.0, 5.0])
    np.testing.assert_array_equal(reference.attitude[30], [-90.0, -91.0, -92.0])


@pytest.mark.parametrize("fallback", list(Fallback))
def test_status_names_the_fallback(fallback: Fallback, scenario: Scenario) -> None:
    dut = MpcController(scenario.airframe, scenario.mpc, RecordingPlanner(fallback))
    simulator = simulate(dut)
    simulator.Initialize()
    status = status_of(dut, simulator)
    assert status.fallback == fallback
    assert status.success == (fallback is Fallback.NONE)
    assert (status.iterations, status.objective) == (1.0, 10.0)


def test_a_plan_shifted_to_its_end_is_dropped(scenario: Scenario) -> None:
    planner = RecordingPlanner(Fallback.SHIFTED_PLAN)
    simulator = simulate(MpcController(scenario.airframe, scenario.mpc, planner))
    simulator.AdvanceTo(0.02 * 35 + 0.01)
    dropped = [previous is None for _, _, previous in planner.asked]
    assert dropped == [True] + 29 * [False] + 6 * [True]


def test_hover_is_no_plan_to_go_on_with(scenario: Scenario) -> None:
    planner = RecordingPlanner(Fallback.HOVER)
    simulator = simulate(MpcController(scenario.airframe, scenario.mpc, planner))
    simulator.AdvanceTo(0.05)
    assert [previous is None for _, _, previous in planner.asked] == [True, True, True]


def test_rotor_speeds_depend_on_no_input_directly(scenario: Scenario) -> None:
    # Sampled state stands between every input and every output, so a loop through the plant is no algebraic loop.
    assert not MpcController(scenario.airframe, scenario.mpc, RecordingPlanner()).HasAnyDirectFeedthrough()


def test_each_decision_gets_the_measurement_before_it(scenario: Scenario) -> None:
    planner = RecordingPlanner()
    dut = MpcController(scenario.airframe, scenario.mpc, planner)
    simulator = simulate(dut, state=np.full(12, 1.0))
    for k, measured in enumerate((2.0, np.nan, 4.0)):
        simulator.AdvanceTo(0.02 * k + 0.01)
        dut.GetInputPort("vehicle_state").FixValue(simulator.get_mutable_context(), np.full(12, measured))
    simulator.AdvanceTo(0.07)
    np.testing.assert_array_equal([before[0] for before in planner.before], [np.nan, 1.0, 2.0, np.nan])
