"""The paper's law and level, their controller fed what they foresee: the height is then right, little else changes."""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long
import numpy as np
from matplotlib.figure import Figure
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

from a2s_drake import AttitudeReference, Scenario, compute_metrics, hover_input, run_flight
from a2s_drake.common.wiring import build_wired, export_outputs
from a2s_drake.guidance.path import uav_path
from diagrams import Blocks, build_closed_loop
from scripts.example_figures import laws_figure
from scripts.examples.shared import run, run_example


class PathVelocity(LeafSystem):
    """| PathVelocity |--> velocity_preview: of the reference path at now, now + T_s, ..., m/s, W."""

    def __init__(self, scenario: Scenario) -> None:
        LeafSystem.__init__(self)
        self._path, self._ahead = uav_path(scenario.mission), scenario.mpc.period * np.arange(scenario.mpc.horizon + 1)
        self.DeclareVectorOutputPort("velocity_preview", 3 * len(self._ahead), self._calc, {self.time_ticket()})

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._path.velocity(context.get_time() + self._ahead).ravel())


def fed(scenario: Scenario) -> Diagram:
    """A scenario's law that feeds its controller the path's velocity, no angular velocity, and hover."""
    builder, mpc = DiagramBuilder(), scenario.mpc
    law = builder.AddSystem(AttitudeReference(scenario.link, scenario.attitude_law, mpc.attitude_limit, mpc.horizon))
    still, hover = np.zeros(3 * (mpc.horizon + 1)), np.tile(hover_input(scenario.airframe), mpc.horizon)
    for name, values in (("angular_velocity_preview", still), ("rotor_speed_squared_preview", hover)):
        builder.ExportOutput(builder.AddSystem(ConstantVectorSource(values)).get_output_port(), name)
    export_outputs(builder, law, builder.AddSystem(PathVelocity(scenario)))
    for name in ("position_preview", "ship_preview"):
        builder.ExportInput(law.GetInputPort(name), name)
    return build_wired(builder, "fed")


def show(duration: float) -> Figure:
    """Flies level and the paper's law, both fed; prints what they transmit, and how far they stray."""
    flights = {}
    for name, law in (("level", "level"), ("the paper's law", "three_axis")):
        scenario = Scenario().with_overrides([f"attitude_law.name={law}", f"simulation.duration={duration}"]).validate()
        flights[name] = run_flight(build_closed_loop(scenario, blocks=Blocks(law=fed)), scenario)
        got = compute_metrics(flights[name])
        print(f"{name}: {got['throughput_bit_per_hz']:.3f} bit/Hz, {got['position_error_max_m']:.4f} m astray at most")
    return laws_figure(flights)


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be flown; 1 for a flight that ended early, 130 for an interrupted one."""
    return run_example("fed_law", show, __doc__, argv, duration=(8.0, "length of each flight, s"))


if __name__ == "__main__":
    run(main)
