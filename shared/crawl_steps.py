"""How the crawl goes on: shift the body, lift, move, hang, lower, and what to do when that meets something.

    SHIFT -> LIFT -> MOVE -> TARE -> DOWN -> (landed) -> SHIFT of the next leg ...

Order RL, FL, RR, FR. A swing that meets an edge, a drop, a riser or its own shin on an edge is tried again
somewhere else, at most three times; the body goes along so that the leg comes down steeply.
"""

from .contact import corner_lift, feel_ground, feel_riser, keep_past, take_tare
from .crawl_even import count_even
from .crawl_goals import bridge
from .crawl_layout import (
    C_BODY_TICKS,
    C_DROPPED,
    C_EVENT,
    C_EVENT_LEG,
    C_EVENT_X,
    C_EVENT_Z,
    C_EVENTS,
    C_EXPECT,
    C_FOOT,
    C_FORCE,
    C_HITS,
    C_LEG,
    C_LOAD,
    C_ON_PRINT,
    C_PACE,
    C_PAST,
    C_PEAK,
    C_PHASE,
    C_POS,
    C_PRINT,
    C_SEEN,
    C_SHARE,
    C_SPEED,
    C_STANDS,
    C_STEPS_EVEN,
    C_TARGET,
    C_TICK,
    C_TOP,
    C_TOUCHED,
    C_TRIES,
    C_TURN,
    C_WARP,
    DOWN,
    EVENT_HIGH,
    EVENT_HIT,
    EVENT_LANDED,
    EVENT_NOTHING,
    EVENT_SHIN,
    EVENT_VOID,
    EVENT_WARP,
    K_ADVANCE,
    K_ADVANCE_VOID,
    K_BACK,
    K_CLEAR,
    K_COM_X,
    K_DEEPEST,
    K_HIGH,
    K_HIT_BACK,
    K_PACE,
    K_PLANAR,
    K_RAISE,
    K_SETTLE,
    K_SHARE,
    K_SHARE_TICKS,
    K_SHIN,
    K_SHIN_RAISE,
    K_TARE_TICKS,
    K_TOO_HIGH,
    K_V_TARE,
    K_VOID,
    K_WARP,
    K_WARP_MAX,
    K_WARP_TICKS,
    K_WARP_V,
    LIFT,
    MOVE,
    PAST_SIZE,
    REST,
    SHIFT,
    TARE,
)
from .crawl_pose import mass_target, move_body, plan_body, resting_x
from .crawl_state import Crawl
from .fixed import saturate
from .footholds import aim, print_add, steps_down
from .params import FL, FR, LEGS, LF_BITS, RR
from .runtime import Ints, const, hot
from .swing_leg import enter, hang_foot, lift_foot, lower_foot, move_foot, start_move, try_again

_ORDER = const(0x0213)  # RL 3, FL 1, RR 2, FR 0, from the lowest four bits
_FULL_Q12 = const(4096)
_FREE_Q12 = const(379)  # 2 N of Caramelo's 21.6: nothing left on the leg that is to lift
_WARP_OK_Q12 = const(758)  # 4 N
_TRIES_FRONT_HIGH = const(2)
_TRIES = const(3)


@hot
def tell(state: Ints, event: int, x_lf: int, z_lf: int) -> int:
    """Keep an event of the present leg with a map x and a height off the expected one; return how many so far."""
    state[C_EVENT] = event
    state[C_EVENT_LEG] = state[C_LEG]
    state[C_EVENT_X] = x_lf >> LF_BITS
    state[C_EVENT_Z] = z_lf >> LF_BITS
    state[C_EVENTS] = state[C_EVENTS] + 1 & 0xFFFFFF
    if event != EVENT_LANDED:
        state[C_STEPS_EVEN] = 0
    return state[C_EVENTS]


@hot
def start_machine(crawl: Crawl) -> int:
    """Begin with the shift off the first leg; return 0."""
    c = crawl.state
    c[C_TURN] = 0
    c[C_LEG] = _ORDER & 15
    return plan_shift(crawl)


@hot
def machine(crawl: Crawl, way_lf: int) -> int:
    """Take one tick of the state machine; return its phase. way_lf: as crawl_tick."""
    k = crawl.settings
    c = crawl.state
    leg = c[C_LEG]
    phase = c[C_PHASE]
    c[C_TICK] = saturate(c[C_TICK] + 1, 0, 0xFFFFFF)
    c[C_PACE] = saturate(c[C_PACE] + saturate(way_lf, 0, k[K_PACE]), -k[K_PACE], k[K_PACE])
    move_body(crawl.state)
    if phase == REST:
        if way_lf > 0 and c[C_PACE] >= 0:
            plan_shift(crawl)
    elif phase == SHIFT:
        shift_tick(crawl, leg)
    else:
        keep_past(crawl.state)
        if phase == LIFT:
            if lift_foot(crawl.settings, crawl.state):
                start_move(crawl.settings, crawl.state)
        elif phase == MOVE:
            move_tick(crawl, leg)
        elif phase == TARE:
            hang_foot(crawl.settings, crawl.state)
            take_tare(crawl.settings, crawl.state, leg)
            if c[C_TICK] >= k[K_TARE_TICKS]:
                enter(crawl.state, DOWN)
                c[C_SPEED] = k[K_V_TARE]
                c[C_TOUCHED] = 0
                c[C_PEAK] = 0
        else:
            down_tick(crawl, leg)
    return c[C_PHASE]


@hot
def plan_shift(crawl: Crawl) -> int:
    """Begin to shift the body off the present leg; return the ticks of the move.

    Before a step down the hip goes over the landing place: a straight leg keeps its shin off the edge.
    """
    c = crawl.state
    leg = c[C_LEG]
    wanted = resting_x(crawl.settings, crawl.state)
    if steps_down(crawl.settings, crawl.state, leg):
        above = over_foot(crawl, leg, print_x(crawl.state, leg))
        if above > wanted:
            wanted = above
    enter(crawl.state, SHIFT)
    return shift_to(crawl, leg, wanted, -1)


@hot
def print_x(state: Ints, leg: int) -> int:
    """Return x in lf of the next print of hind ``leg``."""
    return state[C_PRINT + (leg - RR) * 12]


@hot
def over_foot(crawl: Crawl, leg: int, x_lf: int) -> int:
    """Return x in lu of the centre of mass that puts the hip of ``leg`` over the map's ``x``."""
    limbs = crawl.limbs
    k = crawl.settings
    return (x_lf >> LF_BITS) - limbs.legs[leg].hip[0] + k[K_COM_X]


@hot
def shift_to(crawl: Crawl, leg: int, wanted_x: int, skip: int) -> int:
    """Plan the body's move to ``wanted_x`` (lu), inside the support without ``leg``; return its ticks."""
    mass_target(crawl.settings, crawl.state, leg, wanted_x, crawl.feet, crawl.weights, crawl.point)
    return plan_body(
        crawl.limbs,
        crawl.settings,
        crawl.state,
        crawl.point,
        skip,
        crawl.pose,
        crawl.rotation,
        crawl.feet,
        crawl.hip_feet,
    )


@hot
def shift_tick(crawl: Crawl, leg: int) -> int:
    """Take one tick of the shift: hand the load over, match the diagonals, lift when both are done; return 0."""
    k = crawl.settings
    c = crawl.state
    left = c[C_BODY_TICKS] - c[C_TICK]
    for other in range(LEGS):
        if other != leg:
            c[C_SHARE + other] = saturate(c[C_SHARE + other] + k[K_SHARE], 0, _FULL_Q12)
    if left < k[K_SHARE_TICKS] or 2 * c[C_TICK] >= c[C_BODY_TICKS]:
        c[C_SHARE + leg] = saturate(c[C_SHARE + leg] - k[K_SHARE], 0, _FULL_Q12)
    error = match_diagonals(crawl, leg)
    if c[C_SHARE + leg] or c[C_TICK] <= c[C_BODY_TICKS] + k[K_SETTLE]:
        return 0
    if c[C_TICK] > c[C_BODY_TICKS] + k[K_WARP_TICKS]:
        tell(crawl.state, EVENT_WARP, c[C_FOOT + leg * 3], c[C_WARP])
        leave_ground(crawl, leg)
    elif error < _WARP_OK_Q12 and error > -_WARP_OK_Q12:
        leave_ground(crawl, leg)
    return 0


@hot
def match_diagonals(crawl: Crawl, leg: int) -> int:
    """Move the warp so that both diagonals carry what they should; return the error, Q12 of the own weight.

    Four feet on uneven ground are one too many to know their loads: one diagonal may carry it all. Nothing
    is left to see once the leg that lifts is free.
    """
    k = crawl.settings
    c = crawl.state
    if k[K_PLANAR]:
        return 0
    if c[C_SHARE + leg] == 0 and c[C_FORCE + leg] < _FREE_Q12:
        return 0
    error = 0
    for other in range(LEGS):
        gap = c[C_FORCE + other] - c[C_LOAD + other]
        if other == FL or other == RR:
            gap = -gap
        error += gap
    error = saturate(error, -16383, 16383)
    step = saturate(error * k[K_WARP] >> 12, -k[K_WARP_V], k[K_WARP_V])
    c[C_WARP] = saturate(c[C_WARP] + step, -k[K_WARP_MAX], k[K_WARP_MAX])
    return error


@hot
def leave_ground(crawl: Crawl, leg: int) -> int:
    """Let the leg go: choose its foothold, start its swing where it stands; return 0."""
    c = crawl.state
    for axis in range(3):
        c[C_POS + axis] = c[C_FOOT + leg * 3 + axis]
    aim(crawl.limbs, crawl.settings, crawl.state, leg)
    c[C_STANDS + leg] = 0
    c[C_SHARE + leg] = 0
    c[C_TRIES] = 0
    c[C_HITS] = 0
    c[C_DROPPED] = 0
    if leg < RR:
        c[C_ON_PRINT + leg] = 0
    for at in range(PAST_SIZE):
        c[C_PAST + at] = c[C_POS]
    enter(crawl.state, LIFT)
    return bridge(crawl, leg, 1)


@hot
def move_tick(crawl: Crawl, leg: int) -> int:
    """Take one tick across: into a riser go back and over, at the end hang; return 0."""
    k = crawl.settings
    c = crawl.state
    there = move_foot(crawl.state)
    if feel_riser(crawl.settings, crawl.state, leg):
        c[C_HITS] += 1
        tell(crawl.state, EVENT_HIT, c[C_SEEN + leg * 3], c[C_SEEN + leg * 3 + 2] - c[C_EXPECT])
        c[C_POS] = c[C_SEEN + leg * 3] - (k[K_HIT_BACK] << LF_BITS)
        c[C_TOP] = c[C_POS + 2] + (k[K_RAISE] << LF_BITS)
        enter(crawl.state, LIFT)
    elif there:
        enter(crawl.state, TARE)
    return 0


@hot
def down_tick(crawl: Crawl, leg: int) -> int:
    """Take one tick down, and deal with what is met: shin, ground, nothing; return 0."""
    k = crawl.settings
    c = crawl.state
    lower_foot(crawl.settings, crawl.state, leg)
    touches = feel_ground(crawl.settings, crawl.state, leg)
    z = c[C_SEEN + leg * 3 + 2]
    below = c[C_EXPECT] - c[C_POS + 2] >> LF_BITS
    if c[C_TRIES] < _TRIES and corner_lift(crawl.settings, crawl.state, leg) > k[K_SHIN]:
        free_shin(crawl, leg)
    elif touches and z < c[C_EXPECT] + (k[K_TOO_HIGH] << LF_BITS):
        touch(crawl, leg, z)
    elif below > k[K_VOID] and c[C_TOUCHED] == 0 and c[C_TRIES] < _TRIES and (leg >= RR or c[C_DROPPED] == 0):
        if leg < RR:
            drop_front(crawl, leg)
        else:
            drop_hind(crawl, leg)
    elif below > k[K_DEEPEST]:
        tell(crawl.state, EVENT_NOTHING, c[C_POS], -below << LF_BITS)
        land(crawl, leg)
    return 0


@hot
def free_shin(crawl: Crawl, leg: int) -> int:
    """Lift the leg off the edge its shin stands on, go on a little with the hip over the new place; return 0."""
    k = crawl.settings
    c = crawl.state
    z = c[C_SEEN + leg * 3 + 2]
    tell(crawl.state, EVENT_SHIN, c[C_POS], z - c[C_EXPECT])
    top = z + (k[K_SHIN_RAISE] << LF_BITS)
    if top < c[C_EXPECT] + (k[K_CLEAR] << LF_BITS):
        top = c[C_EXPECT] + (k[K_CLEAR] << LF_BITS)
    x = c[C_POS] + (k[K_ADVANCE] << LF_BITS)
    try_again(crawl.state, x, top)
    shift_to(crawl, leg, over_foot(crawl, leg, x), leg)
    return 0


@hot
def touch(crawl: Crawl, leg: int, z: int) -> int:
    """There is ground at ``z``, lf: take it, or try beside it if it is an edge where none should be; return 0."""
    k = crawl.settings
    c = crawl.state
    rise = z - c[C_EXPECT]
    tries = _TRIES
    if leg < RR:
        tries = _TRIES_FRONT_HIGH
    if rise <= k[K_HIGH] << LF_BITS or c[C_TRIES] >= tries:
        return land(crawl, leg)
    tell(crawl.state, EVENT_HIGH, c[C_POS], rise)
    further = k[K_ADVANCE]
    if leg < RR:
        c[C_EXPECT] = z
    elif c[C_EXPECT] >= c[C_FOOT + leg * 3 + 2] - (k[K_HIGH] << LF_BITS):
        further = -k[K_BACK]
    try_again(crawl.state, c[C_POS] + (further << LF_BITS), z + (k[K_RAISE] << LF_BITS))
    return 0


@hot
def drop_front(crawl: Crawl, leg: int) -> int:
    """No ground under a front foot: step further out, unless the other already stands down there behind; return 0."""
    k = crawl.settings
    c = crawl.state
    other = C_FOOT + (FR + FL - leg) * 3
    c[C_DROPPED] = 1
    low = c[C_EXPECT] - (k[K_HIGH] * 2 // 3 << LF_BITS)
    if c[other + 2] < low and c[C_POS] > c[other] + (k[K_ADVANCE] * 6 // 5 << LF_BITS):
        return 0
    tell(crawl.state, EVENT_VOID, c[C_POS], c[C_POS + 2] - c[C_EXPECT])
    x = c[C_POS] + (k[K_ADVANCE_VOID] << LF_BITS)
    try_again(crawl.state, x, c[C_EXPECT] + (k[K_CLEAR] << LF_BITS))
    shift_to(crawl, leg, over_foot(crawl, leg, x), leg)
    return 0


@hot
def drop_hind(crawl: Crawl, leg: int) -> int:
    """No ground where the print is: further on when climbing, else nearer; return 0."""
    k = crawl.settings
    c = crawl.state
    further = -k[K_ADVANCE]
    if c[C_TARGET + 2] > c[C_FOOT + leg * 3 + 2] + (k[K_HIGH] << LF_BITS):
        further = k[K_ADVANCE]
    tell(crawl.state, EVENT_VOID, c[C_POS], c[C_POS + 2] - c[C_EXPECT])
    try_again(crawl.state, c[C_POS] + (further << LF_BITS), c[C_EXPECT] + (k[K_RAISE] << LF_BITS))
    return 0


@hot
def land(crawl: Crawl, leg: int) -> int:
    """The foot stands where it is seen: keep that, go to the next leg, rest for the command; return 0."""
    k = crawl.settings
    c = crawl.state
    for axis in range(3):
        c[C_FOOT + leg * 3 + axis] = c[C_SEEN + leg * 3 + axis]
    c[C_STANDS + leg] = 1
    c[C_SHARE + leg] = 0
    tell(crawl.state, EVENT_LANDED, c[C_FOOT + leg * 3], c[C_FOOT + leg * 3 + 2] - c[C_EXPECT])
    if leg < RR:
        print_add(crawl.state, leg, C_FOOT + leg * 3)
        c[C_ON_PRINT + leg] = 1
    count_even(crawl.settings, crawl.state, leg)
    bridge(crawl, leg, 0)
    c[C_TURN] = c[C_TURN] + 1 & 3
    c[C_LEG] = _ORDER >> (c[C_TURN] << 2) & 15
    c[C_PACE] -= k[K_PACE]
    enter(crawl.state, REST)
    return 0
