"""The nonlinear program where its dynamics overflow: IPOPT must see large numbers, never infinite ones."""

import numpy as np
import pytest
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff

from a2s_drake import Scenario
from a2s_drake.control.program import NonlinearProgram
from tests.support.tracking import model_of


@pytest.mark.parametrize("size", [1e60, 1e120, 1e300])
def test_dynamics_that_overflow_are_finite_for_ipopt(size: float, scenario: Scenario) -> None:
    model = model_of(scenario)
    dut = NonlinearProgram(model, scenario.airframe, scenario.mpc).prog.generic_constraints()[0].evaluator()
    values = np.full(30, size)
    with np.errstate(all="ignore"):
        assert not np.isfinite(model.step(values[:12], values[12:18], 0.02)).all()
        assert np.isfinite(dut.Eval(values)).all()
        taped = dut.Eval(InitializeAutoDiff(values))
        assert np.isfinite(ExtractGradient(taped)).all()
