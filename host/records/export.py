"""A record as CSV files, one per channel: a time column in s from the start, then one column per number."""

import csv
import json
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from ..robot.model import JOINT_NAMES, LEG_NAMES
from ..util.errors import UserError
from ..util.files import atomic_path, file_name
from .reader import Progress, Record, messages, telling, values_of
from .values import BadValue

JOINT_LABELS = [f"{leg}_{joint}" for leg in LEG_NAMES for joint in JOINT_NAMES]


def export_csv(record: Record, folder: Path, progress: Progress = lambda done: None) -> list[Path]:
    """Write the files of a record that has been read to its end, all or none; return their paths.

    UserError if a message is not a JSON object, or has other values than the first of its channel.
    """
    paths = paths_of(record, folder)
    again = Record(record.path)
    with ExitStack() as stack, telling(again):
        tables: dict[str, tuple[Any, list[str]]] = {}  # writer and columns
        for channel, time_ns, data in messages(again, progress):
            topic, cells = channel.topic, dict(_cells(values_of(channel, data)))
            if topic not in tables:
                tables[topic] = _begin(stack, paths[topic], list(cells)), list(cells)
            writer, columns = tables[topic]
            if list(cells) != columns:
                raise BadValue("it has other values than the first message: allowed: the same in every message")
            writer.writerow([f"{(time_ns - record.start_ns) / 1e9:.6f}", *cells.values()])
    return list(paths.values())


def _begin(stack: ExitStack, path: Path, columns: list[str]) -> Any:
    """Return the csv.writer of a file that appears when the stack ends well."""
    draft = stack.enter_context(atomic_path(path))
    file = stack.enter_context(draft.open("w", encoding="utf-8", errors="backslashreplace", newline=""))
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["time_s", *columns])
    return writer


def paths_of(record: Record, folder: Path) -> dict[str, Path]:
    """Return the file of each topic, all in this one folder; UserError if two would share one, or if there is none."""
    if not record.counts:
        raise UserError(f"{record.path}: nothing to export: it contains no messages")
    paths = {topic: folder / f"{file_name(topic.removeprefix('/'))}.csv" for topic in record.counts}
    if len(set(paths.values())) < len(paths):
        raise UserError(f"{record.path}: two channels have one name except for a leading /: allowed: different names")
    return paths


def _cells(values: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield column and value; twelve numbers are named by their joints, other lists are counted; objects are JSON."""
    for name, value in values.items():
        if isinstance(value, dict) or (isinstance(value, list) and any(isinstance(each, dict) for each in value)):
            yield name, json.dumps(value, separators=(",", ":"))
        elif isinstance(value, list):
            labels = JOINT_LABELS if len(value) == len(JOINT_LABELS) else [str(i) for i in range(len(value))]
            yield from ((f"{name}.{label}", each) for label, each in zip(labels, value, strict=True))
        else:
            yield name, value
