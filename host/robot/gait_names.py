"""The gaits' names: their places in the core's registry, and the present names of gaits that were renamed."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from shared.gait.gaits import GAIT_NAMES

from ..util.errors import UserError

if TYPE_CHECKING:
    from .model import Robot

RENAMED = {"adaptive": "trot", "fast-trot": "trot", "climb": "crawl"}
# The registry of records that do not contain theirs. Its trot and crawl were tables, which no longer exist.
BEFORE = ("paper-trot", "blind trot", "blind crawl", "adaptive", "climb")


def new_name(name: str) -> str:
    """Return a sentence with the present name of a renamed gait, "" if the name was never changed."""
    return f"gait '{name}' is now called '{RENAMED[name]}'" if name in RENAMED else ""


def gait_names(robot: "Robot") -> tuple[str, ...]:
    """Return the names of the gaits that a robot knows, in its planner's order: the core's registry, then its own."""
    return GAIT_NAMES + tuple(own.name for own in robot.gait.own)


def gait_index(robot: "Robot", name: str) -> int:
    """Return a gait's place among those of a robot; UserError with all names if it has none."""
    names = gait_names(robot)
    if name.endswith(".toml"):
        raise UserError(f"--gait {name}: only names here: put the file's keys into [[gait.own]] of a robot file")
    if name not in names:
        raise UserError(f"--gait {name}: {new_name(name) or 'no such gait; there are ' + ', '.join(names)}")
    return names.index(name)


def place_now(names: Sequence[str], place: int, now: Sequence[str] = GAIT_NAMES) -> int:
    """Return a gait's place in the registry ``now`` from its place in ``names``; beyond one is as far beyond the other.

    UserError if the gait is gone.
    """
    if not 0 <= place < len(names):
        return len(now)
    name = RENAMED.get(names[place], names[place])
    if name not in now:
        raise UserError(f"the gait '{name}' no longer exists; there are {', '.join(now)}")
    return now.index(name)
