"""Softened bounds give way only where they must: targets beyond them pull no harder than the penalties push."""

import numpy as np
import pytest

from a2s_drake import Scenario
from a2s_drake.control.horizon import Reference
from a2s_drake.control.program import state_bounds
from a2s_drake.control.solve import make_solver, solve_to_convergence
from tests.support.tracking import ROTOR_RANGE, hover_from, model_of


@pytest.mark.parametrize(
    ("entry", "start", "target"),
    [(0, 9.98, 10.02), (1, -9.98, -10.02), (3, 0.2, 0.6), (4, 0.2, 0.6), (5, 0.2, 0.6), (6, 0.9, 8.0), (11, 0.99, 9.0)],
)
def test_a_bound_that_can_be_kept_is_kept_though_it_is_soft(
    entry: int, start: float, target: float, scenario: Scenario
) -> None:
    x0, wanted = start * np.eye(12)[entry], target * np.eye(12)[entry]
    reference = Reference(np.tile(wanted, (31, 1)), np.zeros((30, 6)))
    dut = make_solver(model_of(scenario), scenario.airframe, scenario.mpc)
    guess = solve_to_convergence(dut, x0, reference, hover_from(scenario, x0)).plan
    assert guess is not None
    hard, soft = (dut.solve(x0, reference, guess, soft=soft).plan for soft in (False, True))
    assert hard is not None
    assert soft is not None
    bound = state_bounds(scenario.mpc)[target > 0.0][entry]
    assert np.abs(hard.state[1:, entry] - bound).min() < 1e-3  # The target does press against the bound.
    assert (np.sign(target) * (soft.state[:, entry] - bound)).max() < 1e-4
    np.testing.assert_allclose(soft.state, hard.state, atol=1e-3)
    np.testing.assert_allclose(soft.input[0], hard.input[0], atol=2e-3 * ROTOR_RANGE)


def test_iterations_of_all_calls_add_up(scenario: Scenario) -> None:
    x0, reference = np.zeros(12), Reference.of_pose(np.full((31, 3), 0.2), np.full((31, 3), 0.1))
    inner, counted = make_solver(model_of(scenario), scenario.airframe, scenario.mpc), []

    class Counting:
        def solve(self, *arguments: object, **options: object) -> object:
            solution = inner.solve(*arguments, **options)
            counted.append(solution.iterations)
            return solution

    total = solve_to_convergence(Counting(), x0, reference, hover_from(scenario, x0)).iterations
    assert len(counted) > 1
    assert total == sum(counted)
