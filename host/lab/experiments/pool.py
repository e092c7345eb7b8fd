"""Trials in parallel processes: results in the order of the tasks, whatever finishes first and however many jobs."""

import signal
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any, Protocol

from ...util.leave import LEAVE_SIGNALS

_LEAVE = (signal.SIGINT, *LEAVE_SIGNALS)


class Task(Protocol):
    """One piece of work; it and its answer travel between processes. Its answer depends on itself alone."""

    def run(self) -> Any:
        """Do it."""


def run_all(tasks: Sequence[Task], jobs: int, done: Callable[[int], None]) -> list[Any]:
    """Run all tasks in ``jobs`` processes and return their answers in order; ``done`` hears how many are ready.

    The first error of a task is raised after dropping the rest. Ctrl-C drops everything.
    """
    if jobs == 1 or len(tasks) < 2:
        answers = []
        for task in tasks:
            answers.append(task.run())
            done(len(answers))
        return answers
    pool = ProcessPoolExecutor(min(jobs, len(tasks)), initializer=_obey_ctrl_c)
    try:
        # A signal that came to a worker before it dies of it would be lost in a hook of Python's: it waits till then.
        held = signal.pthread_sigmask(signal.SIG_BLOCK, _LEAVE)
        try:
            futures = [pool.submit(_run, task) for task in tasks]
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, held)
        for ready, future in enumerate(as_completed(futures), 1):
            future.result()
            done(ready)
        return [future.result() for future in futures]
    except BaseException:
        for process in list((pool._processes or {}).values()):
            process.terminate()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)  # else what still runs at exit may find its pipes closed


def _obey_ctrl_c() -> None:
    """A worker dies of Ctrl-C and the like at once and in silence; the parent tells the user."""
    for number in _LEAVE:
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _LEAVE)


def _run(task: Task) -> Any:
    return task.run()
