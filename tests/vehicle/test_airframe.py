import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator

from a2s_drake import Airframe, Scenario, hover_input, wrench_map
from a2s_drake.vehicle.airframe import VehicleState, VehicleState_, make_plant, make_propeller, rotor_table
from diagrams import build_airframe_only

# Force over torque in B per newton of rotor thrust, computed apart from this code; four digits.
PUBLISHED_MAP = np.array(
    [
        [0, 0.2962, -0.2962, 0, 0.2962, -0.2962],
        [0.342, -0.171, -0.171, 0.342, -0.171, -0.171],
        [0.9397, 0.9397, 0.9397, 0.9397, 0.9397, 0.9397],
        [0, 0.3234, 0.3234, 0, -0.3234, -0.3234],
        [-0.3734, -0.1867, 0.1867, 0.3734, 0.1867, -0.1867],
        [0.1143, -0.1143, 0.1143, -0.1143, 0.1143, -0.1143],
    ]
)
SECOND_AIRFRAME = Airframe(tilt_deg=35.0, thrust_coefficient=9.9e-4, drag_to_thrust=0.019)


def test_wrench_map_is_the_published_one() -> None:
    airframe = Airframe()
    np.testing.assert_allclose(wrench_map(airframe) / airframe.thrust_coefficient, PUBLISHED_MAP, atol=5.1e-5)


@pytest.mark.parametrize("airframe", [Airframe(), Airframe(drag_sign=1), SECOND_AIRFRAME])
def test_wrench_map_is_what_drakes_propeller_puts_out(airframe: Airframe, rng: np.random.Generator) -> None:
    plant, body = make_plant(airframe)
    dut = make_propeller(airframe, body.index())
    X_WB = RigidTransform(RollPitchYaw(0.2, -0.3, 0.5), [1.0, 2.0, 3.0])
    u = rng.uniform(256.0, 1e4, 6)
    context = dut.CreateDefaultContext()
    dut.get_command_input_port().FixValue(context, u)
    dut.get_body_poses_input_port().FixValue(context, [RigidTransform(), X_WB])
    force_W, torque_W = np.zeros(3), np.zeros(3)
    R_WB = X_WB.rotation().matrix()
    for applied in dut.get_spatial_forces_output_port().Eval(context):
        assert applied.body_index == body.index()
        force_W += applied.F_Bq_W.translational()
        torque_W += applied.F_Bq_W.rotational() + np.cross(R_WB @ applied.p_BoBq_B, applied.F_Bq_W.translational())
    expected = np.concatenate([R_WB.T @ force_W, R_WB.T @ torque_W])
    np.testing.assert_allclose(wrench_map(airframe) @ u, expected, rtol=1e-12, atol=1e-12)
    assert plant.num_bodies() == 2


def test_default_drag_opposes_the_yaw_moment_of_the_tilt() -> None:
    without = wrench_map(Airframe(drag_to_thrust=0.0))[5]
    opposing, adding = (wrench_map(Airframe(drag_sign=sign))[5] for sign in (-1, 1))
    assert (np.abs(opposing) < np.abs(without)).all()
    assert (np.abs(adding) > np.abs(without)).all()


@pytest.mark.parametrize("airframe", [Airframe(), SECOND_AIRFRAME])
def test_tilted_rotors_are_fully_actuated_and_flat_ones_are_not(airframe: Airframe) -> None:
    assert np.linalg.matrix_rank(wrench_map(airframe)) == 6
    assert np.linalg.matrix_rank(wrench_map(Airframe(tilt_deg=0.0))) == 4


def test_rotors_stand_at_arms_length_the_first_on_x() -> None:
    hubs = np.array([rotor.X_BP.translation() for rotor in rotor_table(Airframe())])
    np.testing.assert_allclose(np.linalg.norm(hubs, axis=1), 0.38998)
    np.testing.assert_allclose(hubs[0], [0.38998, 0.0, 0.0])
    np.testing.assert_allclose(np.diff(np.unwrap(np.arctan2(hubs[:, 1], hubs[:, 0]))), np.pi / 3.0)


def test_hover_speed() -> None:
    np.testing.assert_allclose(np.sqrt(hover_input(Airframe())), 61.69, atol=0.005)


def test_hover_holds_for_two_seconds(scenario: Scenario) -> None:
    dut = build_airframe_only(scenario)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.GetInputPort("rotor_speed_squared").FixValue(context, hover_input(scenario.airframe))
    simulator.AdvanceTo(2.0)
    np.testing.assert_allclose(dut.GetOutputPort("vehicle_state").Eval(context), 0.0, atol=1e-9)


def test_published_hover_speed_holds_for_two_seconds(scenario: Scenario) -> None:
    # 61.69 Hz is rounded: it lifts by (61.69/61.68977)^2, which over 2 s is a tenth of a millimetre.
    dut = build_airframe_only(scenario)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.GetInputPort("rotor_speed_squared").FixValue(context, np.full(6, 61.69**2))
    simulator.AdvanceTo(2.0)
    np.testing.assert_allclose(dut.GetOutputPort("vehicle_state").Eval(context), 0.0, atol=5e-4)


@pytest.mark.parametrize("eta", [[0.0, 0.0, 0.0], [0.3, -0.2, 0.1], [-1.0, 1.2, 3.0]])
def test_vehicle_state_speaks_euler_angles_and_body_rates(eta: list[float], rng: np.random.Generator) -> None:
    dut = VehicleState()
    R_WB = RollPitchYaw(eta).ToRotationMatrix()
    p_WB, v_WB_W, w_WB_B = rng.normal(size=(3, 3))
    wxyz = 1.001 * R_WB.ToQuaternion().wxyz()  # a quaternion that has drifted
    context = dut.CreateDefaultContext()
    dut.GetInputPort("plant_state").FixValue(context, np.concatenate([wxyz, p_WB, R_WB.matrix() @ w_WB_B, v_WB_W]))
    state = dut.GetOutputPort("vehicle_state").Eval(context)
    np.testing.assert_allclose(state, np.concatenate([p_WB, eta, v_WB_W, w_WB_B]), atol=1e-12)


def test_plant_layout_is_the_one_the_adapter_reads() -> None:
    plant, body = make_plant(Airframe(), p_WB=[1.0, 2.0, 3.0])
    context = plant.CreateDefaultContext()
    np.testing.assert_array_equal(plant.GetPositions(context), [1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0])
    quaternion = Quaternion(wxyz=plant.GetPositions(context)[:4])
    np.testing.assert_array_equal(quaternion.rotation(), np.eye(3))
    assert body.floating_positions_start() == 0


def test_vehicle_state_differentiates() -> None:
    dut = VehicleState_[AutoDiffXd]()
    context = dut.CreateDefaultContext()
    state = np.array([AutoDiffXd(x) for x in [1.0, 0.0, 0.0, 0.0, *range(9)]])
    state[2] = AutoDiffXd(0.0, [1.0])  # d(qy) at rest is half a turn of pitch
    dut.GetInputPort("plant_state").FixValue(context, state)
    pitch = dut.GetOutputPort("vehicle_state").Eval(context)[4]
    assert pitch.derivatives()[0] == pytest.approx(2.0)
