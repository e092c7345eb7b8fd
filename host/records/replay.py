"""Feeds a record's planner inputs to the planner again and compares the joint targets to the bit."""

import json
from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from shared.body.params import Params
from shared.gait.gaits import GAIT_NAMES
from shared.planner.command import Command
from shared.planner.planner import Planner
from shared.record import pack, unpack
from shared.sense.sensed import Sensed

from ..robot.gait_names import BEFORE, place_now
from ..robot.own_gait import Entry
from ..util.errors import UserError
from .channels import CHANNELS
from .log import core_fingerprint
from .reader import Record


@dataclass(frozen=True)
class Replay:
    """The result of a replay; ``difference`` is "" if every tick is the same."""

    ticks: int
    difference: str
    same_core: bool

    @property
    def ok(self) -> bool:
        """True if all is the same."""
        return not self.difference


TELL_EVERY = 1000  # ticks
FIELDS = {"/planner": tuple(CHANNELS["/planner"])}


def replay(record: Record, progress: Callable[[float], None] = lambda done: None) -> Replay:
    """Replay a record's ``FIELDS`` from its first tick; UserError if it has no planner inputs.

    ``progress`` takes the ticks done.
    """
    if record.about.get("part", "1") != "1":
        what = "only the first part can be replayed: the planner's state at the start of the others is not recorded"
        raise UserError(f"{record.path}: part {record.about['part']} of a drive: {what}")
    rows = record.of("/planner")
    if not rows or "params" not in record.about:
        raise UserError(f"{record.path}: nothing to replay: it contains no planner inputs")
    gaits = record.about["gaits"].split() if "gaits" in record.about else BEFORE
    tick, difference = 0, ""
    try:
        own = _own_gaits(record)
        planner, now = Planner(_params(record), own), (*GAIT_NAMES, *(entry[0] for entry in own))
        for tick, row in enumerate(rows):
            difference = _differs(planner, tick, row.values, gaits, now)
            if difference:
                break
            if tick % TELL_EVERY == 0:
                progress(tick)
    except UserError as error:
        raise UserError(f"{record.path}: tick {tick}: {error}") from None
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        difference = f"tick {tick}: the core fails on it ({type(error).__name__}: {error})"
    ticks = tick if difference else len(rows)
    return Replay(ticks, difference, record.about.get("core") == core_fingerprint())


def _differs(planner: Planner, tick: int, values: dict[str, Any], gaits: Sequence[str], now: Sequence[str]) -> str:
    """Return how a tick differs from the record, "" if it does not.

    ``gaits``: the record's registry; ``now``: the planner's.
    """
    if values["tick"] != tick:
        return f"ticks {tick} .. {values['tick'] - 1} are missing: the disk did not keep up"
    command, sensed = Command(), Sensed()
    unpack(command, values["command"])
    command.gait = place_now(gaits, command.gait, now)
    sensed.unpack(values["sensed"])
    flags = planner.tick(command, sensed)
    recorded = values["joints"]
    if list(planner.joints) == recorded and flags == values["flags"]:
        return ""
    return f"tick {tick}: {_difference(planner, recorded)}"


def _own_gaits(record: Record) -> tuple[Entry, ...]:
    """Return the robot's gaits that are not in the core's registry."""
    found = json.loads(record.about.get("own_gaits", "[]"))
    return tuple((name, mover, (tuple(head), tuple(tuple(row) for row in rows))) for name, mover, (head, rows) in found)


def _params(record: Record) -> Params:
    """Return the planner's parameters."""
    try:
        block = list(array("i", map(int, record.about["params"].split())))  # refuses anything but 32-bit numbers
    except (ValueError, OverflowError):
        raise UserError(f"{record.path}: the planner's parameters are damaged: allowed: 32-bit numbers") from None
    params = Params()
    wanted = len(pack(params))
    if len(block) != wanted:
        raise UserError(f"{record.path}: its planner has {len(block)} parameters, this core needs {wanted}")
    unpack(params, block)
    return params


def _difference(planner: Planner, recorded: list[int]) -> str:
    wrong = [joint for joint in range(len(recorded)) if planner.joints[joint] != recorded[joint]]
    if not wrong:
        return "the flags differ"
    joint = wrong[0]
    return f"joint {joint} is {planner.joints[joint]}, recorded {recorded[joint]} (1/65536 turn)"
