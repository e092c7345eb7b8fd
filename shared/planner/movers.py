"""The movers: the code that stands and walks. A mover owns its ticks whole: command, senses in; goals, status out.

    start   take over a robot that stands
    tick    one tick, into ``planner.goal`` and ``planner.status``; return why it gives way, or 0
    stop    end, because another mover takes over

This is the one place that knows which mover is which; mover_choice.py says when they take over from each other.
"""

from ..gait.table import MOVER_CRAWL, MOVER_TROT
from ..runtime import hot
from ..sense.sensed import Sensed
from .command import Command
from .handover import REASON_NONE
from .state import PlannerState
from .walk_crawl import start_crawl, stop_crawl, walk_crawl
from .walk_table import walk_table
from .walk_trot import start_trot, stop_trot, walk_trot


@hot
def change_mover(planner: PlannerState, mover: int) -> None:
    """Make ``mover`` the current mover."""
    if mover != planner.status.mover:
        stop_mover(planner)
        planner.status.mover = mover
        start_mover(planner, mover)


@hot
def start_mover(planner: PlannerState, mover: int) -> None:
    """Start ``mover``. A table needs no start."""
    if mover == MOVER_CRAWL:
        start_crawl(planner)
    elif mover == MOVER_TROT:
        start_trot(planner)


@hot
def tick_mover(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """Do one tick of the current mover; return why it gives way (handover.REASON_...), REASON_NONE if it goes on."""
    status = planner.status
    if status.mover == MOVER_CRAWL:
        return walk_crawl(planner, command, sensed)
    if status.mover == MOVER_TROT:
        if status.backing_off:
            walk_trot(planner, planner.backing_command, sensed)
        else:
            walk_trot(planner, command, sensed)
    else:
        walk_table(planner, command, sensed)
    return REASON_NONE


@hot
def stop_mover(planner: PlannerState) -> None:
    """Stop the current mover. A table, which ends with its feet at rest, needs no stop."""
    if planner.status.mover == MOVER_CRAWL:
        stop_crawl(planner)
    elif planner.status.mover == MOVER_TROT:
        stop_trot(planner)
