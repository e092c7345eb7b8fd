"""What commands print: results on stdout, progress and errors on stderr, one JSON object when asked for."""

import json
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

# rich is imported where it is used: with --json nothing needs it.


def screen() -> "Console":
    """Return the console for results."""
    from rich.console import Console

    return Console(file=sys.stdout, highlight=False)


def write_json(value: Mapping[str, Any]) -> None:
    """Print exactly one JSON object on one line. NaN and infinity are refused: they are no JSON."""
    sys.stdout.write(json.dumps(value, ensure_ascii=False, allow_nan=False) + "\n")
    sys.stdout.flush()


def write_error(sentence: str) -> None:
    """Print one line on stderr, with the command's name in front."""
    sys.stderr.write(f"caramelo: {' '.join(sentence.split())}\n")
    sys.stderr.flush()


def write_note(what: str) -> None:
    """Tell on stderr what is being done, if somebody watches."""
    if sys.stderr.isatty():
        sys.stderr.write(f"{what} ...\n")
        sys.stderr.flush()


@contextmanager
def progress(title: str, total: float) -> Iterator[Callable[[float], None]]:
    """Yield a function to be called with the part of ``total`` done so far; a bar shows it on a terminal only."""
    if not sys.stderr.isatty():
        yield lambda done: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(file=sys.stderr), transient=True) as bar:
        task = bar.add_task(title, total=total)
        yield lambda done: bar.update(task, completed=done)
