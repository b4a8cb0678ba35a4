import sys

import numpy as np
import pytest

from a2s_drake import Scenario
from a2s_drake.benchmark.casadi import CASADI_QP_SOLVERS, CasadiNlp, CasadiQp, require_casadi
from a2s_drake.control.program import LinearizedProgram
from a2s_drake.control.solve import PiqpQp, make_solver, solve_to_convergence
from a2s_drake.solvers.quadratic_form import QuadraticForm
from tests.support.tracking import ROTOR_RANGE, hover_from, model_of, reference_at

SAMPLES = (0, 194)


@pytest.fixture
def casadi() -> None:
    pytest.importorskip("casadi", reason="CasADi's solvers need the package casadi: pip install 'a2s_drake[bench]'")


@pytest.fixture
def tight(scenario: Scenario) -> Scenario:
    """Table I, its QP solved as well as can be."""
    return scenario.with_overrides(["mpc.qp_tolerance=1e-8"])


def pose(program: LinearizedProgram, scenario: Scenario, sample: int, rng: np.random.Generator) -> None:
    program.linearize(hover_from(scenario, rng.uniform(-0.1, 0.1, 12)))
    program.aim(reference_at(scenario, sample))


@pytest.mark.usefixtures("casadi")
@pytest.mark.parametrize("name", CASADI_QP_SOLVERS)
def test_casadis_qp_solvers_agree_with_piqp(name: str, tight: Scenario, rng: np.random.Generator) -> None:
    program = LinearizedProgram(model_of(tight), tight.airframe, tight.mpc)
    pose(program, tight, 100, rng)
    form, piqp = QuadraticForm(program.prog), PiqpQp(tight.mpc)
    dut = CasadiQp(name, form, tight.mpc.horizon)
    for sample in SAMPLES:  # Two in turn: the solver must take over every number of the second.
        pose(program, tight, sample, rng)
        assert form.refresh(program.prog)
        answer = dut.solve(form)
        expected = program.read(piqp.solve(program.prog, np.empty(0), soft=False).result)
        assert answer.solved
        assert answer.inner_seconds is None if name == "osqp" else 0.0 < answer.inner_seconds <= answer.seconds
        np.testing.assert_allclose(answer.plan.input[0], expected.input[0], atol=1e-3 * ROTOR_RANGE)
        np.testing.assert_allclose(answer.plan.state, expected.state, atol=1e-3)


@pytest.mark.usefixtures("casadi")
@pytest.mark.parametrize("name", CASADI_QP_SOLVERS)
def test_casadis_qp_solvers_say_when_there_is_no_solution(name: str, scenario: Scenario) -> None:
    scenario.mpc.horizon = 5
    program = LinearizedProgram(model_of(scenario), scenario.airframe, scenario.mpc)
    x0 = np.zeros(12)
    x0[6] = 1.5  # faster than the velocity bound allows
    program.linearize(hover_from(scenario, x0))
    program.aim(reference_at(scenario, 0))
    form = QuadraticForm(program.prog)
    assert not CasadiQp(name, form, scenario.mpc.horizon).solve(form).solved


@pytest.mark.usefixtures("casadi")
def test_hpipm_refuses_what_is_not_made_of_stages(scenario: Scenario) -> None:
    form = QuadraticForm(LinearizedProgram(model_of(scenario), scenario.airframe, scenario.mpc, soft=True).prog)
    with pytest.raises(ValueError, match="hard program"):
        CasadiQp("hpipm", form, scenario.mpc.horizon)


@pytest.mark.usefixtures("casadi")
@pytest.mark.parametrize("sample", SAMPLES)
def test_casadis_ipopt_agrees_with_the_converged_qp(
    sample: int, tight: Scenario, rng: np.random.Generator, capfd: pytest.CaptureFixture[str]
) -> None:
    x0 = rng.uniform(-0.1, 0.1, 12)
    reference, guess = reference_at(tight, sample), hover_from(tight, x0)
    answer = CasadiNlp(tight.airframe, tight.mpc).solve(x0, reference, guess)
    assert capfd.readouterr() == ("", "")
    solver = make_solver(model_of(tight), tight.airframe, tight.mpc)
    expected = solve_to_convergence(solver, x0, reference, guess, change=1e-5).plan
    assert expected is not None
    assert answer.solved
    np.testing.assert_allclose(answer.plan.input[0], expected.input[0], atol=1e-3 * ROTOR_RANGE)
    np.testing.assert_allclose(answer.plan.state, expected.state, atol=1e-4)


def test_a_missing_casadi_is_named(monkeypatch: pytest.MonkeyPatch, scenario: Scenario) -> None:
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'a2s_drake\[bench\]'"):
        require_casadi()
    with pytest.raises(ModuleNotFoundError, match="casadi"):
        CasadiNlp(scenario.airframe, scenario.mpc)
