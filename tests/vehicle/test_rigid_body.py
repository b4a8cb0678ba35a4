import numpy as np
import pytest
from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff
from pydrake.math import RollPitchYaw_, RotationMatrix_
from pydrake.systems.framework import Diagram

from a2s_drake import Airframe, Scenario
from a2s_drake.vehicle.airframe import hover_input
from a2s_drake.vehicle.rigid_body import RigidBodyModel
from diagrams import build_airframe_only


def plant_derivative(taped: Diagram, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """x_dot of the 12-state by the MultibodyPlant in AutoDiffXd, mapped with Drake's own Euler kinematics."""
    T = type(x[0])
    context = taped.CreateDefaultContext()
    taped.GetInputPort("rotor_speed_squared").FixValue(context, u)
    rpy = RollPitchYaw_[T](x[3:6])
    R_WB = RotationMatrix_[T](rpy)
    w_WB_W = R_WB.multiply(x[9:12])
    continuous = np.concatenate([R_WB.ToQuaternion().wxyz(), x[0:3], w_WB_W, x[6:9]])
    context.SetContinuousState(continuous)
    slope = taped.EvalTimeDerivatives(context).CopyToVector()
    acceleration, angular_acceleration_W = slope[10:13], slope[7:10]
    eta_dot = rpy.CalcRpyDtFromAngularVelocityInParent(w_WB_W)
    # The transport term w x w vanishes, so rotating the world derivative gives the derivative in the body frame.
    return np.concatenate([slope[4:7], eta_dot.ravel(), acceleration, R_WB.inverse().multiply(angular_acceleration_W)])


@pytest.mark.parametrize("tilt_deg", [20.0, 35.0])
def test_model_and_jacobians_are_the_plants(tilt_deg: float, scenario: Scenario, rng: np.random.Generator) -> None:
    scenario.airframe.tilt_deg = tilt_deg
    taped = build_airframe_only(scenario).ToAutoDiffXd()
    dut = RigidBodyModel.of(scenario.airframe)
    for _ in range(100):
        x = rng.uniform(-1.0, 1.0, 12) * np.repeat([5.0, 1.2, 2.0, 3.0], 3)
        u = rng.uniform(256.0, 1e4, 6)
        tape = InitializeAutoDiff(np.concatenate([x, u])).ravel()
        result = plant_derivative(taped, tape[:12], tape[12:])
        value, gradient = ExtractValue(result).ravel(), ExtractGradient(result)
        by_state, by_input = dut.jacobians(x, u)
        for mine, drakes in (
            (dut.derivative(x, u), value),
            (by_state, gradient[:, :12]),
            (by_input, gradient[:, 12:]),
        ):
            assert np.abs(mine - drakes).max() <= 1e-9 * np.abs(drakes).max()


def test_hover_is_an_equilibrium() -> None:
    dut = RigidBodyModel.of(Airframe())
    np.testing.assert_allclose(dut.derivative(np.zeros(12), hover_input(Airframe())), 0.0, atol=1e-12)


def test_step_derivative_is_the_slope_of_the_step(rng: np.random.Generator) -> None:
    dut = RigidBodyModel.of(Airframe())
    x, u = rng.uniform(-0.5, 0.5, (4, 12)), rng.uniform(256.0, 1e4, (4, 6))
    reached, slope = dut.linearized_step(x, u, 0.02)
    np.testing.assert_allclose(reached, dut.step(x, u, 0.02), rtol=1e-13, atol=1e-15)
    for column, size in enumerate([1e-6] * 12 + [1e-2] * 6):
        nudge = size * np.eye(18)[column]
        ahead, behind = (dut.step(x + sign * nudge[:12], u + sign * nudge[12:], 0.02) for sign in (1.0, -1.0))
        np.testing.assert_allclose(slope[..., column], (ahead - behind) / (2.0 * size), rtol=1e-6, atol=1e-9)


def test_step_converges_at_fourth_order(rng: np.random.Generator) -> None:
    dut = RigidBodyModel.of(Airframe())
    x, u = rng.uniform(-0.5, 0.5, 12), rng.uniform(256.0, 1e4, 6)

    def after(steps: int) -> np.ndarray:
        return dut.rollout(x, np.tile(u, (steps, 1)), 0.4 / steps)[-1]

    exact = after(2048)
    coarse, fine = (np.abs(after(steps) - exact).max() for steps in (16, 32))
    assert coarse / fine == pytest.approx(16.0, rel=0.25)


def test_batches_agree_with_single_calls(rng: np.random.Generator) -> None:
    dut = RigidBodyModel.of(Airframe())
    x, u = rng.uniform(-0.5, 0.5, (5, 12)), rng.uniform(256.0, 1e4, (5, 6))
    reached, slope = dut.linearized_step(x, u, 0.02)
    for i in range(5):
        single, single_slope = dut.linearized_step(x[i], u[i], 0.02)
        np.testing.assert_allclose(single, reached[i], rtol=1e-13, atol=1e-15)
        np.testing.assert_allclose(single_slope, slope[i], rtol=1e-12, atol=1e-15)
