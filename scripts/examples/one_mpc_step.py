"""One step of the MPC opened up: what it foresees, which bounds its plan meets, and what its cost consists of.

The vehicle starts 30 cm off its path, at rest and level, while the law asks for -10 deg of roll and 9 of pitch. Towards
the end of the horizon the plan lets the vehicle sink: thrust costs, and the horizon shows only the start of a fall.
"""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long
import numpy as np
from matplotlib.figure import Figure
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from a2s_drake import Scenario, SolverStatus
from a2s_drake.common.wiring import find_block
from a2s_drake.control.horizon import cost_terms
from a2s_drake.control.program import input_bounds, state_bounds
from diagrams import build_closed_loop
from scripts.example_figures import plan_figure
from scripts.examples.shared import run, run_example

NAMES = [f"{n}_{i}" for n, k in {"p": 3, "eta": 3, "v": 3, "omega": 3, "rotor": 6}.items() for i in range(1, k + 1)]


def show() -> Figure:
    """Prints cost by term and active bounds; draws the plan."""
    scenario = Scenario()  # Table I
    diagram = build_closed_loop(scenario)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    plant, mpc = (find_block(diagram, name) for name in ("plant", "mpc"))
    body, off = plant.GetBodyByName("hexarotor"), RigidTransform([0.0, -0.3, 0.0])
    plant.SetFreeBodyPose(plant.GetMyMutableContextFromRoot(context), body, off)
    simulator.Initialize()  # The controller decides once.

    own = mpc.GetMyContextFromRoot(context)
    plan, status = mpc.plan(own), SolverStatus(mpc.GetOutputPort("solver_status").Eval(own))
    reference = mpc.reference(own)
    terms = cost_terms(plan, reference, scenario.mpc)
    for name, term in terms.items():
        print(f"{name:16}{term.sum():8.3f} {100.0 * term.sum() / status.objective:5.1f} %")
    print(f"{'sum':16}{sum(term.sum() for term in terms.values()):8.3f}, in solver_status {status.objective:.3f}")

    bounds = zip(state_bounds(scenario.mpc), input_bounds(scenario.airframe), strict=True)
    lower, upper = (np.append(states, 6 * [speed]) for states, speed in bounds)
    use = (np.hstack([plan.state[1:], plan.input]) - lower) / (upper - lower)  # 0 and 1 lie on the bounds
    for name, column in zip(NAMES, use.T, strict=True):
        for bound, binds in (("lower", column < 1e-4), ("upper", column > 1.0 - 1e-4)):
            if binds.any():
                print(f"{name} on its {bound} bound in period", ", ".join(map(str, np.flatnonzero(binds))))
    return plan_figure(scenario, plan, reference, terms)


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be worked with."""
    return run_example("one_mpc_step", show, __doc__, argv)


if __name__ == "__main__":
    run(main)
