"""The drawings: one file, one Diagram. `BUILDERS` names them; `SCENARIOS` is the file of named scenarios."""

import os
from collections.abc import Callable
from pathlib import Path

from pydrake.systems.framework import Diagram

from a2s_drake.common.quoting import PATH_LENGTH, one_line
from a2s_drake.scenario.checks import ScenarioError
from a2s_drake.scenario.scenario import Scenario

from .airframe_only import build_airframe_only
from .blocks import Blocks
from .closed_loop import build_closed_loop
from .link_only import build_link_only

BUILDERS: dict[str, Callable[[Scenario], Diagram]] = {
    "closed_loop": build_closed_loop,
    "link_only": build_link_only,
    "airframe_only": build_airframe_only,
}

# How the name of a scenario file may end.
SUFFIXES = (".yaml", ".yml")

SCENARIOS = Path(__file__).with_name("scenarios.yaml")


def load_scenario(name_or_path: str) -> Scenario:
    """A scenario by its name in `scenarios.yaml`, or from a YAML file of one's own. Does not validate.

    The names of files in a YAML file are relative to its folder.

    Raises:
      ScenarioError: for an unknown name, or a file that cannot be read or does not hold a scenario.
    """
    path = Path(name_or_path)
    shown = one_line(str(path), PATH_LENGTH)
    if path.suffix in SUFFIXES:
        try:
            return Scenario.load(path)
        except OSError as error:
            raise ScenarioError(f"{shown}: {error.strerror}") from error
    if os.path.isfile(path):  # noqa: PTH113  Python 3.11's `Path.is_file` refuses names that are too long
        raise ScenarioError(f"{shown}: a scenario file ends in .yaml or .yml")
    text = SCENARIOS.read_text(encoding="utf-8")
    return Scenario.from_yaml(text, name=name_or_path, source=SCENARIOS.name, folder=SCENARIOS.parent)


__all__ = [
    "BUILDERS",
    "Blocks",
    "SCENARIOS",
    "SUFFIXES",
    "build_airframe_only",
    "build_closed_loop",
    "build_link_only",
    "load_scenario",
]
