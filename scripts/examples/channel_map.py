"""One block alone: the two-ray channel over roll and pitch, and the attitudes that the paper's law sees in it.

`TwoRayChannel` gets its inputs by `FixValue`, at the mission's first instant. Attitudes at which both rays add up form
bright fringes. The law knows them only by the affine phase dPhi_0 + k^T eta (Theorem 1). On each fringe it sees one
candidate eta_m = C_m k/||k||^2. It makes its answer from the candidates inside its box (Lemma 1). Far from level
these fringes stray from the true ones, or stand where there is none.
"""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long
import numpy as np
from matplotlib.figure import Figure

from a2s_drake import Scenario, TwoRayChannel, attitude_reference
from a2s_drake.guidance.soft_min import affine_phase, fringe_offsets, nearest_fringe
from a2s_drake.link.two_ray import ship_antenna_and_image
from scripts.example_figures import channel_map_figure
from scripts.examples.shared import run, run_example


def show() -> Figure:
    """Prints the gain of level attitude and of the law's answer; draws the map."""
    scenario = Scenario()  # Table I
    link, law = scenario.link, scenario.attitude_law
    position, ship = np.zeros(3), np.array([90.0, 0.0, -20.0])  # m, W
    channel = TwoRayChannel(link)
    context = channel.CreateDefaultContext()
    channel.GetInputPort("ship_antenna_position").FixValue(context, ship_antenna_and_image(ship, link)[0])

    def evaluate(eta: np.ndarray) -> tuple[float, float]:
        state = np.concatenate([position, eta, np.zeros(6)])
        channel.GetInputPort("vehicle_state").FixValue(context, state)
        gain, phase = (channel.GetOutputPort(name).Eval(context)[0] for name in ("channel_gain", "phase_difference"))
        return gain, phase

    phase_0, k = affine_phase(position, ship, link)
    m = nearest_fringe(phase_0) + np.arange(-2, 3)
    offsets = fringe_offsets(phase_0, m)  # C_m
    candidates = offsets[:, np.newaxis] * k / (k @ k)
    answer = attitude_reference(position, ship, link, law, scenario.mpc.attitude_limit)
    for name, eta in {"level": np.zeros(3), "the law's answer": answer}.items():
        gain, phase = evaluate(eta)
        off = (phase / np.pi) % 2.0 - 1.0
        print(f"{name}, {np.rad2deg(eta).round(2)} deg: |g|^2 = {gain:.9e}, {off:+.3f} pi from its fringe")

    angles = np.linspace(-50.0, 50.0, 101)
    grid = np.deg2rad([[(roll, pitch, 0.0) for roll in angles] for pitch in angles])
    gain, phase = np.moveaxis([[evaluate(eta) for eta in row] for row in grid], -1, 0)
    lines = np.rad2deg(offsets[:, np.newaxis] / k[:2])
    degrees = (np.rad2deg(candidates), np.rad2deg(answer), law.candidate_limit_deg)
    return channel_map_figure(angles, gain, phase, (2.0 * m + 1.0) * np.pi, lines, *degrees)


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be worked with."""
    return run_example("channel_map", show, __doc__, argv)


if __name__ == "__main__":
    run(main)
