"""What goes wrong, in the library's words: every exception that it raises on purpose is a caramelo.Error."""

import re
from collections.abc import Iterator
from contextlib import contextmanager

from ..util.errors import UserError
from ..util.extras import missing_library

_FLAG = re.compile(r"(?<!\S)--([a-z][a-z-]*)")  # an option of the command line
_CALLED = {"log": "record"}  # what the library calls otherwise


class Error(Exception):
    """Anything that the library refuses or does not achieve; the text is one sentence."""


class BadValue(Error, ValueError):
    """An argument that is not allowed: which, its value, and what is. Nothing has moved."""


class NotAchieved(Error):
    """The robot did not do what it was told: what it did instead, and why."""


class Fault(Error):
    """The robot stopped by itself, or was stopped: the first cause. It stays so until ``reset``."""


for _each in (Error, BadValue, NotAchieved, Fault):
    _each.__module__ = "caramelo"  # as whoever catches it calls it, and as a traceback does then


@contextmanager
def own_words() -> Iterator[None]:
    """Turn what the command line would say into an Error: options are called as the library's arguments are."""
    try:
        yield
    except UserError as error:
        raise Error(_renamed(str(error))) from None
    except ModuleNotFoundError as error:
        missing = missing_library(error)
        if missing is None:
            raise
        raise Error(str(missing)) from None


def _renamed(text: str) -> str:
    """Call options as the arguments are; a command that is to be typed keeps its own."""
    told, command, options = text.partition("caramelo ")
    return _FLAG.sub(lambda found: _CALLED.get(found[1], found[1].replace("-", "_")), told) + command + options


def finite(name: str, value: object, low: float, high: float, unit: str) -> float:
    """Return a number within its range, or raise BadValue that names it."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise BadValue(f"{name} {value!r}: allowed {low:.4g} .. {high:.4g} {unit}".rstrip())
    return float(value)
