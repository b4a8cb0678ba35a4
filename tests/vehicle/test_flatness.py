import numpy as np
import pytest
from pydrake.math import RollPitchYaw
from pydrake.multibody.tree import MultibodyForces

from a2s_drake import Airframe, wrench_map
from a2s_drake.common.rotations import body_rates
from a2s_drake.vehicle.airframe import hover_input, make_plant
from a2s_drake.vehicle.flatness import FlatMap


@pytest.fixture
def motion(rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(-0.5, 0.5, (40, 9)) * np.repeat([1.0, 2.0, 20.0], 3)


@pytest.fixture
def acceleration(rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(-1.0, 1.0, (40, 3))


def angular_acceleration_in_body(rpy: RollPitchYaw, rate: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """From Drake's map the other way, which is affine in the angular acceleration."""
    without = rpy.CalcRpyDDtFromAngularAccelInChild(rate, np.zeros(3))
    columns = [rpy.CalcRpyDDtFromAngularAccelInChild(rate, axis) - without for axis in np.eye(3)]
    return np.linalg.solve(np.column_stack(columns), acceleration - without)


def test_the_plant_moves_as_asked_under_the_rotor_speeds(motion: np.ndarray, acceleration: np.ndarray) -> None:
    airframe = Airframe()
    omega, u = FlatMap.of(airframe).needs(motion, acceleration)
    plant, _ = make_plant(airframe)
    context, gravity = plant.CreateDefaultContext(), MultibodyForces(plant)
    for row, (eta, rate, bend) in enumerate(zip(motion[:, :3], motion[:, 3:6], motion[:, 6:], strict=True)):
        rpy = RollPitchYaw(eta)
        R_WB = rpy.ToRotationMatrix()
        w_WB_W = rpy.CalcAngularVelocityInParentFromRpyDt(rate)
        alpha_W = R_WB.multiply(angular_acceleration_in_body(rpy, rate, bend))
        plant.SetPositions(context, np.concatenate([rpy.ToQuaternion().wxyz(), np.zeros(3)]))
        plant.SetVelocities(context, np.concatenate([w_WB_W, np.ones(3)]))
        plant.CalcForceElementsContribution(context, gravity)
        wrench_W = plant.CalcInverseDynamics(context, np.concatenate([alpha_W, acceleration[row]]), gravity)
        to_body = R_WB.inverse()
        wrench_B = np.concatenate([to_body.multiply(wrench_W[3:]), to_body.multiply(wrench_W[:3])])
        np.testing.assert_allclose(wrench_map(airframe) @ u[row], wrench_B, atol=1e-9)
        np.testing.assert_allclose(omega[row], to_body.multiply(w_WB_W), atol=1e-12)


def test_slopes_are_the_derivatives(motion: np.ndarray, acceleration: np.ndarray) -> None:
    dut = FlatMap.of(Airframe(tilt_deg=35.0))
    omega_by, u_by = dut.slopes(motion, acceleration)
    assert (omega_by.shape, u_by.shape) == ((40, 3, 9), (40, 6, 9))
    for entry, step in enumerate(1e-6 * np.eye(9)):
        after, before = dut.needs(motion + step, acceleration), dut.needs(motion - step, acceleration)
        np.testing.assert_allclose(omega_by[..., entry], (after[0] - before[0]) / 2e-6, atol=1e-7)
        np.testing.assert_allclose(u_by[..., entry], (after[1] - before[1]) / 2e-6, atol=1e-3)


def test_level_and_at_rest_is_hover() -> None:
    omega, u = FlatMap.of(Airframe()).needs(np.zeros(9), np.zeros(3))
    np.testing.assert_allclose(u, hover_input(Airframe()))
    assert not omega.any()


def test_body_rates_of_small_angles_are_euler_rates() -> None:
    rate = np.array([0.1, -0.2, 0.3])
    np.testing.assert_allclose(body_rates(np.zeros(3), rate), rate)
    np.testing.assert_allclose(body_rates(np.array([np.pi / 2.0, 0.0, 0.0]), rate), [0.1, 0.3, 0.2])


def test_an_airframe_without_tilt_is_not_flat_in_position_and_attitude() -> None:
    with pytest.raises(ValueError, match=r"airframe\.tilt_deg = 0\.0"):
        FlatMap.of(Airframe(tilt_deg=0.0))
