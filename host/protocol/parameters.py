"""Reads parameters.toml: the table of joint parameters behind the service messages, checked when loaded."""

from __future__ import annotations

import tomllib
from dataclasses import MISSING, dataclass, fields, replace
from fractions import Fraction
from pathlib import Path

SOURCE = Path(__file__).with_name("parameters.toml")
ACCESS = ("measured", "live", "disarmed")
RAW_LOW, RAW_HIGH = -(1 << 30), (1 << 30) - 1


class ParameterError(ValueError):
    """An error in one line: which parameter, which value, what is allowed."""


@dataclass(frozen=True)
class Parameter:
    """One parameter; raw = value x raw_per_unit. ``low``, ``high`` and ``default`` are raw.

    ``zero`` False: 0 is refused although within the limits. ``place``: its number within a row of ``count``.
    ``group``: its heading; a row without one has that of the row before.
    """

    id: int
    name: str
    meaning: str
    low: int
    high: int
    default: int
    access: str
    stored: bool
    unit: str = ""
    raw_per_unit: Fraction = Fraction(1)
    zero: bool = True
    count: int = 1
    place: int = 0
    group: str = ""

    def to_raw(self, value: float) -> int:
        """Return the nearest raw value to ``value`` in ``unit``; ParameterError if it is not allowed."""
        raw = round(Fraction(value) * self.raw_per_unit) if value == value and abs(value) != float("inf") else None
        if self.access == "measured":
            raise ParameterError(f"{self.name}: can only be read")
        if raw is None or not self.low <= raw <= self.high or (raw == 0 and not self.zero):
            low, high = self.to_value(self.low), self.to_value(self.high)
            unit = (f" {self.unit}" if self.unit else "") + ("" if self.zero else ", but not 0")
            raise ParameterError(f"{self.name}: {value:.10g}: allowed {low:.10g} to {high:.10g}{unit}")
        return raw

    def to_value(self, raw: int) -> float:
        """Return the value in ``unit`` of a raw integer."""
        return float(raw / self.raw_per_unit)


_KEYS = {field.name for field in fields(Parameter)} - {"id", "place"}
_NEEDED = {field.name for field in fields(Parameter) if field.default is MISSING} - {"id"}
_INTEGERS = ("low", "high", "default", "count")


def _parameters(first: int, row: dict[str, object]) -> list[Parameter]:
    """Return the parameter of one row, or its ``count`` parameters, with ids from ``first`` on."""
    where = f"parameters.toml: parameter {first} ({row.get('name', 'no name')})"
    wrong = (_NEEDED - set(row)) | (set(row) - _KEYS)
    if wrong:
        raise ParameterError(f"{where}: missing or unknown keys {sorted(wrong)}")
    if any(type(row.get(key, 1)) is not int for key in _INTEGERS):
        raise ParameterError(f"{where}: low, high, default and count must be whole numbers")
    scale = Fraction(str(row.get("raw_per_unit", 1)))
    one = Parameter(**({"id": first} | row | {"raw_per_unit": scale}))  # type: ignore[arg-type]
    if scale <= 0 or one.access not in ACCESS or one.count < 1:
        raise ParameterError(f"{where}: raw_per_unit and count must be above 0, access one of {', '.join(ACCESS)}")
    if not RAW_LOW <= one.low <= one.default <= one.high <= RAW_HIGH or (one.default == 0 and not one.zero):
        raise ParameterError(f"{where}: allowed low <= default <= high within -2^30..2^30-1, a default other than 0")
    if one.count == 1:
        return [one]
    return [replace(one, id=first + i, name=f"{one.name}_{i}", place=i) for i in range(one.count)]


def parse(text: str) -> list[Parameter]:
    """Return the parameters of a TOML text, id = position; ParameterError with one line otherwise."""
    made: list[Parameter] = []
    for row in tomllib.loads(text).get("parameter", []):
        made += _parameters(len(made), ({"group": made[-1].group} if made else {}) | row)
    names = [parameter.name for parameter in made]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice or not 0 < len(made) <= 256:
        raise ParameterError(f"parameters.toml: {len(made)} parameters, given twice: {twice}; allowed 1..256, once")
    return made


def load() -> list[Parameter]:
    """Return the project's own parameter table in order of id."""
    return parse(SOURCE.read_text())
