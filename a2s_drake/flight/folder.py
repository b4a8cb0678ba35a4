"""What a run writes into its folder: scenario, log, plan, metrics, and more files on request."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from a2s_drake.common.files import held, what_is_kept, written_whole
from a2s_drake.common.interrupts import interrupts_put_off
from a2s_drake.flight.log import Flight
from a2s_drake.flight.metrics import write_metrics
from a2s_drake.guidance.plan.cache import save_plan
from a2s_drake.guidance.plan.spline import AttitudeSpline

PLAN = "plan.npz"
"""The file of a flight's folder that holds its plan."""


@interrupts_put_off()
def write_results(
    flight: Flight,
    folder: Path | str,
    plan: AttitudeSpline | None = None,
    *,
    csv: bool = False,
    replay: Callable[[Flight, Path], Any] | None = None,
) -> None:
    """Writes scenario.yaml, flight.npz, the plan if there is one, metrics.json, and the files that are asked for.

    A flight without a sample has no metrics.json. Files of an earlier flight are removed, so that all files in the
    folder belong to one flight, even after an interrupt. If two processes write into the same folder at the same time,
    one waits for the other. A warning says when scenario.yaml alone cannot rebuild the flight, because a block of the
    user's own flew.

    Args:
      csv: whether to write flight.csv too.
      replay: writes a flight with a sample as replay.html: `a2s_drake.views.replay.write_replay`.
    Raises:
      ResultsError: when the disk refuses, or the replay cannot be made; says what is kept.
    """
    folder = Path(folder)
    with what_is_kept(f"{folder} is as it was"):
        folder.mkdir(parents=True, exist_ok=True)
    with held(folder):
        with what_is_kept(f"{folder} is as it was"):
            if plan is None:
                flight.save(folder)
            else:
                with written_whole(folder / PLAN) as part:
                    save_plan(plan, part, flight.scenario)
                    flight.save(folder)
        # The new flight is on the disk now, so files that an earlier one has left can be removed.
        with what_is_kept(f"the flight itself is in {folder}"):
            for name in ("metrics.json", "flight.csv", "replay.html", *([] if plan else [PLAN])):
                (folder / name).unlink(missing_ok=True)
            if len(flight.time):
                write_metrics(flight, folder)
            if csv:
                flight.save_csv(folder / "flight.csv")
            if replay is not None and len(flight.time):
                replay(flight, folder / "replay.html")
    if not flight.rebuilds_from_scenario:
        own = ", ".join(f"{role} = {name}" for role, name in flight.own_blocks.items())
        what = f"{folder / 'scenario.yaml'} alone cannot rebuild this flight, in which blocks of your own flew: {own}"
        warnings.warn(what, stacklevel=3)
