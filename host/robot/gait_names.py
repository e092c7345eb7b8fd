"""The gaits' names: what a name's place is in the core's registry, and what became of the names there were before."""

from collections.abc import Sequence

from shared.gait.gaits import GAIT_NAMES

from ..util.errors import UserError

RENAMED = {"adaptive": "trot", "fast-trot": "trot", "climb": "crawl"}
# The registry of records that do not say theirs; its own trot and crawl were tables that are gone.
BEFORE = ("paper-trot", "blind trot", "blind crawl", "adaptive", "climb")


def new_name(name: str) -> str:
    """Return in a sentence what a gait of this name is called now, "" if it never had another."""
    return f"gait '{name}' is called '{RENAMED[name]}' now" if name in RENAMED else ""


def gait_index(name: str) -> int:
    """Return a gait's place in the core's registry, or raise UserError with the names there are."""
    if name not in GAIT_NAMES:
        raise UserError(f"--gait {name}: {new_name(name) or 'no such gait; there are ' + ', '.join(GAIT_NAMES)}")
    return GAIT_NAMES.index(name)


def place_now(names: Sequence[str], place: int) -> int:
    """Return where a gait of a registry of ``names`` is in that of today; a place beyond it is beyond today's, too.

    UserError if the gait is gone.
    """
    if not 0 <= place < len(names):
        return len(GAIT_NAMES)
    name = RENAMED.get(names[place], names[place])
    if name not in GAIT_NAMES:
        raise UserError(f"the gait '{name}' is gone; there are {', '.join(GAIT_NAMES)}")
    return GAIT_NAMES.index(name)
