"""How a script that fails says so: one line of error, and the exit code that belongs to it."""

import sys

from a2s_drake import FlightInterrupted, ScenarioError
from a2s_drake.common.files import in_words
from scripts.common import UsageError


def exit_code(error: BaseException) -> int:
    """130 where the user interrupted; 2 for input that cannot be worked with; 1 for everything else.

    An error of none of these kinds gets the code of the error that it was raised from.
    """
    if isinstance(error, KeyboardInterrupt | FlightInterrupted):
        return 130
    if isinstance(error, UsageError | ScenarioError):
        return 2
    return 1 if error.__cause__ is None else exit_code(error.__cause__)


def reason(error: BaseException) -> str:
    """An error in words; a file's with its name, and `interrupted` for Ctrl-C, which has no words of its own."""
    return (in_words(error) if isinstance(error, Exception) else str(error)) or "interrupted"


def fail(error: BaseException, words: str = "") -> int:
    """Prints an error, or the words for it, on one line of standard error; returns the exit code."""
    print(f"error: {words or reason(error)}", file=sys.stderr)
    return exit_code(error)
