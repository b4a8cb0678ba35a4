"""The drawings: one file, one Diagram. `BUILDERS` names them; `SCENARIOS` is the file of named scenarios."""

import os
from collections.abc import Callable
from pathlib import Path

from pydrake.systems.framework import Diagram

from a2s_drake.checks import ScenarioError
from a2s_drake.files import DamagedFileError, read_text
from a2s_drake.scenario import Scenario
from diagrams.airframe_only import build_airframe_only
from diagrams.closed_loop import build_closed_loop
from diagrams.link_only import build_link_only

BUILDERS: dict[str, Callable[[Scenario], Diagram]] = {
    "closed_loop": build_closed_loop,
    "link_only": build_link_only,
    "airframe_only": build_airframe_only,
}

SCENARIOS = Path(__file__).with_name("scenarios.yaml")


def load_scenario(name_or_path: str) -> Scenario:
    """A scenario by its name in `scenarios.yaml`, or from a YAML file of one's own. Does not validate.

    Raises:
      ScenarioError: for an unknown name, or a file that cannot be read or does not hold a scenario.
    """
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml"):
        try:
            text = read_text(path)
        except OSError as error:
            raise ScenarioError(f"{path}: {error.strerror}") from error
        except DamagedFileError as error:
            raise ScenarioError(error) from error
        return Scenario.from_yaml(text, source=str(path))
    if os.path.isfile(path):  # noqa: PTH113  Python 3.11's `Path.is_file` refuses names that are too long
        raise ScenarioError(f"{path}: a scenario file ends in .yaml or .yml")
    return Scenario.from_yaml(SCENARIOS.read_text(encoding="utf-8"), name=name_or_path, source=SCENARIOS.name)


__all__ = ["BUILDERS", "SCENARIOS", "load_scenario"]
