"""Writes values into a copy of a robot file's text, keeping comments and order; and reads the values' sources.

A line's source is the last word of its comment, in brackets: ``(chosen)``. A measured value's spread may stand before
it: ``(2026-11-23, +-7 % between joints: measured)``.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import tomlkit
from tomlkit.items import Item, Table

_SOURCE = re.compile(r"\([^()]*?(\w+)\)\s*$")
_SPREAD = re.compile(r"\+-\s*([\d.]+) %[^()]*\)\s*$")
_COLUMN = 39  # where the comments of a robot file begin


@dataclass(frozen=True)
class NewValue:
    """A number for a key, with unit and meaning for its comment if the file has no such line yet.

    ``source``: its own, if it differs from that of the others.
    """

    value: float
    meaning: str = ""
    source: str = ""


def sources(text: str) -> dict[str, str]:
    """Return the source of every key, by its dotted name; "" if a line has none."""
    found = {}
    for name, item in _lines(tomlkit.parse(text)):
        told = _SOURCE.search(item.trivia.comment)
        found[name] = told.group(1) if told else ""
    return found


def spreads(text: str) -> dict[str, float]:
    """Return how much values differ between joints, as a share, for every key whose comment says it."""
    told = ((name, _SPREAD.search(item.trivia.comment)) for name, item in _lines(tomlkit.parse(text)))
    return {name: float(found.group(1)) / 100 for name, found in told if found}


def rewritten(text: str, values: Mapping[str, NewValue], source: str) -> str:
    """Return the text with these values, each with its source; missing keys and their tables are added.

    If several tables share a name, a number says which: ``actuator.supply.0.stall_Nm``.
    """
    document = tomlkit.parse(text)
    for name, new in values.items():
        table_name, _, key = name.rpartition(".")
        table = _table(document, table_name)
        item, told = tomlkit.item(new.value), new.source or source
        old = table.get(key)
        if old is None:
            shown = f"{key} = {item.as_string()}"
            item.trivia.comment_ws = " " * max(1, _COLUMN - len(shown))
            item.trivia.comment = f"# {new.meaning} ({told})"
        else:
            _keep_comment(old, item, told)
        table[key] = item
    return tomlkit.dumps(document)


def _lines(table: Any, above: str = "") -> Iterator[tuple[str, Item]]:
    for key, item in table.items():
        if isinstance(item, Table):
            yield from _lines(item, f"{above}{key}.")
        elif isinstance(item, Item):
            yield above + key, item


def _table(document: Any, name: str) -> Any:
    """Return the table of a dotted name; a missing one is added at the end."""
    inside = document
    for part in name.split(".") if name else ():
        if part.isdecimal():
            inside = inside[int(part)]
            continue
        if part not in inside:
            if not tomlkit.dumps(document).endswith("\n\n"):
                document.add(tomlkit.nl())
            inside.add(part, tomlkit.table())
        inside = inside[part]
    return inside


def _keep_comment(old: Item, new: Item, source: str) -> None:
    """Give the new value the old one's comment, in the same column, with the new source."""
    comment = old.trivia.comment
    if _SOURCE.search(comment):
        comment = _SOURCE.sub(f"({source})", comment)
    else:
        comment = f"{comment or '#'} ({source})"
    longer = len(new.as_string()) - len(old.as_string())
    new.trivia.comment_ws = " " * max(1, len(old.trivia.comment_ws.expandtabs()) - longer)
    new.trivia.comment, new.trivia.trail = comment, old.trivia.trail
