"""A record as CSV files, one per channel: a time column in s from the start, then one column per number."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..files import write_text
from ..robot_model import JOINT_NAMES, LEG_NAMES
from .reader import Record

JOINT_LABELS = [f"{leg}_{joint}" for leg in LEG_NAMES for joint in JOINT_NAMES]


def export_csv(record: Record, folder: Path) -> list[Path]:
    """Write the files and return their paths."""
    written = []
    for topic in record.counts():
        path = folder / f"{topic.lstrip('/')}.csv"
        write_text(path, csv_text(record, topic))
        written.append(path)
    return written


def csv_text(record: Record, topic: str) -> str:
    """Return one channel as CSV."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    for number, row in enumerate(record.of(topic)):
        cells = dict(_cells(row.values))
        if number == 0:
            writer.writerow(["time_s", *cells])
        writer.writerow([f"{(row.time_ns - record.start_ns) / 1e9:.6f}", *cells.values()])
    return out.getvalue()


def _cells(values: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield column and value; twelve numbers are named by their joints, other lists are counted."""
    for name, value in values.items():
        if isinstance(value, list):
            labels = JOINT_LABELS if len(value) == len(JOINT_LABELS) else [str(i) for i in range(len(value))]
            yield from ((f"{name}.{label}", each) for label, each in zip(labels, value, strict=True))
        else:
            yield name, value
