"""Changes single values in the text of a robot file and keeps its comments."""

import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple


class Change(NamedTuple):
    """A new value as TOML, its source, and its meaning if that differs from the line's."""

    value: str
    source: str
    meaning: str = ""


Changes = Mapping[str, Change]  # by "table.key"


_HEAD = re.compile(r"\[+([\w.]+)\]+")
_LINE = re.compile(r"([\w-]+) = (.+?)\s+# (\[.+?\]) ?(.*?) ?\(([^()]*)\)")
_STAYS_TRUE = ("assumed", "chosen", "datasheet", "yours", "derived")  # sources that also hold for another robot
_COLUMN = 39  # where the comments begin


def shown(value: object) -> str:
    """Return a text, number or list of numbers as TOML; numbers with six digits."""
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, list):
        return f"[{', '.join(shown(each) for each in value)}]"
    return f"{value:.6g}"


def changed(text: str, changes: Changes, drop: set[str], donor: str, header: str) -> str:
    """Return the donor's text with the values and sources of ``changes`` ("table.key"), without the tables to ``drop``.

    The ``header`` replaces the lines before the first value; unchanged values say whose they are; of several tables of
    one name only the first stays if it is changed.
    """
    lines = list(_blocks(text, changes, drop, donor))
    first = next(at for at, line in enumerate(lines) if _LINE.fullmatch(line))
    lines = [*header.splitlines(), "", *lines[first:]]
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines) + "\n")


def _blocks(text: str, changes: Changes, drop: set[str], donor: str) -> Iterator[str]:
    table, seen = "", set()
    changed_tables = {key.rpartition(".")[0] for key in changes}
    for line in text.splitlines():
        head = _HEAD.match(line)
        if head:
            table = head[1]
            if table in seen and table in changed_tables:
                drop = drop | {table}
            seen.add(table)
        if table in drop:
            continue
        yield _line(line, f"{table}.{line.split(' ')[0]}".lstrip("."), changes, donor)


def _line(line: str, key: str, changes: Changes, donor: str) -> str:
    found = _LINE.fullmatch(line)
    if found is None:
        return line
    name, value, unit, meaning, source = found.groups()
    if key in changes:
        value, source, new_meaning = changes[key]
        meaning = new_meaning or meaning.partition(";")[0]  # the rest is about the other robot's value
    elif source not in _STAYS_TRUE:
        source = f"as {donor}"
    elif source == "derived":
        source = f"derived for {donor}"
    words = " ".join(word for word in (unit, meaning, f"({source})") if word)
    return f"{f'{name} = {value}  ':<{_COLUMN}}# {words}"
