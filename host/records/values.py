"""A channel's messages, checked against what the channel holds (channels.py) and kept in columns of numbers.

An hour is over a million messages; as columns they take a tenth of the memory.
"""

from array import array
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

from .channels import CHANNELS

_NAMES = {"number": "numbers", "integer": "whole numbers", "string": "texts", "boolean": "true or false"}
_TYPES = {"number": (int, float), "integer": (int,), "string": (str,), "boolean": (bool,)}
_CODES = {"number": "d", "integer": "q", "boolean": "b"}


class BadValue(Exception):
    """An error in a message's values: what is wrong, and what is allowed."""


@dataclass(frozen=True)
class Row:
    """One message: time in ns since 1970, values by field."""

    time_ns: int
    values: dict[str, Any]


class Column:
    """A field of all messages, in order in ``all``; for a list, ``width`` entries belong to a message."""

    def __init__(self, rule: dict[str, Any]) -> None:
        self.width: int | None = rule.get("maxItems")
        self._kind: str = rule["type"] if self.width is None else rule["items"]["type"]
        self.all: Any = array(_CODES[self._kind]) if self._kind in _CODES else []

    def add(self, value: Any) -> None:
        """Take the next message's value; BadValue says what is allowed."""
        try:
            fits = self._take(value)
        except (TypeError, OverflowError):  # the array refuses values that are not numbers, or too large
            fits = False
        if not fits:
            raise BadValue(f"allowed: {self.width or 'one of'} {_NAMES[self._kind]}")

    def _take(self, value: Any) -> bool:
        if self.width is None:
            fits = type(value) in _TYPES[self._kind]
            if fits:
                self.all.append(value)
        else:
            fits = type(value) is list and len(value) == self.width
            if fits:
                self.all.fromlist(value)
        return fits

    def of(self, row: int) -> Any:
        """Return a message's value."""
        return self.all[row] if self.width is None else list(self.all[row * self.width : (row + 1) * self.width])


class Rows:
    """The messages of a topic, some fields of each."""

    def __init__(self, topic: str, fields: Collection[str]) -> None:
        self.times_ns = array("Q")
        self.columns = {name: Column(CHANNELS[topic][name]) for name in fields}

    def add(self, time_ns: int, values: dict[str, Any]) -> None:
        """Take the next message; BadValue names a field that does not fit its channel."""
        for name, column in self.columns.items():
            try:
                column.add(values.get(name))
            except BadValue as error:
                raise BadValue(f"{name}: {error}") from None
        self.times_ns.append(time_ns)

    def __len__(self) -> int:
        return len(self.times_ns)

    def __iter__(self) -> Iterator[Row]:
        return map(self.__getitem__, range(len(self)))

    def __getitem__(self, at: int) -> Row:
        at = range(len(self))[at]
        return Row(self.times_ns[at], {name: column.of(at) for name, column in self.columns.items()})
