"""Draw: the case of a label, always the same for one seed."""

import re
from dataclasses import replace

from scripts.trial.bad_inputs import bad_case
from scripts.trial.case import Case
from scripts.trial.scenarios import scenario_case

_DRAWN = {"s": scenario_case, "b": bad_case}
# One case in so many runs in an interpreter of its own, exactly as typed.
_FRESH_EVERY, _FRESH_FIRST = 50, 7


def labels(scenarios: int, bad: int) -> list[str]:
    """The labels of the first random scenarios and the first bad inputs, in turn, so that both are met early."""
    pairs = ((f"s{k}" if k < scenarios else "", f"b{k}" if k < bad else "") for k in range(max(scenarios, bad)))
    return [label for pair in pairs for label in pair if label]


def case_of(label: str, seed: int) -> Case:
    """The case of a label: s (scenario) or b (bad input) and a number.

    Raises:
      ValueError: for another label.
    """
    if not re.fullmatch("[sb][0-9]{1,9}", label):
        raise ValueError(f"{label!r}: must be s or b and a number, such as s17 or b17")
    number = int(label[1:])
    case = _DRAWN[label[0]](seed, number)
    typeable = not any("\0" in text for text in case.arguments)
    return replace(case, label=label, fresh=typeable and number % _FRESH_EVERY == _FRESH_FIRST)
