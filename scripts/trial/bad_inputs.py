"""Bad inputs: one of a number, over all their kinds in turn."""

from dataclasses import replace
from random import Random

from scripts.trial.bad_commands import BAD_COMMANDS, ODD_COMMANDS
from scripts.trial.bad_files import BAD_FILES
from scripts.trial.bad_values import BAD_VALUES
from scripts.trial.case import Case

_KINDS = BAD_VALUES | BAD_FILES | BAD_COMMANDS | ODD_COMMANDS


def bad_case(seed: int, number: int) -> Case:
    """The bad input of a number."""
    rng = Random(f"bad {seed} {number}")
    kind = list(_KINDS)[number % len(_KINDS)]
    return replace(_KINDS[kind](rng), kind=f"bad, {kind}", must_refuse=kind not in ODD_COMMANDS)
