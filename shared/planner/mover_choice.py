"""Chooses the mover of each tick: when trot and crawl hand over to each other.

    trot -> (held up) backing off -> crawl -> trot

A table gait is walked by its table alone. Movers take over from each other while the robot stands.
"""

from ..gait.table import MOVER_CRAWL, MOVER_TABLE, MOVER_TROT
from ..runtime import const, hot
from ..sense.sensed import Sensed
from .command import MODE_WALK, Command
from .follow import use_gait, wanted_gait
from .handover import REASON_COMMAND, REASON_HELD, crawl_can_follow
from .retreat import retreat_start, retreat_step
from .state import PlannerState
from .status import BLIND, STANDING

_HELD_S = const(4)  # of held-up swings; 3 is too short at edges that it can climb, with 6 the trunk comes down on walls
_HELD_IN_A_ROW = const(7)  # held-up swings of a pair of feet; with 5 or 6 Caramelo gives up at steps that it can climb


@hot
def usual_mover(planner: PlannerState) -> int:
    """Return the mover that walks the current gait when it is not crawled: its table or the trot."""
    gait = planner.gait
    if gait.mover == MOVER_TABLE:
        return MOVER_TABLE
    return MOVER_TROT


@hot
def choose_mover(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """Switch to the commanded gait if the robot stands; return the mover of this tick.

    A crawl that has begun goes on until it gives way by itself.
    """
    status = planner.status
    if status.mover == MOVER_CRAWL:
        return MOVER_CRAWL
    wanted = wanted_gait(planner, command)
    if status.state == STANDING:
        use_gait(planner, wanted)
        status.cycles = 0
    if status.backing_off:
        due = backed_off(planner, command, sensed)
    else:
        due = crawl_is_due(planner, command, sensed)
    if due == 0:
        return usual_mover(planner)
    use_gait(planner, wanted)
    return MOVER_CRAWL


@hot
def crawl_is_due(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """Return 1 if the crawl begins in this tick, else 0; a trot that is held up for good begins to back off instead.

    The crawl begins from a stand, if its gait is commanded in a direction that it can go. It does not begin without
    measured joints or attitude (BLIND).
    """
    status = planner.status
    gait = planner.gait
    crawls = 0
    if gait.mover == MOVER_CRAWL and status.state == STANDING:
        crawls = 1
    elif held_up_for_good(planner) == 0:
        return 0
    if command.mode != MODE_WALK or status.fallen or crawl_can_follow(planner.params, command) == 0:
        return 0
    if sensed.valid.joints == 0 or sensed.valid.tilt == 0:
        status.flags |= BLIND
        return 0
    if crawls:
        status.reason = REASON_COMMAND
        return 1
    status.reason = REASON_HELD
    back_off(planner)
    return 0


@hot
def back_off(planner: PlannerState) -> None:
    """Let the held-up trot begin to back off, with low swings: the ground behind the robot is known."""
    planner.trot.state.high_left = 0
    planner.status.backing_off = 1
    retreat_start(planner.retreat)


@hot
def held_up_for_good(planner: PlannerState) -> int:
    """Return 1 if the trot has been held up for longer than at any step that it can climb, else 0.

    If both feet of the front or hind pair are held up swing after swing, it is a wall: better noticed early than late.
    """
    walk = planner.trot
    if planner.status.mover != MOVER_TROT:
        return 0
    if walk.held_up_in_row[0] >= _HELD_IN_A_ROW or walk.held_up_in_row[1] >= _HELD_IN_A_ROW:
        return 1
    if walk.state.stuck_ticks > planner.params.rate_hz * _HELD_S:
        return 1
    return 0


@hot
def backed_off(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """Do one tick of backing off; return 1 once it is done and the crawl takes over, 0 while the trot walks.

    It is abandoned if the command no longer allows it, or if joints or attitude are missing.
    """
    status = planner.status
    gait = planner.gaits[wanted_gait(planner, command)]
    keeps_on = crawl_can_follow(planner.params, command)
    if command.mode != MODE_WALK or status.fallen or gait.mover == MOVER_TABLE:
        keeps_on = 0
    if keeps_on == 0 or sensed.valid.joints == 0 or sensed.valid.tilt == 0:
        status.backing_off = 0
        return 0
    standing = 0
    if status.state == STANDING:
        standing = 1
    speed = planner.trot.state.measured_speed.x
    if retreat_step(planner.params, command, speed, standing, planner.retreat, planner.backing_command):
        status.backing_off = 0
        return 1
    return 0
