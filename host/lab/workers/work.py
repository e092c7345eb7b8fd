"""The interface of workers: answers come in the order of the tasks, whichever finishes first."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol

from ...util.errors import UserError


class Task(Protocol):
    """One piece of work; it and its answer travel between processes. Its answer depends only on itself."""

    def run(self) -> Any:
        """Do it."""


class Workers(Protocol):
    """Who runs tasks."""

    def run_all(self, tasks: Sequence[Task], done: Callable[[int], None]) -> list[Any]:
        """Run all tasks and return their answers in order; ``done`` gets the number of finished ones.

        The first error of a task is raised after dropping the rest.
        """


class Here:
    """This process."""

    def run_all(self, tasks: Sequence[Task], done: Callable[[int], None]) -> list[Any]:
        """See Workers."""
        answers = []
        for task in tasks:
            answers.append(task.run())
            done(len(answers))
        return answers


@contextmanager
def workers(jobs: int = 1, cluster: str = "") -> Iterator[Workers]:
    """Yield the workers: ``jobs`` processes of this computer, or the cluster at an address if there is one.

    Ctrl-C drops running tasks. UserError if the cluster can't be used.
    """
    if cluster and jobs > 1:
        raise UserError(f"--jobs {jobs}: not with --cluster, whose own workers do the work")
    if jobs == 1 and not cluster:
        yield Here()
        return
    from .cluster import local_cluster, standing_cluster

    with standing_cluster(cluster) if cluster else local_cluster(jobs) as found:
        yield found
