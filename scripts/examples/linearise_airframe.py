"""Drake's `Linearize` on the airframe at hover: what its poles and its controllability say, and what they hide.

The hexarotor is a free rigid body, so all its poles are zero. Chains of integrators lead from the rotors to the pose;
from roll and pitch to the position they are four long. The plant stores attitude as a quaternion, so it has 13 states
in place of 12. The additional one is the quaternion's norm, which no input moves. In the other states the MPC's
prediction model is the same.
"""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long
import numpy as np
from matplotlib.figure import Figure
from pydrake.systems.primitives import Linearize

from a2s_drake import Scenario, hover_input
from a2s_drake.vehicle.rigid_body import RigidBodyModel
from diagrams import build_airframe_only
from scripts.example_figures import poles_figure
from scripts.examples.shared import run, run_example


def show() -> Figure:
    """Prints poles, ranks and the difference from the prediction model; draws A and what errors do to its poles."""
    airframe = Scenario().airframe
    diagram = build_airframe_only()
    context = diagram.CreateDefaultContext()
    command, state = diagram.GetInputPort("rotor_speed_squared"), diagram.GetOutputPort("vehicle_state")
    command.FixValue(context, hover_input(airframe))
    linear = Linearize(diagram, context, command.get_index(), state.get_index())
    A, B, C = linear.A(), linear.B(), linear.C()  # C = d(vehicle_state)/d(plant's state)

    # Powers tell what computed eigenvalues cannot: A^4 = 0, so all are exactly zero, in chains of up to four.
    powers = [np.linalg.matrix_power(A, j) for j in range(13)]
    print(f"largest |eigenvalue| as computed: {np.abs(np.linalg.eigvals(A)).max():.1e} 1/s")
    print("largest entry of A, A^2, A^3, A^4:", ", ".join(f"{np.abs(power).max():.2g}" for power in powers[1:5]))
    reached = np.hstack([power @ B for power in powers])
    plant_rank, rank = (np.linalg.matrix_rank(matrix) for matrix in (reached, C @ reached))
    print(f"controllable: {plant_rank} of the plant's 13 states, {rank} of the 12 of vehicle_state")

    # y = h(x) moves by both models: Dh(x) f(x, u) = f_mpc(h(x), u). At rest, f = 0, the slopes are C A = A_mpc C.
    by_state, by_input = RigidBodyModel.of(airframe).jacobians(np.zeros(12), hover_input(airframe))
    off = np.abs(C @ A - by_state @ C).max(), np.abs(C @ B - by_input).max()
    print(f"off the MPC's prediction model: {off[0]:.1e} by the state, {off[1]:.1e} by the input")

    errors = np.logspace(-16.0, -2.0, 15)
    noise = np.random.default_rng(0).standard_normal((100, 13, 13))
    moved = [np.abs(np.linalg.eigvals(A + error * noise)).max(axis=-1) for error in errors]
    return poles_figure(A, errors, np.array(moved))


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be worked with."""
    return run_example("linearise_airframe", show, __doc__, argv)


if __name__ == "__main__":
    run(main)
