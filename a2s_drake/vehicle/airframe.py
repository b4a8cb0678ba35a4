"""The tilted hexarotor: one rotor table, from it the wrench map and Drake's propellers, and the airframe diagram."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from pydrake.common.eigen_geometry import Quaternion_
from pydrake.math import RigidTransform, RollPitchYaw_, RotationMatrix, RotationMatrix_
from pydrake.multibody.plant import ExternallyAppliedSpatialForceMultiplexer, MultibodyPlant, Propeller, PropellerInfo
from pydrake.multibody.tree import BodyIndex, RigidBody, SpatialInertia, UnitInertia
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem_
from pydrake.systems.primitives import Gain
from pydrake.systems.scalar_conversion import TemplateSystem

from a2s_drake.common.arrays import FloatArray
from a2s_drake.common.signals import NUM_STATES, State
from a2s_drake.common.wiring import build_wired
from a2s_drake.scenario.parts import GRAVITY, Airframe, Disturbance
from a2s_drake.world.wind import WindGust

NUM_ROTORS = 6


@dataclass(frozen=True)
class Rotor:
    """One rotor P on the body B: pose, and force and torque about its z axis per squared rotor speed."""

    X_BP: RigidTransform
    thrust_ratio: float  # N/Hz^2
    moment_ratio: float  # N m/Hz^2


def rotor_table(airframe: Airframe) -> list[Rotor]:
    """The six rotors: hub at Rz(i 60 deg) (l, 0, 0), thrust axis Rz(i 60 deg) Rx(-(-1)^i alpha) e3, i = 0..5.

    The rotors alternate in tilt and in spin. Even rotors lean so that their thrust turns the body to +yaw; the sign of
    their drag torque about the thrust axis is `airframe.drag_sign`, so -1 opposes that turn.
    """
    rotors = []
    for i in range(NUM_ROTORS):
        alternation = (-1.0) ** i
        R_BA = RotationMatrix.MakeZRotation(np.deg2rad(60.0 * i))
        R_BP = R_BA @ RotationMatrix.MakeXRotation(-alternation * np.deg2rad(airframe.tilt_deg))
        p_BP = R_BA @ np.array([airframe.arm_length, 0.0, 0.0])
        thrust = airframe.thrust_coefficient
        drag = airframe.drag_sign * alternation * airframe.drag_to_thrust * thrust
        rotors.append(Rotor(RigidTransform(R_BP, p_BP), thrust, drag))
    return rotors


def wrench_map(airframe: Airframe) -> FloatArray:
    """The 6x6 matrix from squared rotor speeds, Hz^2, to the wrench on the body.

    Rows: force (N) over torque about the centre of mass (N m), both in B.
    """
    columns = []
    for rotor in rotor_table(airframe):
        axis, hub = rotor.X_BP.rotation().col(2), rotor.X_BP.translation()
        force = rotor.thrust_ratio * axis
        columns.append(np.concatenate([force, np.cross(hub, force) + rotor.moment_ratio * axis]))
    return np.column_stack(columns)


def hover_input(airframe: Airframe) -> FloatArray:
    """Squared rotor speeds that carry the level vehicle at rest, Hz^2, shape (6,); the smallest in norm."""
    weight = np.array([0.0, 0.0, airframe.mass * GRAVITY, 0.0, 0.0, 0.0])
    return np.linalg.lstsq(wrench_map(airframe), weight, rcond=None)[0]


@TemplateSystem.define("VehicleState_")
def VehicleState_(T: Any) -> Any:  # noqa: N802 - Drake's way to name a template over scalar types
    """The block `VehicleState` for the scalar type T."""
    Quaternion, RotationMatrixT, RollPitchYaw = Quaternion_[T], RotationMatrix_[T], RollPitchYaw_[T]

    class VehicleState(LeafSystem_[T]):
        """The plant's floating-base state as the 12 numbers that law, controller and channel speak.

        ```
                           +--------------+
            plant_state -->| VehicleState |--> vehicle_state
                           +--------------+
        ```

        - `plant_state` (13): a quaternion floating base, [qw qx qy qz, p_WB (m), w_WB_W (rad/s), v_WB_W (m/s)].
        - `vehicle_state` (12): [p_WB (m), eta = roll pitch yaw (rad), v_WB_W (m/s), w_WB_B (rad/s)].

        Stateless. Converts to AutoDiffXd.
        """

        def _construct(self, converter: Any = None) -> None:
            LeafSystem_[T].__init__(self, converter=converter)
            self._plant_state = self.DeclareVectorInputPort("plant_state", 13)
            prerequisites = {self._plant_state.ticket()}
            self.DeclareVectorOutputPort("vehicle_state", NUM_STATES, self._calc_vehicle_state, prerequisites)

        def _construct_copy(self, _other: Any, converter: Any = None) -> None:
            self._construct(converter=converter)

        def _calc_vehicle_state(self, context: Any, output: Any) -> None:
            state = self._plant_state.Eval(context)
            wxyz, p_WB, w_WB_W, v_WB_W = state[0:4], state[4:7], state[7:10], state[10:13]
            # Integration lets the quaternion drift off unit length by rounding; Drake's constructor does not.
            R_WB = RotationMatrixT(Quaternion(wxyz=wxyz / np.sqrt(wxyz.dot(wxyz))))
            eta = RollPitchYaw(R_WB).vector()
            output.SetFromVector(State.of(p_WB, eta, v_WB_W, R_WB.inverse().multiply(w_WB_W)).array)

    return VehicleState


VehicleState = VehicleState_[None]


def make_plant(airframe: Airframe, p_WB: Sequence[float] = (0.0, 0.0, 0.0)) -> tuple[MultibodyPlant, RigidBody]:
    """A finalized continuous-time plant that holds one free rigid body, the hexarotor, its origin the centre of mass.

    Its default context has the body level and at rest at `p_WB` (m).
    """
    plant = MultibodyPlant(time_step=0.0)
    unit_inertia = UnitInertia(*(np.asarray(airframe.inertia) / airframe.mass))
    body = plant.AddRigidBody("hexarotor", SpatialInertia(airframe.mass, np.zeros(3), unit_inertia))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -GRAVITY])
    plant.SetDefaultFloatingBaseBodyPose(body, RigidTransform(np.asarray(p_WB, dtype=float)))
    plant.Finalize()
    return plant, body


def make_propeller(airframe: Airframe, body: BodyIndex) -> Propeller:
    """Drake's `Propeller` for the rotor table, commanded in Hz^2."""
    rotors = rotor_table(airframe)
    return Propeller([PropellerInfo(body, rotor.X_BP, rotor.thrust_ratio, rotor.moment_ratio) for rotor in rotors])


def add_airframe(
    builder: DiagramBuilder,
    airframe: Airframe,
    p_WB: Sequence[float] = (0.0, 0.0, 0.0),
    disturbance: Disturbance | None = None,
) -> Diagram:
    """Adds what `make_airframe` makes, and returns it."""
    return builder.AddSystem(make_airframe(airframe, p_WB, disturbance))


def make_airframe(
    airframe: Airframe, p_WB: Sequence[float] = (0.0, 0.0, 0.0), disturbance: Disturbance | None = None
) -> Diagram:
    """The hexarotor as a diagram named `airframe`, by default level and at rest at `p_WB` (m).

    ```
                               +----------+
                               |          |--> vehicle_state
    rotor_speed_squared     -->| airframe |
                               |          |--> body_poses
                               +----------+
    ```

    - `rotor_speed_squared` (6): Omega^2 of each rotor, Hz^2.
    - `vehicle_state` (12): [p_WB (m), eta (rad), v_WB_W (m/s), w_WB_B (rad/s)].
    - `body_poses`: Drake's list of X_WB, one per body.

    Inside stand Drake's `MultibodyPlant` and `Propeller` and the adapter `VehicleState`. A disturbance changes mass and
    inertia, weakens rotors by a `Gain` before the propellers, and adds the force of a `WindGust`.
    """
    disturbance = disturbance or Disturbance()
    inner = DiagramBuilder()
    plant, body = make_plant(_disturbed(airframe, disturbance), p_WB)
    inner.AddNamedSystem("plant", plant)
    propeller = inner.AddNamedSystem("propeller", make_propeller(airframe, body.index()))
    adapter = inner.AddNamedSystem("vehicle_state", VehicleState())
    inner.Connect(plant.get_body_poses_output_port(), propeller.get_body_poses_input_port())
    _connect_forces(inner, propeller, plant, body.index(), disturbance)
    inner.Connect(plant.get_state_output_port(), adapter.GetInputPort("plant_state"))
    _export_command(inner, propeller, disturbance)
    inner.ExportOutput(adapter.GetOutputPort("vehicle_state"), "vehicle_state")
    inner.ExportOutput(plant.get_body_poses_output_port(), "body_poses")
    return build_wired(inner, "airframe")


def _disturbed(airframe: Airframe, disturbance: Disturbance) -> Airframe:
    """The airframe as it truly is."""
    inertia = [disturbance.inertia_factor * moment for moment in airframe.inertia]
    return replace(airframe, mass=disturbance.mass_factor * airframe.mass, inertia=inertia)


def _connect_forces(
    inner: DiagramBuilder, propeller: Propeller, plant: MultibodyPlant, body: BodyIndex, disturbance: Disturbance
) -> None:
    thrust, applied = propeller.get_spatial_forces_output_port(), plant.get_applied_spatial_force_input_port()
    if not any(disturbance.gust_force):
        inner.Connect(thrust, applied)
        return
    wind = inner.AddNamedSystem("wind", WindGust(disturbance, body))
    total = inner.AddNamedSystem("spatial_forces", ExternallyAppliedSpatialForceMultiplexer(2))
    inner.Connect(thrust, total.get_input_port(0))
    inner.Connect(wind.GetOutputPort("spatial_forces"), total.get_input_port(1))
    inner.Connect(total.get_output_port(), applied)


def _export_command(inner: DiagramBuilder, propeller: Propeller, disturbance: Disturbance) -> None:
    command = propeller.get_command_input_port()
    if any(share != 1.0 for share in disturbance.rotor_efficiency):
        gain = inner.AddNamedSystem("rotor_efficiency", Gain(np.array(disturbance.rotor_efficiency)))
        inner.Connect(gain.get_output_port(), command)
        command = gain.get_input_port()
    inner.ExportInput(command, "rotor_speed_squared")
