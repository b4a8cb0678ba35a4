"""An attitude law of your own, a block with the ports of `AttitudeReference`, flown beside the paper's.

It asks only for what the vehicle can hover at; the paper's law asks for more than that, and pays in position.
"""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long
import numpy as np
from matplotlib.figure import Figure
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from a2s_drake import Scenario, run_flight
from a2s_drake.link.two_ray import antenna_position, channel_gain, path_lengths
from a2s_drake.study.ceiling import is_hoverable
from diagrams import Blocks, build_closed_loop
from scripts.example_figures import laws_figure
from scripts.example_flights import tell
from scripts.examples.shared import run, run_example


class BestHoverable(LeafSystem):
    """position_preview, ship_preview (m, W) -->| BestHoverable |--> attitude_preview, attitude_reference (rad)."""

    def __init__(self, scenario: Scenario) -> None:
        LeafSystem.__init__(self)
        angles = np.linspace(-scenario.mpc.attitude_limit, scenario.mpc.attitude_limit, 31)
        grid = np.array([(roll, pitch, 0.0) for roll in angles for pitch in angles])
        self._grid, self._link = grid[is_hoverable(grid, scenario.airframe)], scenario.link
        size, inputs = 3 * (scenario.mpc.horizon + 1), {self.all_input_ports_ticket()}
        self._geometry = [self.DeclareVectorInputPort(name, size) for name in ("position_preview", "ship_preview")]
        self._preview = self.DeclareVectorOutputPort("attitude_preview", size, self._calc_preview, inputs)
        self.DeclareVectorOutputPort("attitude_reference", 3, self._calc_reference, inputs)

    def _calc_preview(self, context: Context, output: BasicVector) -> None:
        position, ship = (port.Eval(context).reshape(-1, 1, 3) for port in self._geometry)
        rays = path_lengths(antenna_position(position, self._grid, self._link), ship, self._link)
        output.SetFromVector(self._grid[channel_gain(*rays, self._link).argmax(axis=1)].ravel())

    def _calc_reference(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._preview.Eval(context)[:3])


def show(duration: float) -> Figure:
    """Flies level, the paper's law and the one above; prints what they transmit and how far they stray."""
    paper = Scenario().with_value("simulation.duration", duration)
    level = paper.with_value("attitude_law.name", "level")
    laws = {"level": (level, None), "the paper's law": (paper, None), "own law": (paper, Blocks(law=BestHoverable))}
    flown = {name: run_flight(build_closed_loop(one, blocks=law), one) for name, (one, law) in laws.items()}
    tell(flown)
    return laws_figure(flown)


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be flown; 1 for a flight that ended early, 130 for an interrupted one."""
    return run_example("own_law", show, __doc__, argv, duration=(8.0, "length of each flight, s"))


if __name__ == "__main__":
    run(main)
