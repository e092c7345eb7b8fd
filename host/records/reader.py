"""Reads a record, even one cut off by a power failure: reads the intact part, and reports the damage."""

import json
import struct
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..util.errors import UserError
from .channels import CHANNELS
from .parts import BadPart, Channel, Message, NoMcap, Part, parts
from .recorder import ROBOT
from .values import BadValue, Rows

Fields = Mapping[str, Collection[str]]  # topic -> wanted fields
Progress = Callable[[float], None]  # takes the bytes read so far


@dataclass
class Record:
    """A record's rows by topic, for the wanted topics; for all topics: number of messages, first and last time."""

    path: Path
    rows: dict[str, Rows] = field(default_factory=dict)
    counts: Counter[str] = field(default_factory=Counter)
    start_ns: int = 0
    end_ns: int = 0
    about: dict[str, str] = field(default_factory=dict)
    whole: bool = False
    damage: str = ""
    latest: str = ""

    def of(self, topic: str) -> Rows:
        """Return the rows of a wanted topic, in order of writing."""
        return self.rows[topic]

    def times_s(self, topic: str) -> list[float]:
        """Return when the messages of such a topic were, counted from the record's first."""
        return [(time_ns - self.start_ns) / 1e9 for time_ns in self.rows[topic].times_ns]

    @property
    def duration_s(self) -> float:
        """How long it lasts."""
        return (self.end_ns - self.start_ns) / 1e9


def find_record(path: Path) -> Path:
    """Return the file; for a folder, its newest record. UserError for a pipe: some commands read a record twice."""
    if path.is_fifo():
        raise UserError(f"{path}: is a pipe: write the record into a file first")
    if not path.is_dir():
        return path
    records = sorted(path.glob("*.mcap"), key=lambda record: record.stat().st_mtime_ns)
    if not records:
        raise UserError(f"{path}: contains no record: make one with caramelo teleop --log {path}")
    return records[-1]


def read_record(path: Path, wanted: Fields = CHANNELS, progress: Progress = lambda done: None) -> Record:
    """Return a record, for a folder the newest, with the wanted fields of the wanted topics.

    UserError if the file is not a record, or if a wanted message differs from docs/records.md.
    """
    record = Record(find_record(path), {topic: Rows(topic, fields) for topic, fields in wanted.items()})
    with telling(record):
        for channel, time_ns, data in messages(record, progress):
            rows = record.rows.get(channel.topic)
            if rows is not None:
                rows.add(time_ns, values_of(channel, data))
    return record


def messages(record: Record, progress: Progress = lambda done: None) -> Iterator[Message]:
    """Yield all messages of a record's file, and take down in the record what is known of all; UserError if none is."""
    try:
        with record.path.open("rb") as file:
            for part in _until_damage(parts(file, ROBOT), record):
                if isinstance(part, dict):
                    record.about = part
                elif isinstance(part, list):
                    yield from _counted(part, record)
                    progress(file.tell())
                else:
                    record.whole = True
    except OSError as error:
        raise UserError(f"{record.path}: can't be read: {error.strerror or error}") from None
    except NoMcap:
        raise _no_record(record.path) from None
    if not record.about and not record.counts:
        raise _no_record(record.path, record.damage)


def _no_record(path: Path, damage: str = "") -> UserError:
    why = f" ({damage})" if damage else ""
    return UserError(f"{path}: not a record{why}: allowed: an MCAP file written by caramelo teleop --log")


def _until_damage(found: Iterator[Part], record: Record) -> Iterator[Part]:
    """Yield parts until the file is cut off or damaged, and note that in the record."""
    from mcap.exceptions import McapError
    from zstandard import ZstdError

    while True:
        try:
            part = next(found)
        except StopIteration:
            return
        except (McapError, ZstdError, BadPart, ValueError, OverflowError, MemoryError, struct.error) as error:
            record.damage = str(error) or type(error).__name__
            return
        yield part


def _counted(part: list[Message], record: Record) -> Iterator[Message]:
    """Yield messages, each counted before; ``latest`` is the topic of the last one."""
    times_ns = [time_ns for _, time_ns, _ in part]
    if times_ns:
        first = [] if not record.counts else [record.start_ns, record.end_ns]
        record.start_ns, record.end_ns = min(times_ns + first), max(times_ns + first)
    for message in part:
        record.latest = message[0].topic
        record.counts[record.latest] += 1
        yield message


def values_of(channel: Channel, data: bytes) -> dict[str, Any]:
    """Return a message's values; BadValue if it has none."""
    if channel.encoding != "json":
        raise BadValue(f"its encoding is {channel.encoding or 'not given'}: allowed: json")
    try:
        values = json.loads(data.decode())
    except (ValueError, RecursionError) as error:
        raise BadValue(f"not JSON ({type(error).__name__}): allowed: a JSON object") from None
    if not isinstance(values, dict):
        raise BadValue(f"JSON, but a {type(values).__name__}: allowed: a JSON object")
    return values


@contextmanager
def telling(record: Record) -> Iterator[None]:
    """Turn a BadValue into a UserError that names the message just read."""
    try:
        yield
    except BadValue as error:
        number = record.counts[record.latest]
        raise UserError(f"{record.path}: message {number} of {record.latest}: {error}") from None
