"""The drawings: one file, one Diagram. `BUILDERS` names them; `SCENARIOS` is the file of named scenarios."""

from collections.abc import Callable
from pathlib import Path

from pydrake.systems.framework import Diagram

from a2s_drake.checks import ScenarioError
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
            text = path.read_text(encoding="utf-8")
        except OSError as error:
            raise ScenarioError(f"{path}: {error.strerror}") from error
        except UnicodeDecodeError as error:
            raise ScenarioError(f"{path}: is not UTF-8 text") from error
        return Scenario.from_yaml(text, source=str(path))
    if path.is_file():
        raise ScenarioError(f"{path}: a scenario file ends in .yaml or .yml")
    return Scenario.from_yaml(SCENARIOS.read_text(encoding="utf-8"), name=name_or_path, source=SCENARIOS.name)


__all__ = ["BUILDERS", "SCENARIOS", "load_scenario"]
