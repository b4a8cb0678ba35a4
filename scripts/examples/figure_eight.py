"""A path of your own: a figure eight written as a CSV file, flown under the paper's law and under level.

`mission.path_file` names the file: columns time,x,y,z in seconds and metres, in the world frame. The spline through its
rows is flown. A path from rest to rest suits the vehicle, which takes off at rest.
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


def write_figure_eight(file: Path, duration: float) -> None:
    """Writes a figure eight of 4 m by 2 m, which begins and ends at rest in the origin."""
    time = np.linspace(0.0, duration, 201)
    angle = np.pi * (1.0 - np.cos(np.pi * time / duration))
    path = np.column_stack([time, 2.0 * np.sin(angle), np.sin(2.0 * angle), np.zeros_like(time)])
    np.savetxt(file, path, fmt="%.9g", delimiter=",", header="time,x,y,z", comments="")


def show(duration: float) -> Figure:
    """Flies the figure eight under both laws; prints what they transmit and how far they stray."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "figure_eight.csv"
        write_figure_eight(file, duration)
        flights = fly_both(f"mission.path_file={file}", f"mission.duration={duration}")
    tell(flights)
    return laws_figure(flights)


def main(argv: list[str] | None = None) -> int:
    """Returns 0; 2 for input that cannot be flown; 1 for a flight that ended early, 130 for an interrupted one."""
    return run_example("figure_eight", show, __doc__, argv, duration=(40.0, "length of the path, s"))


if __name__ == "__main__":
    run(main)
