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
from a2s_drake.planned.plan import Progress, plan_attitude
from a2s_drake.planned.spline import SUPPORT, AttitudeSpline
from a2s_drake.scenario import Scenario

# Every module that the planner imports, itself or through others, and the libraries that its numbers hang on.
_PACKAGE = Path(__file__).parents[1]
SOURCES = [
    *sorted(source for source in Path(__file__).parent.glob("*.py") if source.stem not in ("keep", "reference")),
    *(_PACKAGE / f"{name}.py" for name in ("airframe", "arrays", "attitude_law", "checks", "disturbances")),
    *(_PACKAGE / f"{name}.py" for name in ("field_values", "flatness", "packages", "parameters", "paths")),
    *(_PACKAGE / f"{name}.py" for name in ("piqp_solver", "quadratic_form", "quoting", "rotations", "scenario")),
    *(_PACKAGE / f"{name}.py" for name in ("two_ray", "wiring", "yaml_reader")),
]
_LIBRARIES = ("drake", "numpy", "piqp", "scipy")


def plan_folder() -> Path:
    """Where plans are kept: `a2s_drake/plans` in the user's cache, which XDG_CACHE_HOME may name."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "a2s_drake" / "plans"


def plan_key(scenario: Scenario) -> str:
    """What a plan hangs on in a scenario, as a digest."""
    mpc = {name: getattr(scenario.mpc, name) for name in ("period", "attitude_limit_deg", "angular_velocity_limit")}
    parts = {name: asdict(getattr(scenario, name)) for name in ("airframe", "link", "mission", "planning")}
    return hashlib.sha256(yaml_dump(parts | {"mpc": mpc}).encode()).hexdigest()


def plan_file(scenario: Scenario, folder: Path | None = None) -> Path:
    """The file of a scenario's plan by the present code, which need not exist yet."""
    digest = hashlib.sha256(plan_key(scenario).encode())
    digest.update(" ".join(f"{name} {version(name)}" for name in _LIBRARIES).encode())
    for source in SOURCES:
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
            return load_plan(file, scenario)
        except OSError as error:
            warnings.warn(f"a kept plan is damaged and is made again: {error}", stacklevel=2)
    plan = plan_attitude(scenario, progress, time_limit)
    if plan.truncated:
        words = f"planning was cut short after {time_limit:g} s, with {plan.gain_percent:+.2f} % over level"
        warnings.warn(f"{words}; this plan is not kept among the others", stacklevel=2)
        return plan.spline
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        save_plan(plan.spline, file, scenario)
    except OSError as error:
        warnings.warn(f"the plan cannot be kept in {file.parent}: {error.strerror}", stacklevel=2)
    return plan.spline


def save_plan(spline: AttitudeSpline, file: Path, scenario: Scenario) -> None:
    """Writes the planned attitude of a scenario, whole or not at all.

    Raises:
      OSError: when the disk refuses.
    """
    content = {"key": np.array(plan_key(scenario)), "duration": np.array(spline.duration), "control": spline.control}
    with written_whole(file) as part, part.open("wb") as opened:
        np.savez_compressed(opened, allow_pickle=False, **content)


def load_plan(file: Path, scenario: Scenario) -> AttitudeSpline:
    """The planned attitude that `save_plan` wrote.

    Raises:
      OSError: when it cannot be read, holds no plan, or one for another scenario; says which.
    """
    try:
        with file.open("rb") as opened, np.load(opened) as archive:
            key, spline = str(archive["key"]), AttitudeSpline(float(archive["duration"]), archive["control"])
    except (ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise OSError(f"{file} holds no plan: {error}") from error
    if key != plan_key(scenario):
        raise OSError(f"{file} holds a plan for another scenario")
    if spline.control.shape[1:] != (3,) or len(spline.control) <= SUPPORT or not np.isfinite(spline.control).all():
        raise OSError(f"{file} holds no plan: its control points are of shape {spline.control.shape}, or not finite")
    if spline.duration != scenario.mission.duration:
        raise OSError(f"{file} holds no plan for {scenario.mission.duration:g} s, but for {spline.duration:g} s")
    return spline
