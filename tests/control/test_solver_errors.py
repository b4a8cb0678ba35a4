"""An exception inside a solver: the vehicle flies on, and one warning tells of it."""

import re
import warnings

import numpy as np
import pytest
from pydrake.solvers import MathematicalProgram

from a2s_drake import Flight, FlightInterrupted, Scenario, run_flight
from a2s_drake.common.signals import Fallback
from a2s_drake.control.controller import MpcController
from a2s_drake.control.horizon import Plan, Reference
from a2s_drake.control.ladder import Planner
from a2s_drake.control.solve import Solution, TrackingSolver, make_solver
from a2s_drake.flight.log import array_names
from diagrams import Blocks, build_closed_loop
from tests.support.tracking import model_of

AT_REST = Reference.of_pose(np.zeros((31, 3)), np.zeros((31, 3)))


class Raising(TrackingSolver):
    """Does at its n-th call what the n-th error says: raises it, or fails quietly at None; then starts over."""

    def __init__(self, *errors: BaseException | None) -> None:
        self._errors, self.calls = errors, 0

    def solve(self, x0: np.ndarray, reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:  # noqa: ARG002
        error = self._errors[self.calls % len(self._errors)]
        self.calls += 1
        if error is not None:
            raise error
        return Solution(None, 0)


class Misspelt(TrackingSolver):
    def solve(self, x0: np.ndarray, reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:
        return soIve(x0, reference, guess, soft)  # noqa: F821 - what is tested


class FailsInDrake(TrackingSolver):
    def solve(self, x0: np.ndarray, reference: Reference, guess: Plan, *, soft: bool = False) -> Solution:  # noqa: ARG002
        prog = MathematicalProgram()
        rows = prog.AddLinearEqualityConstraint(np.eye(3), np.zeros(3), prog.NewContinuousVariables(3)).evaluator()
        rows.UpdateCoefficients(np.full((3, 3), np.nan), np.zeros(3))
        raise AssertionError("Drake took coefficients that are no numbers")


def decide(dut: Planner, times: int) -> list[str]:
    """Has a planner decide from rest; the warnings that come of it."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        for _ in range(times):
            assert dut.decide(np.zeros(12), AT_REST, None).fallback is Fallback.HOVER
    assert all(warning.category is UserWarning for warning in told)
    assert all(warning.filename == __file__ for warning in told)  # where `decide` is called
    return [str(warning.message) for warning in told]


def planner(scenario: Scenario, solver: TrackingSolver) -> Planner:
    return Planner(scenario.airframe, scenario.mpc, solver)


def test_a_misspelt_name_is_told_once_by_type_text_and_place(scenario: Scenario) -> None:
    (told,) = decide(planner(scenario, Misspelt()), 3)
    assert re.match(
        r"the solver raised NameError: name 'soIve' is not defined.* \(test_solver_errors\.py, line \d+\); ", told
    )


def test_an_assertion_that_fails_in_drake_is_told_as_an_exception(scenario: Scenario) -> None:
    (told,) = decide(planner(scenario, FailsInDrake()), 2)
    assert "the solver raised SystemExit: Failure at " in told


def test_each_type_and_line_is_told_once_and_on_one_line(scenario: Scenario) -> None:
    solver = Raising(ValueError("a\n  b"), KeyError("a"), ValueError("c"), RuntimeError("a b"), None)
    told = decide(planner(scenario, solver), 20)
    assert [text.partition(" (")[0] for text in told] == [
        f"the solver raised {error}" for error in ("ValueError: a b", "KeyError: 'a'", "RuntimeError: a b")
    ]
    assert not any("\n" in text for text in told)


def test_each_planner_tells_for_itself(scenario: Scenario) -> None:
    for _ in range(2):
        assert len(decide(planner(scenario, Raising(ValueError("no"))), 2)) == 1


@pytest.mark.parametrize("leaving", [KeyboardInterrupt(), SystemExit(), SystemExit(3)], ids=repr)
def test_whoever_wants_to_leave_may_leave(leaving: BaseException, scenario: Scenario) -> None:
    with pytest.raises(type(leaving)):
        planner(scenario, Raising(leaving)).decide(np.zeros(12), AT_REST, None)


def test_numbers_too_large_for_a_solver_are_told_by_the_fallback_alone(scenario: Scenario) -> None:
    dut = Planner(scenario.airframe, scenario.mpc)
    x0 = np.concatenate([np.zeros(9), np.full(3, 99.0)])  # turns at almost a hundred times its bound
    fast = Plan(np.full((31, 12), 1e200), np.full((30, 6), 4e3))
    solver = make_solver(model_of(scenario), scenario.airframe, scenario.mpc)
    with np.errstate(all="ignore"):
        assert solver.solve(np.zeros(12), AT_REST, fast) == Solution(None, 0)
    assert dut.decide(x0, AT_REST, None).plan.is_finite()


def flown(scenario: Scenario, solver: TrackingSolver) -> Flight:
    def controller(_: Scenario) -> MpcController:
        return MpcController(scenario.airframe, scenario.mpc, Planner(scenario.airframe, scenario.mpc, solver))

    return run_flight(build_closed_loop(scenario, blocks=Blocks(controller=controller)), scenario)


def test_a_flight_is_the_same_whether_or_not_it_was_warned_of(scenario: Scenario) -> None:
    short = scenario.with_value("simulation.duration", 0.2)
    with pytest.warns(UserWarning, match="the solver raised ValueError: no") as told:
        warned = flown(short, Raising(ValueError("no")))
    assert len(told) == 1
    quiet = flown(short, Raising(None))
    for name in array_names():
        np.testing.assert_array_equal(getattr(warned, name), getattr(quiet, name))


def test_an_interrupt_in_a_solver_ends_the_flight(scenario: Scenario) -> None:
    solver = Raising(*[None] * 7, KeyboardInterrupt())
    with pytest.raises(FlightInterrupted):
        flown(scenario.with_value("simulation.duration", 0.5), solver)
    assert solver.calls == 8
