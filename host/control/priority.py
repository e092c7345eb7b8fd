"""Asks the system to run the loop before everything else; if it refuses, the loop runs like any program."""

import os
from contextlib import suppress

LEVEL = 10
NICE = -10


def ask() -> str:
    """Ask for real-time scheduling, else for a better nice value; return the result in words."""
    with suppress(OSError, AttributeError):
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(LEVEL))
        return "real-time"
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, 0, NICE)
        return f"nice {NICE}"
    return "like any program; as a service it gets real-time (docs/teleop.md)"


def give_back(nicer: int) -> None:
    """Stay below the loop that started this process: at ordinary priority if the loop was raised, else by ``nicer``."""
    if os.sched_getscheduler(0) == os.SCHED_OTHER and os.getpriority(os.PRIO_PROCESS, 0) >= 0:
        os.nice(nicer)
        return
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    os.setpriority(os.PRIO_PROCESS, 0, 0)
