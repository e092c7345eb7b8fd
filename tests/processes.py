"""Processes that tests start: what they have started themselves, and that they hear what ends them."""

import contextlib
import signal
from pathlib import Path


def children_of(pid):
    """Return the numbers of a process's children, whichever of its threads started them; none if it has ended."""
    found = set()
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        found |= set(task.read_text().split())
    return found


def child_of(pid, words):
    """Return the number of the child of a process whose command line holds some words."""
    for child in children_of(pid):
        with contextlib.suppress(OSError):
            if words in Path(f"/proc/{child}/cmdline").read_text().replace("\0", " "):
                return int(child)
    raise LookupError(f"{pid} has no child {words}")


def hear_signals():
    """For Popen's ``preexec_fn``: what a shell starts behind it is deaf to Ctrl-C, what nohup starts to SIGHUP."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
