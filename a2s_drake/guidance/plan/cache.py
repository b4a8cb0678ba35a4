"""Plans on disk, so that each is computed once: by all that it depends on, scenario and code."""

import hashlib
import os
import warnings
from collections.abc import Callable
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path

import numpy as np
from pydrake.common.yaml import yaml_dump

from a2s_drake.common.arrays import Array
from a2s_drake.common.files import DamagedFileError, read_arrays, write_arrays, written_whole
from a2s_drake.guidance.laws import find_law
from a2s_drake.guidance.plan.certificate import Certificate, certify
from a2s_drake.guidance.plan.plan import Progress, plan_attitude
from a2s_drake.guidance.plan.spline import SUPPORT, AttitudeSpline
from a2s_drake.scenario.scenario import Scenario

# The rooms that the planner imports, itself or through others, and the libraries that its numbers depend on.
_PACKAGE = Path(__file__).parents[2]
_ROOMS = ("common", "scenario", "solvers", "world", "vehicle", "link", "guidance")
SOURCES = [source for room in _ROOMS for source in sorted((_PACKAGE / room).rglob("*.py"))]
_LIBRARIES = ("drake", "numpy", "piqp", "scipy")

# How far a kept certificate may be from the one computed from the plan: other processors and libraries round otherwise.
_ROUNDING = 1e-6
# Control points beyond this, rad, are no attitudes, and could overflow the computation of the certificate.
_FAR = 100.0


class OtherPlanError(ValueError):
    """A file with a plan for another scenario."""


def plan_folder() -> Path:
    """Where plans are kept: `a2s_drake/plans` in the user's cache, which XDG_CACHE_HOME may name."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "a2s_drake" / "plans"


def plan_key(scenario: Scenario) -> str:
    """What a plan depends on in a scenario, as a digest."""
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
      ScenarioError: as `plan_attitude`. Warns as `find_plan` and `make_plan`.
    """
    kept = find_plan(scenario, folder)
    return make_plan(scenario, progress, folder, time_limit) if kept is None else kept


def plan_for_law(scenario: Scenario) -> AttitudeSpline | None:
    """The plan that a scenario's law flies, as `kept_plan` gives it; None for a law that needs no plan."""
    return kept_plan(scenario) if find_law(scenario.attitude_law.name).needs_plan else None


def find_plan(scenario: Scenario, folder: Path | None = None) -> AttitudeSpline | None:
    """The kept plan of a scenario. None where there is none, or, with a warning, where it is damaged."""
    file = plan_file(scenario, folder)
    try:
        return load_plan(file, scenario)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError) as error:
        warnings.warn(f"a kept plan is damaged and is made again: {error}", stacklevel=2)
        return None


def make_plan(
    scenario: Scenario,
    progress: Callable[[Progress], None] | None = None,
    folder: Path | None = None,
    time_limit: float | None = None,
) -> AttitudeSpline:
    """The planned attitude of a scenario, planned now and kept. Arguments and errors are those of `kept_plan`.

    Warns where the plan cannot be kept, is cut short, or breaks a limit. In the last two cases it is not kept.
    """
    file = plan_file(scenario, folder)
    plan = plan_attitude(scenario, progress, time_limit)
    if plan.truncated:
        words = f"planning was cut short after {time_limit:g} s, with {plan.gain_percent:+.2f} % over level"
        warnings.warn(f"{words}; this plan is not kept among the others", stacklevel=2)
        return plan.spline
    if not plan.certificate.holds:
        # It would count as damaged when it is loaded.
        warnings.warn(f"the plan breaks a limit and is not kept: {plan.certificate.broken}", stacklevel=2)
        return plan.spline
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        save_plan(plan.spline, file, scenario, plan.certificate)
    except OSError as error:
        warnings.warn(f"the plan cannot be kept in {file.parent}: {error.strerror}", stacklevel=2)
    return plan.spline


def save_plan(spline: AttitudeSpline, file: Path, scenario: Scenario, certificate: Certificate | None = None) -> None:
    """Writes the planned attitude of a scenario and its certificate, whole or not at all.

    Args:
      certificate: of this plan at the scenario's `certificate_rate`; computed without it.
    Raises:
      OSError: when the disk refuses.
    """
    arrays = {
        "key": np.array(plan_key(scenario)),
        "duration": np.array(spline.duration, float),
        "control": spline.control,
    }
    certificate = certificate or certify(spline, scenario, scenario.planning.certificate_rate)
    with written_whole(file) as part:
        write_arrays(part, arrays | _as_arrays(certificate))


def load_plan(file: Path, scenario: Scenario) -> AttitudeSpline:
    """The planned attitude that `save_plan` wrote, certified anew. That takes some 0.3 s for 40 s of mission.

    Raises:
      OSError: when the file cannot be read.
      OtherPlanError: when it holds a plan for another scenario.
      DamagedFileError: when it holds no plan, one that breaks a limit, or one that is not as it was certified. A file
        without a certificate, as former versions wrote it, is accepted where the plan keeps all limits.
    """
    arrays = read_arrays(file)
    for name, kind in {"key": "U", "duration": "f", "control": "f"}.items():
        if name not in arrays or arrays[name].dtype.kind != kind:
            raise DamagedFileError(f"{file}: holds no plan: {name} is missing, or of another type")
    if arrays["key"].shape or arrays["key"] != np.array(plan_key(scenario)):
        raise OtherPlanError(f"{file}: holds a plan for another scenario")
    control, duration = arrays["control"], arrays["duration"].item() if arrays["duration"].size == 1 else np.nan
    if control.dtype != np.float64 or control.shape[1:] != (3,) or len(control) <= SUPPORT:
        found = f"control points are {control.dtype} of shape {control.shape}"
        raise DamagedFileError(f"{file}: holds no plan: its {found}, must be float64 of shape (more than {SUPPORT}, 3)")
    if not (np.abs(control) <= _FAR).all():
        raise DamagedFileError(f"{file}: holds no plan: its control points must be finite and at most {_FAR:g} rad")
    if duration != scenario.mission.duration:
        raise DamagedFileError(f"{file}: holds no plan for {scenario.mission.duration:g} s, but for {duration:g} s")
    spline = AttitudeSpline(duration, control)
    certificate = certify(spline, scenario, scenario.planning.certificate_rate)
    if not certificate.holds:
        raise DamagedFileError(f"{file}: this plan breaks a limit: {certificate.broken}")
    _compare(_as_arrays(certificate), arrays, file)
    return spline


def _as_arrays(certificate: Certificate) -> dict[str, Array]:
    return {f"certificate_{name}": np.array(value, float) for name, value in asdict(certificate).items()}


def _compare(computed: dict[str, Array], arrays: dict[str, Array], file: Path) -> None:
    """Raises DamagedFileError unless a kept certificate is the computed one, or there is none at all."""
    if not any(name.startswith("certificate") for name in arrays):
        return
    for name, value in computed.items():
        kept = arrays.get(name)
        if kept is None or kept.dtype != np.float64 or kept.shape != value.shape:
            raise DamagedFileError(f"{file}: holds no whole certificate: {name} is missing, or of another type")
        if not np.allclose(kept, value, rtol=_ROUNDING, atol=_ROUNDING):
            raise DamagedFileError(f"{file}: this plan is not as it was certified: {name} was {kept}, now is {value}")
