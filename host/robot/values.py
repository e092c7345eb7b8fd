"""The kinds of value that a robot file may hold; each says in its error what is allowed, with the unit.

They are pydantic validators: an error's message is the part of the line after ``value ...:``.
"""

import re
from math import inf

from pydantic import BaseModel, BeforeValidator, ConfigDict
from pydantic_core import PydanticCustomError

LINE = r"[^\x00-\x1f\x7f-\x9f]{1,200}"  # one line for people: nothing that steers a terminal


class Table(BaseModel):
    """Common to all tables: unknown keys are errors and nothing changes after loading."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def _fail(allowed: str) -> PydanticCustomError:
    return PydanticCustomError("allowed", "{allowed}", {"allowed": allowed})


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and -inf < value < inf


def _range_text(low: float, high: float, unit: str) -> str:
    return f"{low:g} .. {high:g} {unit}".rstrip()


def number(low: float, high: float, unit: str = "") -> BeforeValidator:
    """A finite number from ``low`` to ``high``, both included."""

    def check(value: object) -> object:
        if not _is_number(value) or not low <= value <= high:  # type: ignore[operator]
            raise _fail("a number within " + _range_text(low, high, unit))
        return float(value)  # type: ignore[arg-type]

    return BeforeValidator(check)


def whole(low: int, high: int, unit: str = "") -> BeforeValidator:
    """A whole number from ``low`` to ``high``, both included."""

    def check(value: object) -> object:
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            raise _fail(f"a whole number within {low} .. {high} {unit}".rstrip())
        return value

    return BeforeValidator(check)


def numbers(count: int, low: float, high: float, unit: str, names: str) -> BeforeValidator:
    """A list of ``count`` finite numbers within ``low`` .. ``high``; ``names`` says what they are."""

    def check(value: object) -> object:
        wanted = f"{count} numbers [{names}] within {_range_text(low, high, unit)}"
        if not isinstance(value, list) or len(value) != count:
            raise _fail(wanted)
        if not all(_is_number(item) and low <= item <= high for item in value):
            raise _fail(wanted)
        return tuple(float(item) for item in value)

    return BeforeValidator(check)


def rising(low: float, high: float, unit: str) -> BeforeValidator:
    """A list [lowest, highest] within ``low`` .. ``high``, lowest below highest."""

    def check(value: object) -> object:
        wanted = f"[lowest, highest] with lowest < highest, both within {_range_text(low, high, unit)}"
        if not isinstance(value, list) or len(value) != 2 or not all(_is_number(item) for item in value):
            raise _fail(wanted)
        if not low <= value[0] < value[1] <= high:
            raise _fail(wanted)
        return float(value[0]), float(value[1])

    return BeforeValidator(check)


def one_of(*allowed: object) -> BeforeValidator:
    """Exactly one of a few values."""

    def check(value: object) -> object:
        for choice in allowed:
            if value == choice and (type(value) is type(choice) or (_is_number(value) and _is_number(choice))):
                return choice
        raise _fail("one of " + ", ".join(show(choice) for choice in allowed))

    return BeforeValidator(check)


def text(pattern: str, allowed: str) -> BeforeValidator:
    """A string that matches the whole ``pattern``; ``allowed`` says it in words."""

    def check(value: object) -> object:
        if not isinstance(value, str) or re.fullmatch(pattern, value) is None:
            raise _fail(allowed)
        return value

    return BeforeValidator(check)


def body_axes() -> BeforeValidator:
    """Three sensor axes with sign that point along the body's x, y, z: a rotation, not a mirror image."""

    def check(value: object) -> object:
        if not isinstance(value, list) or _handedness(value) != 1:
            raise _fail('three of "+x", "-x", "+y", "-y", "+z", "-z" that form a right-handed set')
        return tuple(value)

    return BeforeValidator(check)


def _handedness(axes: list[object]) -> int:
    """Return +1 for a right-handed set of three signed axes, -1 for a left-handed one, 0 for anything else."""
    if len(axes) != 3 or any(axis not in ("+x", "-x", "+y", "-y", "+z", "-z") for axis in axes):
        return 0
    order = "".join(str(axis)[1] for axis in axes)
    if len(set(order)) != 3:
        return 0
    sign = 1 if order in ("xyz", "yzx", "zxy") else -1
    return -sign if sum(str(axis)[0] == "-" for axis in axes) % 2 else sign


def yes_or_no() -> BeforeValidator:
    """A boolean, and no number that looks like one."""
    return one_of(True, False)


def show(value: object) -> str:
    """Return a value the way TOML writes it, on one line, shortened."""
    if isinstance(value, bool):
        return "true" if value else "false"
    line = '"' + " ".join(value.split()) + '"' if isinstance(value, str) else " ".join(repr(value).split())
    return line if len(line) <= 60 else line[:57] + "..."


