"""The kinds of value that a robot file may hold; each one's error says what is allowed, with the unit.

They are pydantic validators: an error's message is the part of the line after ``value ...:``.
"""

import re
from collections.abc import Callable
from math import inf
from typing import Any

from pydantic import BaseModel, BeforeValidator, ConfigDict
from pydantic_core import PydanticCustomError

LINE = r"[^\x00-\x1f\x7f-\x9f]{1,200}"  # one line of text, without control characters for a terminal


class Table(BaseModel):
    """Common to all tables: unknown keys are errors, and nothing changes after loading."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def _only(
    fits: Callable[[Any], object], allowed: str, made: Callable[[Any], object] = lambda value: value
) -> BeforeValidator:
    """Accept a value if it ``fits``, converted by ``made``; else the error says what is allowed."""

    def check(value: object) -> object:
        if not fits(value):
            raise PydanticCustomError("allowed", "{allowed}", {"allowed": allowed})
        return made(value)

    return BeforeValidator(check)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and -inf < value < inf


def _range_text(low: float, high: float, unit: str) -> str:
    return f"{low:g} .. {high:g} {unit}".rstrip()


def number(low: float, high: float, unit: str = "") -> BeforeValidator:
    """A finite number from ``low`` to ``high``, both included."""
    allowed = "a number within " + _range_text(low, high, unit)
    return _only(lambda value: _is_number(value) and low <= value <= high, allowed, float)


def whole(low: int, high: int, unit: str = "") -> BeforeValidator:
    """A whole number from ``low`` to ``high``, both included."""
    return _only(lambda value: type(value) is int and low <= value <= high,
                 f"a whole number within {low} .. {high} {unit}".rstrip())


def numbers(count: int, low: float, high: float, unit: str, names: str) -> BeforeValidator:
    """A list of ``count`` finite numbers within ``low`` .. ``high``; ``names`` says what they are."""

    def fits(value: object) -> bool:
        listed = isinstance(value, list) and len(value) == count
        return listed and all(_is_number(item) and low <= item <= high for item in value)  # type: ignore[attr-defined]

    return _only(fits, f"{count} numbers [{names}] within {_range_text(low, high, unit)}", _floats)


def rising(low_deg: float, high_deg: float) -> BeforeValidator:
    """A list [lowest, highest] of angles within ``low_deg`` .. ``high_deg``, lowest below highest."""

    def fits(value: object) -> bool:
        pair = isinstance(value, list) and len(value) == 2 and all(map(_is_number, value))
        return pair and low_deg <= value[0] < value[1] <= high_deg  # type: ignore[index]

    return _only(fits, f"[lowest, highest] with lowest < highest, both within {low_deg:g} .. {high_deg:g} deg", _floats)


def _floats(values: list[float]) -> tuple[float, ...]:
    return tuple(map(float, values))


def one_of(*allowed: object) -> BeforeValidator:
    """Exactly one of a few values; 1 is not true."""

    def same(value: object) -> list[object]:
        return [choice for choice in allowed if value == choice
                and (type(value) is type(choice) or (_is_number(value) and _is_number(choice)))]

    return _only(same, "one of " + ", ".join(show(choice) for choice in allowed), lambda value: same(value)[0])


def text(pattern: str, allowed: str) -> BeforeValidator:
    """A string that matches the whole ``pattern``; ``allowed`` says it in words."""
    return _only(lambda value: isinstance(value, str) and re.fullmatch(pattern, value), allowed)


def body_axes() -> BeforeValidator:
    """Three sensor axes with sign that point along the body's x, y, z: a rotation, not a mirror image."""
    allowed = 'three of "+x", "-x", "+y", "-y", "+z", "-z" that form a right-handed set'
    return _only(lambda value: isinstance(value, list) and _handedness(value) == 1, allowed, tuple)


def _handedness(axes: list[object]) -> int:
    """Return +1 for a right-handed set of three signed axes, -1 for a left-handed one, 0 for anything else."""
    if len(axes) != 3 or any(axis not in ("+x", "-x", "+y", "-y", "+z", "-z") for axis in axes):
        return 0
    order = "".join(str(axis)[1] for axis in axes)
    if len(set(order)) != 3:
        return 0
    sign = 1 if order in ("xyz", "yzx", "zxy") else -1
    return -sign if sum(str(axis)[0] == "-" for axis in axes) % 2 else sign


def show(value: object) -> str:
    """Return a value as TOML writes it, on one line and shortened."""
    if isinstance(value, bool):
        return "true" if value else "false"
    line = '"' + " ".join(value.split()) + '"' if isinstance(value, str) else " ".join(repr(value).split())
    return line if len(line) <= 60 else line[:57] + "..."
