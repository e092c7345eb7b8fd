"""The gaits' names: what a name's place is in the core's registry, and what became of the names there were before."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from shared.gait.gaits import GAIT_NAMES

from ..util.errors import UserError

if TYPE_CHECKING:
    from .model import Robot

RENAMED = {"adaptive": "trot", "fast-trot": "trot", "climb": "crawl"}
# The registry of records that do not say theirs; its own trot and crawl were tables that are gone.
BEFORE = ("paper-trot", "blind trot", "blind crawl", "adaptive", "climb")


def new_name(name: str) -> str:
    """Return in a sentence what a gait of this name is called now, "" if it never had another."""
    return f"gait '{name}' is called '{RENAMED[name]}' now" if name in RENAMED else ""


def gait_names(robot: "Robot") -> tuple[str, ...]:
    """Return the names of the gaits that a robot knows, in its planner's order: the core's registry, then its own."""
    return GAIT_NAMES + tuple(own.name for own in robot.gait.own)


def gait_index(robot: "Robot", name: str) -> int:
    """Return a gait's place among those of a robot, or raise UserError with the names there are."""
    names = gait_names(robot)
    if name not in names:
        raise UserError(f"--gait {name}: {new_name(name) or 'no such gait; there are ' + ', '.join(names)}")
    return names.index(name)


def place_now(names: Sequence[str], place: int, now: Sequence[str] = GAIT_NAMES) -> int:
    """Return where a gait of a registry of ``names`` is in that of ``now``; a place beyond it is beyond that, too.

    UserError if the gait is gone.
    """
    if not 0 <= place < len(names):
        return len(now)
    name = RENAMED.get(names[place], names[place])
    if name not in now:
        raise UserError(f"the gait '{name}' is gone; there are {', '.join(now)}")
    return now.index(name)
