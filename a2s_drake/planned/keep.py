"""Plans kept on disk, so that each is computed once: by all that it hangs on, scenario and code."""

import hashlib
import os
import warnings
import zipfile
from collections.abc import Callable
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path

import numpy as np
from pydrake.common.yaml import yaml_dump

from a2s_drake.files import written_whole
from a2s_drake.planned.plan import PlannedAttitude, Progress, plan_attitude
from a2s_drake.planned.spline import AttitudeSpline
from a2s_drake.scenario import Scenario

_HERE = Path(__file__).parent
_SOURCES = [
    *sorted(source for source in _HERE.glob("*.py") if source.stem not in ("keep", "reference")),
    *(_HERE.parent / f"{n}.py" for n in ("flatness", "two_ray", "airframe", "paths")),
]


def plan_folder() -> Path:
    """Where plans are kept: `a2s_drake/plans` in the user's cache, which XDG_CACHE_HOME may name."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "a2s_drake" / "plans"


def plan_file(scenario: Scenario, folder: Path | None = None) -> Path:
    """The file of a scenario's plan, which need not exist yet."""
    mpc = {name: getattr(scenario.mpc, name) for name in ("period", "attitude_limit_deg", "angular_velocity_limit")}
    parts = {name: asdict(getattr(scenario, name)) for name in ("airframe", "link", "mission", "planning")}
    digest = hashlib.sha256(yaml_dump(parts | {"mpc": mpc}).encode())
    digest.update(f"drake {version('drake')} piqp {version('piqp')}".encode())
    for source in _SOURCES:
        digest.update(source.read_bytes())
    return (folder or plan_folder()) / f"{digest.hexdigest()[:16]}.npz"


def kept_plan(
    scenario: Scenario,
    progress: Callable[[Progress], None] | None = None,
    folder: Path | None = None,
    time_limit: float | None = None,
) -> AttitudeSpline:
    """The planned attitude of a scenario: the kept one, or one planned now and kept.

    Args:
      progress: as for `plan_attitude`; not called for a kept plan.
      folder: where to keep it; `plan_folder()` without it.
      time_limit: as for `plan_attitude`; a plan that it cuts short is not kept.
    Raises:
      ScenarioError: as `plan_attitude`. Warns where a kept plan is damaged, a new one cannot be kept, or is cut short.
    """
    file = plan_file(scenario, folder)
    if file.exists():
        try:
            with file.open("rb") as opened, np.load(opened) as archive:
                return AttitudeSpline(float(archive["duration"]), archive["control"])
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            warnings.warn(f"a kept plan is damaged and is made again: {file}: {error}", stacklevel=2)
    plan = plan_attitude(scenario, progress, time_limit)
    if plan.truncated:
        words = f"planning was cut short after {time_limit:g} s with {plan.gain_percent:+.2f} % over level"
        warnings.warn(f"{words}: this plan is not kept, and another run may make another", stacklevel=2)
        return plan.spline
    try:
        _keep(plan, file)
    except OSError as error:
        warnings.warn(f"the plan cannot be kept in {file.parent}: {error.strerror}", stacklevel=2)
    return plan.spline


def _keep(plan: PlannedAttitude, file: Path) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    with written_whole(file) as part, part.open("wb") as opened:
        np.savez_compressed(opened, allow_pickle=False, duration=plan.spline.duration, control=plan.spline.control)
