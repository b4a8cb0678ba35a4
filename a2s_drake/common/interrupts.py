"""Interrupts: signals that ask this process to end, put off while something must not be cut in two."""

import contextlib
import signal
import threading
import time
from collections.abc import Iterator
from types import FrameType

# Ctrl-C, what `kill` and job schedulers send, and what a closing terminal sends.
ENDING_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

# Signals of one request can arrive twice, from a terminal and from a program that passes them on: within this time, s.
ONE_REQUEST = 1.0


@contextlib.contextmanager
def interrupts_put_off() -> Iterator[None]:
    """Puts off what SIGINT, SIGTERM and SIGHUP do in Python until the block is left.

    Signals that are ignored, or that end the process without Python, stay as they are. So does everything in threads
    other than the main one, which hear no signals. A second signal, later than `ONE_REQUEST`, is answered at once.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    answers = {number: answer for number in ENDING_SIGNALS if callable(answer := signal.getsignal(number))}
    heard: list[tuple[int, float]] = []

    def note(number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if heard and now - heard[0][1] > ONE_REQUEST:
            heard.clear()
            answers[signal.Signals(number)](number, frame)
        elif not heard:
            heard.append((number, now))

    def pass_on() -> None:
        if heard:
            signal.raise_signal(heard[0][0])

    # A stack undoes all that was done, even where a signal arrives in the middle of it.
    with contextlib.ExitStack() as undo:
        undo.callback(pass_on)
        for number, answer in answers.items():
            undo.callback(signal.signal, number, answer)
            signal.signal(number, note)
        yield


@contextlib.contextmanager
def deaf_offspring(number: signal.Signals) -> Iterator[None]:
    """Blocks a signal in this thread. Processes and threads that it starts meanwhile never hear that signal."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {number})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
