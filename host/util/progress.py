"""Progress of a command that works on many cases for minutes: a bar on a terminal, else lines on stderr."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from .console import progress

# Called with the number of the case, the number of cases, and the case's name if it has one.
Tell = Callable[[int, int, str], None]


@contextmanager
def cases(title: str) -> Iterator[Tell]:
    """Yield the function to call for each case; stdout stays free for the result."""
    with progress(title, 1.0) as bar:

        def tell(number: int, total: int, name: str = "") -> None:
            bar(number / total, name)
            if not sys.stderr.isatty():
                write_step(f"{title}: {number} of {total}{': ' if name else ''}{name}")

        yield tell


@contextmanager
def stages(title: str, quiet: bool = False) -> Iterator[Callable[[str, float], None]]:
    """Yield the function to call with each stage and its progress, 0 .. 1; ``quiet``: no lines."""
    last = ""
    with progress(title, 1.0) as bar:

        def tell(what: str, done: float) -> None:
            nonlocal last
            bar(done, what)
            if what != last and not quiet and not sys.stderr.isatty():
                write_step(f"{title}: {what}")
            last = what

        yield tell


def write_step(what: str) -> None:
    """Print the next step of a long command on stderr."""
    sys.stderr.write(f"{what}\n")
    sys.stderr.flush()
