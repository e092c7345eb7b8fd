"""Errors in the library's words: every exception that it raises on purpose is a caramelo.Error."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf, isinf, nan
from numbers import Real

from ..util.errors import UserError
from ..util.extras import missing_library

_FLAG = re.compile(r"(?<!\S)--([a-z][a-z-]*)")  # an option of the command line
_CALLED = {"log": "record"}  # options that the library names differently


class Error(Exception):
    """The library refused something or did not achieve it; the text is one sentence."""


class BadValue(Error, ValueError):
    """A wrong argument: its name, its value, and what is allowed. Nothing has moved."""


class NotAchieved(Error):
    """The robot did not do what it was told: says what it did instead, and why."""


class Fault(Error):
    """The robot stopped by itself, or was stopped: gives the first cause. It stays stopped until ``reset``."""


for _each in (Error, BadValue, NotAchieved, Fault):
    _each.__module__ = "caramelo"  # the name by which programs catch it, so that a traceback shows the same


@contextmanager
def own_words() -> Iterator[None]:
    """Turn an error of the command line into an Error that names the library's arguments instead of options."""
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
    """Replace options by the arguments' names, except in a command to type."""
    told, command, options = text.partition("caramelo ")
    return _FLAG.sub(lambda found: _CALLED.get(found[1], found[1].replace("-", "_")), told) + command + options


def finite(name: str, value: object, low: float, high: float, unit: str) -> float:
    """Return a number within its range, or raise BadValue with its name."""
    found = number(value)
    if not low <= found <= high:
        kind = "" if isinstance(value, Real) else "a number within "
        raise BadValue(f"{name} {shown(value)}: allowed {kind}{low:.4g} .. {high:.4g} {unit}".rstrip())
    return found


def number(value: object) -> float:
    """Return a real number, such as one of numpy's, as a float: NaN for anything else, inf beyond all floats."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return nan
    try:
        return float(value)
    except OverflowError:
        return inf


def shown(value: object) -> str:
    """Return a wrong value as one short line; an integer beyond all floats may have too many digits to print."""
    return "inf" if isinf(number(value)) else " ".join(repr(value).split())[:40]
