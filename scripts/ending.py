"""How a script ends when it is asked to: by Ctrl-C, by `kill` or by a terminal that closes.

Import only fast modules here. Signals are not answered before this module is loaded.
"""

import os
import signal
import sys
import time
from collections.abc import Callable
from types import FrameType

from a2s_drake.common.interrupts import ENDING_SIGNALS, ONE_REQUEST

# After which time to interrupt again where Python could not pass an interrupt on, s.
_AGAIN = 0.05


def listen(answer: Callable[[int, FrameType | None], object] | signal.Handlers) -> None:
    """Sets what answers to the signals that ask a process to end, but for those that the caller has it ignore."""
    for number in ENDING_SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, answer)


def end_at_once(number: int, _frame: FrameType | None) -> None:
    """Ends the process with one line, where there is nothing to keep."""
    try:
        os.write(2, b"error: interrupted\n")
    finally:
        os._exit(128 + number)


class Interruption:
    """The answer to signals while a script works: the first raises KeyboardInterrupt, as Ctrl-C does in Python.

    A second one, more than a moment later, ends the process at once: somebody does not want to wait for the end.
    """

    def __init__(self) -> None:
        self._number, self._time = 0, 0.0

    def __call__(self, number: int, _frame: FrameType | None) -> None:
        """Raises KeyboardInterrupt at the first signal; ends the process at a later one."""
        if self._number == 0:
            self._number, self._time = number, time.monotonic()
            raise KeyboardInterrupt
        if time.monotonic() - self._time > ONE_REQUEST:
            end_at_once(self._number, None)

    def __bool__(self) -> bool:
        """Whether there was a signal."""
        return self._number != 0

    def code(self, code: int) -> int:
        """The exit code of a script that would end with the given one: by 128 and the signal where it is 130."""
        return 128 + self._number if self and code == 130 else code

    def begin(self) -> None:
        """Listens from now on."""
        sys.unraisablehook = self._answer_to_lost
        listen(self)

    def end(self) -> None:
        """Ignores signals from now on, when what is left of the script is over in a moment."""
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        listen(signal.SIG_IGN)

    def _answer_to_lost(self, lost: "sys.UnraisableHookArgs") -> None:
        """Interrupts again where Python drops an interrupt, as it does in a finaliser."""
        if lost.exc_type is not KeyboardInterrupt:
            sys.__unraisablehook__(lost)
            return
        # Not now: this hook belongs to what is dropped.
        signal.signal(signal.SIGALRM, _interrupt)
        signal.setitimer(signal.ITIMER_REAL, _AGAIN)


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt
