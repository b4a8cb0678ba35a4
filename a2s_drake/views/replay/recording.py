"""Recording: a flight's replay in one HTML file that loads nothing."""

import math
from html import escape
from pathlib import Path

from pydrake.geometry import MeshcatAnimation

from a2s_drake.common.files import written_whole
from a2s_drake.flight.log import Flight
from a2s_drake.guidance.courses import Courses
from a2s_drake.views.replay.scene import Scene
from a2s_drake.views.replay.stage import start_meshcat

FRAMES_PER_SECOND = 20.0  # at most
MOST_FRAMES = 1000  # longer flights are shown with fewer frames per second
TITLE = "<title>Drake MeshCat</title>"


def write_replay(flight: Flight, path: Path | str) -> None:
    """Writes a flight's replay, a self-contained HTML page that any browser with WebGL plays, over and over.

    4.6 MB for 40 s, and never more than 6 MB: long flights show fewer frames a second, 1.6 of them at 10 min. The same
    flight gives the same bytes.

    Raises:
      ValueError: when the flight holds no sample.
      OSError: when the file cannot be written, or Meshcat cannot be started.
    """
    page = replay_html(flight)
    with written_whole(Path(path)) as part:
        part.write_text(page, encoding="utf-8")


def replay_html(flight: Flight) -> str:
    """The page that `write_replay` writes."""
    samples = len(flight.time)
    if samples == 0:
        raise ValueError("the flight holds no sample to replay")
    # Meshcat makes its pages only while it serves; any free port keeps out of the way of every other server.
    meshcat = start_meshcat(port=0)
    animation = MeshcatAnimation(1.0 / flight.scenario.mpc.period)
    animation.set_loop_mode(MeshcatAnimation.LoopMode.kLoopRepeat)
    animation.set_repetitions(1_000_000)
    # The track files may have changed or gone since the flight, which has kept what was in them.
    courses = Courses.of(flight.scenario, flight.files)
    scene = Scene(meshcat, flight.scenario, animation, last_frame=samples - 1, courses=courses)
    for frame in shown_frames(samples, flight.scenario.mpc.period):
        scene.show(flight.sample(frame), frame)
    meshcat.SetAnimation(animation)
    page = meshcat.StaticHtml()
    title = f"a2s_drake: {flight.law}, {flight.time[-1]:g} s"
    return page.replace(TITLE, f"<title>{escape(title)}</title>", 1)


def shown_frames(samples: int, period: float) -> list[int]:
    """The rows of a flight that the replay shows: the first, the last, and in between one every few."""
    stride = max(math.ceil(1.0 / (FRAMES_PER_SECOND * period) - 1e-9), math.ceil(samples / MOST_FRAMES))
    return sorted({*range(0, samples, stride), samples - 1})
