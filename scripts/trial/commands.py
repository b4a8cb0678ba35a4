"""Commands: how a scenario, or one field of it, is handed to a script that is drawn at random."""

from collections.abc import Mapping
from random import Random

from scripts.trial.case import Case

# The scripts that fly a scenario of one's own; three cases of four go to the first.
_FLYING = ("simulate", "compare", "robustness", "benchmark")

SHORT = ("--duration", "0.2")
OUT = ("--out", "out")


def scenario_command(
    rng: Random, scenario: str, overrides: tuple[str, ...] = (), files: Mapping[str, bytes] | None = None
) -> Case:
    """A scenario for one of the scripts that take one; a flight that takes place after all is short."""
    setting = ("--set", *overrides) if overrides else ()
    # Which wins over a field that is set, and would make a scenario sound again.
    short = () if any("simulation" in text for text in (*overrides, str(files))) else SHORT
    if rng.random() < 0.1:
        command = ("closed_loop", "--scenario", scenario, *setting, "--out", "out.txt")
        return Case(command, files or {}, script="show_diagram")
    script = "simulate" if rng.random() < 0.75 else rng.choice(_FLYING)
    return Case((scenario, *setting, *short, *OUT), files or {}, script=script)


def setting_command(rng: Random, name: str, text: str) -> Case:
    """One field set to a text of YAML, as an override or in a file."""
    section, _, field = name.partition(".")
    if rng.random() < 0.1:
        return Case(("table_1", "--set", f"{name}={text}", *OUT), script="missions")
    if rng.random() < 0.5:
        return scenario_command(rng, "paper", (f"{name}={text}",))
    content = f"{section}:\n  {field}: {text}\n".encode(errors="surrogateescape")
    return scenario_command(rng, "scenario.yaml", (), {"scenario.yaml": content})
