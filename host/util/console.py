"""The commands' output: results on stdout, progress and errors on stderr, one JSON object with --json.

A text may come from a file, a board or the network and contain control characters; they are never printed raw.
"""

import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, TextIO

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

# rich is imported where it is used: with --json nothing needs it.


def plain(text: str) -> str:
    """Return a text that a terminal only shows: writes unprintable characters as escapes, except tabs and line ends.

    They are all control characters (ESC and C1 among them), changes of the writing direction, half a surrogate.
    """
    if text.isprintable():
        return text
    return "".join(char if char.isprintable() or char in "\n\t" else ascii(char)[1:-1] for char in text)


def screen() -> "Console":
    """Return the console for results: its input is text, never markup (use rich's Text for a style)."""
    return _console(sys.stdout)


def _console(file: TextIO) -> "Console":
    from rich.console import Console
    from rich.segment import Segment

    class PlainConsole(Console):
        def render(self, *args: Any, **options: Any) -> Iterable[Segment]:
            for segment in super().render(*args, **options):
                yield segment if segment.control else Segment(plain(segment.text), segment.style)

    return PlainConsole(file=file, highlight=False, markup=False, emoji=False)


def make_table(head: Sequence[str], rows: Iterable[Sequence[object]], caption: str = "") -> "Table":
    """Return rows of cells (rich's Text, or anything with str()) below a head; without a head the first is bold."""
    from rich.table import Table
    from rich.text import Text

    table = Table(*head, box=None, pad_edge=False, show_header=bool(head), caption=caption or None,
                  caption_justify="left")
    if not head:
        table.add_column(style="bold")
    for row in rows:
        table.add_row(*(cell if isinstance(cell, Text) else str(cell) for cell in row))
    return table


def print_table(head: Sequence[str], rows: Iterable[Sequence[object]], width: int = 0) -> None:
    """Print a table on stdout (see make_table), in ``width`` columns even if the terminal is narrower."""
    console = screen()
    console.width = max(console.width, width)
    console.print(make_table(head, rows), soft_wrap=bool(width))


@contextmanager
def live_table() -> Iterator[Callable[["Table"], None]]:
    """Yield a function that shows a table on stdout: on a terminal in place, else only the last one, at the end."""
    from rich.live import Live

    console = screen()
    try:
        with Live(console=console, auto_refresh=False) as live:
            yield lambda table: live.update(table, refresh=True)
    finally:
        if not console.is_terminal:
            console.line()  # that Live leaves out


def tell_written(paths: Iterable[object]) -> None:
    """Print which files were written."""
    for path in paths:
        screen().print(f"wrote {path}", soft_wrap=True)


def say(text: str) -> None:
    """Print a text and the end of its line on stdout."""
    sys.stdout.write(f"{plain(text)}\n")
    sys.stdout.flush()


def write_json(value: Mapping[str, Any]) -> None:
    """Print exactly one JSON object on one line. NaN and infinity are refused: they are not JSON."""
    line = json.dumps(value, ensure_ascii=False, allow_nan=False)
    # Unprintable characters occur only in strings, where JSON has escapes for them.
    say("".join(char if char.isprintable() else json.dumps(char)[1:-1] for char in line))


def end_output() -> str:
    """Flush stdout; return "", or in one line why that fails: then all later output is dropped."""
    try:
        sys.stdout.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return f"the output can't be written: {error.strerror or error}"
    return ""


def write_error(sentence: str) -> None:
    """Print one line on stderr, with the command's name in front."""
    with suppress(OSError):  # a terminal that is gone, a full disk: nobody could read it
        sys.stderr.write(f"caramelo: {plain(' '.join(sentence.split()))}\n")
        sys.stderr.flush()


def write_note(what: str) -> None:
    """Print on stderr what the command is doing, if it is a terminal."""
    if sys.stderr.isatty():
        sys.stderr.write(f"{plain(what)} ...\n")
        sys.stderr.flush()


@contextmanager
def progress(title: str, total: float) -> Iterator[Callable[..., None]]:
    """Yield a function to call with the part of ``total`` done so far; only on a terminal a bar shows it.

    A text as second argument appears behind the title.
    """
    if not sys.stderr.isatty():
        yield lambda done, what="": None
        return
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    what = TextColumn("{task.description}", markup=False)
    columns = (what, BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=_console(sys.stderr), transient=True) as bar:
        task = bar.add_task(title, total=total)
        yield lambda done, what="": bar.update(task, completed=done, description=f"{title} {what}".rstrip())
