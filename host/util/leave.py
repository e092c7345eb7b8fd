"""A command ends on SIGTERM or SIGHUP (the terminal is gone) as with Ctrl-C: nothing is left behind."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

LEAVE_SIGNALS = (signal.SIGTERM, signal.SIGHUP)


@contextmanager
def heard_signals() -> Iterator[list[int]]:
    """Raise KeyboardInterrupt in the block at the first of the signals; yield the numbers heard.

    An ignored signal stays ignored, as nohup needs. Only the main thread receives signals.
    """
    heard: list[int] = []

    def leave(number: int, frame: FrameType | None) -> None:
        heard.append(number)
        if len(heard) == 1:  # a second one must not disturb the clean-up
            raise KeyboardInterrupt

    main = threading.current_thread() is threading.main_thread()
    mine = [number for number in LEAVE_SIGNALS if main and signal.getsignal(number) is signal.SIG_DFL]
    try:
        for number in mine:
            signal.signal(number, leave)
        yield heard
    finally:
        for number in mine:
            signal.signal(number, signal.SIG_DFL)


@contextmanager
def leaving_later() -> Iterator[None]:
    """Let SIGTERM and SIGHUP wait for the end of the block: for what can't be left half-way."""
    late: list[int] = []
    before = {number: signal.getsignal(number) for number in LEAVE_SIGNALS}
    heard = [number for number in LEAVE_SIGNALS if callable(before[number])]
    for number in heard:
        signal.signal(number, lambda number, frame: late.append(number))
    try:
        yield
    finally:
        for number in heard:
            signal.signal(number, before[number])
        for due in late:
            signal.raise_signal(due)
