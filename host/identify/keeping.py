"""Keeps sweeps as records: one MCAP file per joint and one of all joints together, each complete or absent."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from ..bus.base import JOINT_LABELS
from ..records.channels import CHANNELS
from ..records.reader import read_record
from ..records.recorder import Recorder
from ..robot.model import Robot
from ..util.errors import UserError
from ..util.files import atomic_path
from .sweeping import Stance, Trace

TOGETHER = "together"
ROWS = [field.name for field in fields(Trace) if field.name not in ("joint", "name")]


def path_of(folder: Path, joint: int) -> Path:
    """Return the file of a joint's sweeps."""
    return folder / f"{JOINT_LABELS[joint].replace(' ', '-')}.mcap"


def together_path(folder: Path, what: str) -> Path:
    """Return the file of all joints together: ``shake`` or ``ground``."""
    return folder / f"{TOGETHER}-{what}.mcap"


def done(folder: Path, joint: int) -> bool:
    """True if a joint's sweeps are already kept."""
    return path_of(folder, joint).exists()


def keep_traces(path: Path, robot: Robot, traces: Sequence[Trace]) -> None:
    """Write a joint's sweeps."""
    with _kept(path, robot) as put:
        at_s = 0.0
        for trace in traces:
            for row in zip(*(getattr(trace, name) for name in ROWS), strict=True):
                values = {"joint": trace.joint, "sweep": trace.name, **dict(zip(ROWS, row, strict=True))}
                put("/sweep", at_s + values["asked_s"], values)
            at_s += trace.asked_s[-1] + 0.5


def keep_stances(path: Path, robot: Robot, rows: Sequence[Stance]) -> None:
    """Write the ticks of all joints together."""
    with _kept(path, robot) as put:
        for row in rows:
            put("/stance", row.at_s, asdict(row))


@contextmanager
def _kept(path: Path, robot: Robot) -> Iterator[Callable[[str, float, dict[str, Any]], None]]:
    """Yield a function that takes the rows of a record: topic, time, values. UserError if one could not be written."""
    with atomic_path(path) as draft:
        recorder = Recorder(draft, {"robot": robot.name, "made_by": "caramelo identify"})

        def put(topic: str, at_s: float, values: dict[str, Any]) -> None:
            recorder.keep_up()
            recorder.put(topic, at_s, values)

        try:
            yield put
        finally:
            recorder.close()
        if recorder.missing:
            raise UserError(recorder.trouble or f"{recorder.missing}: {recorder.dropped} rows missing")


def kept_traces(path: Path, robot: Robot) -> list[Trace]:
    """Return a joint's sweeps. UserError if the file is not a record, damaged, or of another robot."""
    traces: list[Trace] = []
    for values in _read(path, robot, "/sweep"):
        if not traces or traces[-1].name != values["sweep"] or values["asked_s"] < traces[-1].asked_s[-1]:
            traces.append(Trace(values["joint"], values["sweep"]))
        for name in ROWS:
            getattr(traces[-1], name).append(values[name])
    return traces


def kept_stances(path: Path, robot: Robot) -> list[Stance]:
    """Return the ticks of all joints together; none if they were not measured."""
    return [Stance(**values) for values in _read(path, robot, "/stance")] if path.exists() else []


def _read(path: Path, robot: Robot, topic: str) -> Iterator[dict[str, Any]]:
    record = read_record(path, {topic: tuple(CHANNELS[topic])})
    if record.damage:
        raise UserError(f"{path}: the record is damaged ({record.damage}): remove it and measure again")
    if record.about.get("robot") != robot.name:
        raise UserError(f"{path}: of robot {record.about.get('robot', '?')}, allowed {robot.name}; name another folder")
    yield from (row.values for row in record.of(topic))
