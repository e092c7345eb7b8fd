"""Which mover has a tick: when trot and crawl take over from each other.

    trot -> (held up) backing off -> crawl -> trot

A gait of a table is walked by its table alone. Movers take over from each other when the robot stands.
"""

from ..gait.table import MOVER_CRAWL, MOVER_TABLE, MOVER_TROT
from ..runtime import const, hot
from ..sense.sensed import Sensed
from .command import MODE_WALK, Command
from .handover import REASON_COMMAND, REASON_HELD, exchanges, straight_on
from .retreat import retreat_start, retreat_step
from .state import PlannerState
from .status import BLIND, STANDING
from .steps import use_gait, wanted_gait

_HELD_S = const(4)  # of swings held up: 3 breaks off steps that it gets over, with 6 the trunk comes down on walls
_HELD_IN_A_ROW = const(7)  # swings of two feet: with 5 and 6 Caramelo breaks off steps that it gets over


@hot
def walker(planner: PlannerState) -> int:
    """Return the mover that walks the present gait where it is not crawled."""
    gait = planner.gait
    if gait.mover == MOVER_TABLE:
        return MOVER_TABLE
    return MOVER_TROT


@hot
def choose_mover(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """Take up the commanded gait if the robot stands; return the mover that has this tick.

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
        return walker(planner)
    use_gait(planner, wanted)
    return MOVER_CRAWL


@hot
def crawl_is_due(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """Return 1 if the crawl is to begin in this tick, else 0; held up for good, the trot begins to back off instead.

    It begins from a stand, when its gait is commanded and a way that it can go. Without measured joints or attitude it
    does not (BLIND).
    """
    status = planner.status
    gait = planner.gait
    crawls = 0
    if gait.mover == MOVER_CRAWL and status.state == STANDING:
        crawls = 1
    elif held_up_for_good(planner) == 0:
        return 0
    if command.mode != MODE_WALK or status.fallen or straight_on(planner.params, command) == 0:
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
    """The held-up trot begins to back off, with low swings: behind it the ground is known."""
    planner.trot.state.high_left = 0
    planner.status.backing_off = 1
    retreat_start(planner.retreat)


@hot
def held_up_for_good(planner: PlannerState) -> int:
    """Return 1 if the trot has been held up for longer than over any step it takes, else 0.

    Both feet of a pair, swing after swing: then it is a wall, and the sooner it is noticed the better.
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
    """One tick of backing off; return 1 if it is done and the crawl takes over, 0 while the trot walks.

    It is given up when the command is no longer one for it, or when the senses it needs are missing.
    """
    status = planner.status
    gait = planner.gaits[wanted_gait(planner, command)]
    keeps_on = straight_on(planner.params, command)
    if command.mode != MODE_WALK or status.fallen or exchanges(gait.mover) == 0:
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
