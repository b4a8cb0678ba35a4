"""An airframe of your own: at which attitudes can it hover, and how does that depend on the tilt of its rotors?

Every number of the vehicle is a field of `Airframe`; `--change airframe.rotor_speed_min=0` and the like set them. A
hexarotor can rest at an attitude when the rotor speeds that balance its weight lie within their bounds. At Table I's
tilt of 20 deg the controller's +-15 deg are out of reach: at 11 deg of pitch the lower bound of 16 Hz binds.
"""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from a2s_drake import Scenario
from a2s_drake.study.ceiling import is_hoverable
from scripts.example_figures import reach_figure
from scripts.examples.shared import run, run_example


def show(change: list[str]) -> Figure:
    """Prints the reach at some tilts; draws the outlines of the attitudes to hover at, and the reach over tilt."""
    scenario = Scenario().with_overrides(change).validate()
    limit = scenario.mpc.attitude_limit_deg

    # One angle alone. It does not start at tilt 0, where all rotors point up and push only upwards.
    tilts, alone = np.arange(1.0, 41.0), np.arange(-45.0, 45.01, 0.05)
    reach = []
    for tilt in tilts:
        vehicle = replace(scenario.airframe, tilt_deg=tilt)
        rolls, pitches = (alone[is_hoverable(np.deg2rad(np.outer(alone, axis)), vehicle)] for axis in np.eye(3)[:2])
        reach.append((rolls.min(initial=0.0), rolls.max(initial=0.0), pitches.max(initial=0.0)))

    # Both angles. Yaw turns the vehicle about the vertical, so it does not matter here.
    angles, outlines = np.arange(-40.0, 40.1, 0.25), {}
    eta = np.deg2rad([[(roll, pitch, 0.0) for roll in angles] for pitch in angles])
    in_box = np.abs(np.rad2deg(eta)).max(axis=-1) <= limit
    for tilt in (10.0, 20.0, 30.0, 40.0):
        rests = outlines[tilt] = is_hoverable(eta, replace(scenario.airframe, tilt_deg=tilt))
        lowest, highest, pitch = reach[tilts.tolist().index(tilt)]
        print(
            f"tilt {tilt:g} deg: roll from {lowest:.1f} to {highest:.1f} deg, pitch to {pitch:.1f} deg either way, "
            f"{100.0 * rests[in_box].mean():.0f} % of the controller's box"
        )
    return reach_figure(angles, outlines, tilts, np.array(reach), limit)


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be worked with."""
    change = ([], "fields of the scenario to change, section.field=value ...")
    return run_example("own_airframe", show, __doc__, argv, change=change)


if __name__ == "__main__":
    run(main)
