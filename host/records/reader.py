"""Reads a record, also one that a power cut has ended in the middle: what is whole is read, the rest is told."""

import json
import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import UserError
from .recorder import ROBOT

LARGEST_PART = 1 << 28


@dataclass(frozen=True)
class Row:
    """One message: topic, time in ns since 1970, values."""

    topic: str
    time_ns: int
    values: dict[str, Any]


@dataclass
class Record:
    """A record's messages in order of writing, what is known of the robot, and whether the end is missing."""

    path: Path
    rows: list[Row] = field(default_factory=list)
    about: dict[str, str] = field(default_factory=dict)
    whole: bool = False
    damage: str = ""

    def of(self, topic: str) -> list[Row]:
        """Return a topic's rows."""
        return [row for row in self.rows if row.topic == topic]

    @property
    def start_ns(self) -> int:
        """When it begins."""
        return min((row.time_ns for row in self.rows), default=0)

    @property
    def duration_s(self) -> float:
        """How long it lasts."""
        return (max((row.time_ns for row in self.rows), default=0) - self.start_ns) / 1e9

    def counts(self) -> dict[str, int]:
        """Return how many messages each topic has."""
        return dict(Counter(row.topic for row in self.rows))


def _newest(folder: Path) -> Path:
    """Return a folder's newest record."""
    records = sorted(folder.glob("*.mcap"), key=lambda path: path.stat().st_mtime_ns)
    if not records:
        raise UserError(f"{folder}: holds no record: make one with caramelo teleop --log {folder}")
    return records[-1]


def read_record(path: Path) -> Record:
    """Return a record, of a folder the newest; UserError if the file is none."""
    from mcap.exceptions import InvalidMagic, McapError
    from zstandard import ZstdError

    if path.is_dir():
        path = _newest(path)
    record = Record(path)
    try:
        with path.open("rb") as file:
            for row in _rows(file, record):
                record.rows.append(row)
    except OSError as error:
        raise UserError(f"{path}: can't be read: {error.strerror or error}") from None
    except InvalidMagic:
        raise _no_record(path) from None
    except (McapError, ZstdError, ValueError, struct.error, KeyError, TypeError) as error:
        record.damage = type(error).__name__
    if not record.about and not record.rows:
        raise _no_record(path)
    return record


def _no_record(path: Path) -> UserError:
    return UserError(f"{path}: no record: allowed: an MCAP file written by caramelo teleop --log")


def _rows(file: Any, record: Record) -> Iterator[Row]:
    """Yield the messages up to the end, or up to where the file is cut (mcap's EndOfFile and the like are raised)."""
    from mcap.records import Channel, Footer, Message, Metadata
    from mcap.stream_reader import StreamReader

    topics: dict[int, str] = {}
    for part in StreamReader(file, validate_crcs=True, record_size_limit=LARGEST_PART).records:
        if isinstance(part, Channel):
            topics[part.id] = part.topic
        elif isinstance(part, Metadata) and part.name == ROBOT:
            record.about = dict(part.metadata)
        elif isinstance(part, Message):
            yield Row(topics[part.channel_id], part.log_time, json.loads(part.data))
        elif isinstance(part, Footer):
            record.whole = True
