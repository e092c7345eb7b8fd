"""Feeds a record's planner inputs to the planner again and compares the joint targets to the bit."""

from array import array
from dataclasses import dataclass

from shared import planner_layout as core
from shared.command import COMMAND_SIZE
from shared.params import P_SIZE
from shared.planner import Planner

from ..errors import UserError
from .log import core_fingerprint
from .reader import Record


@dataclass(frozen=True)
class Replay:
    """How a replay went; ``difference`` is "" if every tick is the same."""

    ticks: int
    difference: str
    same_core: bool

    @property
    def ok(self) -> bool:
        """True if all is the same."""
        return not self.difference


def replay(record: Record) -> Replay:
    """Replay a record from its first tick; UserError if it has no planner inputs."""
    rows = record.of("/planner")
    if not rows or "params" not in record.about:
        raise UserError(f"{record.path}: nothing to replay: it holds no planner inputs")
    planner = Planner(_block(record.about["params"].split(), P_SIZE, record))
    same_core = record.about.get("core") == core_fingerprint()
    for tick, row in enumerate(rows):
        values = row.values
        if values["tick"] != tick:
            return Replay(
                tick, f"ticks {tick} .. {values['tick'] - 1} are missing: the disk did not keep up", same_core
            )
        command = _block(values["command"], COMMAND_SIZE, record)
        sensed = _block(values["sensed"], core.SENSED_SIZE, record)
        flags = planner.tick(command, sensed)
        if list(planner.joints) != values["joints"] or flags != values["flags"]:
            return Replay(tick, f"tick {tick}: {_difference(planner, values['joints'])}", same_core)
    return Replay(len(rows), "", same_core)


def _block(values: list[int] | list[str], size: int, record: Record) -> list[int]:
    try:
        block = list(array("i", [int(value) for value in values]))  # an array refuses what is no 32-bit number
    except (ValueError, OverflowError):
        raise UserError(f"{record.path}: a planner block is damaged: allowed: whole numbers of 32 bits") from None
    if len(block) != size:
        raise UserError(f"{record.path}: a planner block has {len(block)} values, this core takes {size}")
    return block


def _difference(planner: Planner, recorded: list[int]) -> str:
    wrong = [joint for joint in range(len(recorded)) if planner.joints[joint] != recorded[joint]]
    if not wrong:
        return "the flags differ"
    joint = wrong[0]
    return f"joint {joint} is {planner.joints[joint]}, recorded {recorded[joint]} (1/65536 turn)"
