"""Keeps sweeps as records: one MCAP file a joint and one of all joints together, each whole or not there at all."""

from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path

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
    """Return the file of what all joints did together: ``shake`` or ``ground``."""
    return folder / f"{TOGETHER}-{what}.mcap"


def done(folder: Path, joint: int) -> bool:
    """True if a joint's sweeps are kept already."""
    return path_of(folder, joint).exists()


def keep_traces(path: Path, robot: Robot, traces: Sequence[Trace]) -> None:
    """Write a joint's sweeps."""
    with atomic_path(path) as draft:
        recorder = Recorder(draft, {"robot": robot.name, "made_by": "caramelo identify"})
        try:
            at_s = 0.0
            for trace in traces:
                for row in zip(*(getattr(trace, name) for name in ROWS), strict=True):
                    values = {"joint": trace.joint, "sweep": trace.name, **dict(zip(ROWS, row, strict=True))}
                    recorder.keep_up()
                    recorder.put("/sweep", at_s + values["asked_s"], values)
                at_s += trace.asked_s[-1] + 0.5
        finally:
            recorder.close()
        _whole(recorder)


def keep_stances(path: Path, robot: Robot, rows: Sequence[Stance]) -> None:
    """Write what all joints did together."""
    with atomic_path(path) as draft:
        recorder = Recorder(draft, {"robot": robot.name, "made_by": "caramelo identify"})
        try:
            for row in rows:
                recorder.keep_up()
                recorder.put("/stance", row.at_s, asdict(row))
        finally:
            recorder.close()
        _whole(recorder)


def _whole(recorder: Recorder) -> None:
    if recorder.trouble or recorder.dropped:
        raise UserError(recorder.trouble or f"{recorder.path}: the disk is too slow: {recorder.dropped} rows missing")


def kept_traces(path: Path, robot: Robot) -> list[Trace]:
    """Return a joint's sweeps. UserError if the file is none, damaged, or of another robot."""
    record = read_record(path, {"/sweep": tuple(CHANNELS["/sweep"])})
    _belongs(path, record.about, record.damage, robot)
    traces: list[Trace] = []
    for row in record.of("/sweep"):
        values = row.values
        if not traces or traces[-1].name != values["sweep"] or values["asked_s"] < traces[-1].asked_s[-1]:
            traces.append(Trace(values["joint"], values["sweep"]))
        for name in ROWS:
            getattr(traces[-1], name).append(values[name])
    return traces


def kept_stances(path: Path, robot: Robot) -> list[Stance]:
    """Return what all joints did together; nothing if that was not measured."""
    if not path.exists():
        return []
    record = read_record(path, {"/stance": tuple(CHANNELS["/stance"])})
    _belongs(path, record.about, record.damage, robot)
    return [Stance(**row.values) for row in record.of("/stance")]


def _belongs(path: Path, about: dict[str, str], damage: str, robot: Robot) -> None:
    if damage:
        raise UserError(f"{path}: is damaged ({damage}): remove it and measure again")
    if about.get("robot") != robot.name:
        raise UserError(f"{path}: of robot {about.get('robot', '?')}, allowed {robot.name}: name another folder")
