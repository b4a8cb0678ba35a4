"""A track of your own: a ship that turns back, written as a CSV file, under the paper's law and under level.

`mission.ship_track_file` names the file: columns time,x,y in seconds and metres, in the world frame. The UAV flies the
circle of the paper meanwhile. Law and controller see the turn come, since the preview follows the spline.
"""

if __name__ == "__main__":
    import scripts.startup  # first, as the imports below take long
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from scripts.example_figures import laws_figure
from scripts.example_flights import fly_both, tell
from scripts.examples.shared import run, run_example


def write_turn(file: Path, speed: float, radius: float) -> None:
    """Writes a track of 60 s that leads straight away from x = 90 m for 10 s, then turns to port until it is back."""
    time = np.arange(0.0, 60.1, 0.5)
    straight = speed * np.minimum(time, 10.0)
    angle = np.minimum(speed * (time - 10.0) / radius, np.pi).clip(0.0)
    back = np.maximum(speed * (time - 10.0) - np.pi * radius, 0.0)
    x, y = 90.0 + straight + radius * np.sin(angle) - back, radius * (1.0 - np.cos(angle))
    np.savetxt(file, np.column_stack([time, x, y]), fmt="%.9g", delimiter=",", header="time,x,y", comments="")


def show(duration: float, speed: float) -> Figure:
    """Flies both laws; prints what they transmit, how far they stray, and where the ship heads."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "turn.csv"
        write_turn(file, speed, radius=10.0)
        flights = fly_both(f"mission.ship_track_file={file}", f"simulation.duration={duration}")
    tell(flights)
    steps = np.diff(flights["level"].ship_position, axis=0)
    first, last = np.rad2deg(np.arctan2(steps[[0, -1], 1], steps[[0, -1], 0])).round() % 360.0
    print(f"ship: heads for {first:.0f} deg at first and for {last:.0f} deg at last")
    return laws_figure(flights)


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be flown; 1 for a flight that ended early, 130 for an interrupted one."""
    options = {"duration": (40.0, "length of each flight, s"), "speed": (1.5, "of the ship, m/s")}
    return run_example("turning_ship", show, __doc__, argv, **options)


if __name__ == "__main__":
    run(main)
