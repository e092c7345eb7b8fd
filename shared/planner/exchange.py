"""Which mover has a tick: when trot and crawl take over from each other.

    trot -> (held up) backing off -> crawl -> trot

A gait of a table is walked by its table alone. A gait that feels has two movers, and says which of them goes first.
"""

from ..gait.table import MOVER_CRAWL, MOVER_STRIDE, MOVER_TABLE, MOVER_TROT
from ..num.fixed import saturate
from ..runtime import const, hot
from ..sense.legs import stands_level
from ..sense.sensed import Sensed
from ..trot.navigate import navigate_reset
from ..trot.trot import ADVICE_BEHIND
from .command import MODE_WALK, Command
from .handover import REASON_BEHIND, REASON_COMMAND, REASON_HELD, REASON_NONE, exchanges, straight_on
from .retreat import retreat_start, retreat_step
from .state import PlannerState
from .status import BLIND, STANDING, WALKING
from .steps import use_gait, wanted_gait

_HELD_S = const(4)  # of swings held up: 3 breaks off steps that it gets over, with 6 the trunk comes down on walls
_WAIT_S = const(6)  # longer than a body's length takes at 0.05 m/s


@hot
def walker(planner: PlannerState) -> int:
    """Return the mover that walks the present gait where it is not crawled."""
    gait = planner.gait
    if gait.mover == MOVER_CRAWL:
        return MOVER_TROT
    return gait.mover


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
    if status.backs:
        due = backed_off(planner, command, sensed)
    else:
        due = crawl_is_due(planner, command, sensed, wanted)
    if due == 0:
        return walker(planner)
    use_gait(planner, wanted)
    return MOVER_CRAWL


@hot
def crawl_is_due(planner: PlannerState, command: Command, sensed: Sensed, wanted: int) -> int:
    """Return 1 if the crawl is to begin in this tick, else 0; held up, the trot begins to back off instead.

    It begins when its gait is commanded and the command one it can follow, or when the trot is to give way, at a
    moment when all feet have stood for long enough. Without measured joints or attitude it never begins (BLIND): the
    trot goes on.
    """
    valid = sensed.valid
    status = planner.status
    gait = planner.gaits[wanted]
    if command.mode != MODE_WALK or status.fallen or straight_on(planner.params, command) == 0:
        status.waited = 0
        return 0
    walks = walker(planner)
    if exchanges(gait.mover) == 0 or walks == MOVER_TABLE:
        return 0
    if walks == MOVER_STRIDE:
        reason = held_up_for_good(planner)
    else:
        reason = wait_for_crawl(planner, gait.mover)
    if reason == REASON_NONE:
        return 0
    if valid.joints == 0 or valid.tilt == 0:
        status.flags |= BLIND
        return 0
    status.reason = reason
    if reason == REASON_BEHIND or reason == REASON_HELD:
        return back_off(planner)
    return 1


@hot
def held_up_for_good(planner: PlannerState) -> int:
    """Return REASON_HELD if the fast trot has been held up for longer than over any step it takes, else REASON_NONE."""
    params = planner.params
    stride = planner.stride
    state = stride.state
    if state.held_ticks > params.rate_hz * _HELD_S:
        return REASON_HELD
    return REASON_NONE


@hot
def wait_for_crawl(planner: PlannerState, mover: int) -> int:
    """Return why the trot should give way to the crawl in this tick, once all feet surely stand; else REASON_NONE.

    mover: that of the commanded gait. Tilt alone is no reason: a crawl begun with the feet on both sides of an edge
    down does not know where it is. So a commanded one waits for level feet too, clear of what might hold the trot up,
    at most 6 s: where they are not level for so long is a slope. From a stand it begins at once.
    """
    status = planner.status
    params = planner.params
    trot = planner.trot
    clock = planner.clock
    if mover != MOVER_CRAWL:
        status.waited = 0
    elif status.state == STANDING:
        return REASON_COMMAND
    else:
        status.waited = saturate(status.waited + 1, 0, 0xFFFF)
    if status.swinging or status.state != WALKING or clock.tick <= params.stand_ticks:
        return REASON_NONE
    if status.advice == ADVICE_BEHIND:
        return REASON_BEHIND
    if status.waited > params.rate_hz * _WAIT_S:
        return REASON_COMMAND
    if mover == MOVER_CRAWL and trot.behind == 0 and stands_level(planner.params, planner.sensing):
        return REASON_COMMAND
    return REASON_NONE


@hot
def back_off(planner: PlannerState) -> int:
    """The held-up trot begins to back off, its reference where the robot is; return 0: it goes on trotting."""
    status = planner.status
    trot = planner.trot
    navigate_reset(planner.nav)
    trot.behind = 0
    status.backs = 1
    return retreat_start(planner.retreat)


@hot
def backed_off(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """One tick of backing off; return 1 if it is done and the crawl takes over, 0 while the trot walks.

    It is given up when the command is no longer one for it, or when the senses it needs are missing.
    """
    valid = sensed.valid
    status = planner.status
    gait = planner.gaits[wanted_gait(planner, command)]
    keeps_on = straight_on(planner.params, command)
    if command.mode != MODE_WALK or status.fallen or exchanges(gait.mover) == 0:
        keeps_on = 0
    if keeps_on == 0 or valid.joints == 0 or valid.tilt == 0:
        status.backs = 0
        return 0
    standing = 0
    if status.state == STANDING:
        standing = 1
    if retreat_step(planner.params, command, moved_ahead(planner), standing, planner.retreat, planner.back):
        status.backs = 0
        return 1
    return 0


@hot
def moved_ahead(planner: PlannerState) -> int:
    """Return how far the trot that walks has come ahead in the last tick by its odometry, lf."""
    status = planner.status
    sensing = planner.sensing
    stride = planner.stride
    state = stride.state
    if status.mover == MOVER_STRIDE:
        return state.seen[0]
    return sensing.moved_x
