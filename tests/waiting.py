"""Waiting for an event of another process, thread or board: the one place where a test lets time pass.

tests/test_waiting.py finds sleeps, clocks and waits without a bound anywhere else.
"""

import time
from collections.abc import Callable
from typing import TypeVar

Found = TypeVar("Found")

PATIENCE_S = 60.0  # what is due within a second takes so long only when something is wrong
LOOK_S = 0.005


def wait_until(
    happened: Callable[[], Found],
    what: Callable[[], object] | str,
    patience_s: float = PATIENCE_S,
    every_s: float = LOOK_S,
) -> Found:
    """Ask every ``every_s`` whether it has happened, and return the first true answer.

    AssertionError after ``patience_s``, with ``what``: a sentence, or a function that says how things stand by then.
    """
    ends_s = time.monotonic() + patience_s
    while not (found := happened()):
        assert time.monotonic() < ends_s, f"not within {patience_s:g} s: {what() if callable(what) else what}"
        time.sleep(every_s)
    return found


def stays(quiet: Callable[[], bool], seconds: float) -> bool:
    """Return whether it stays so for that long: for tests whose subject is that nothing happens."""
    ends_s = time.monotonic() + seconds
    while quiet():
        if time.monotonic() > ends_s:
            return True
        time.sleep(LOOK_S)
    return False


def let_pass(seconds: float) -> None:
    """Let time pass before the test itself does something, so that it comes at another phase; never to wait."""
    time.sleep(seconds)
