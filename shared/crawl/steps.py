"""How the crawl goes on: shift the body, lift, swing, hang, lower, and what to do when that meets something.

    SHIFT -> LIFT -> SWING -> HANG -> LOWER -> (landed) REST -> SHIFT of the next leg ...

Order RL, FL, RR, FR. On even ground the strides are long and the motions quick. A swing that meets a step, a drop, a
riser or its own calf on an edge is tried again somewhere else, at most three times; the body goes along so that the
leg comes down steeply. A leg over which the body sinks comes down at once: one of the others does not carry, and the
robot would tip over.
"""

from ..body.params import FL, FR, LEGS, LF_BITS, RR
from ..num.fixed import saturate
from ..runtime import const, hot
from .contact import corner_lift, feel_ground, feel_riser, keep_past, stands_straight, start_contact, take_tare
from .footholds import aim, draw_back, foothold_add, lay_between, next_foothold_x, steps_down
from .goals import absorb_jump
from .ground import long_strides, note_landing, stride_lf
from .pose import com_target, move_body, plan_body, resting_x
from .state import (
    EVENT_CALF,
    EVENT_DIAGONALS,
    EVENT_DROP,
    EVENT_LANDED,
    EVENT_NO_GROUND,
    EVENT_RIM,
    EVENT_RISER,
    EVENT_SINKS,
    EVENT_STEP,
    FULL_SHARE_Q12,
    HANG,
    HISTORY_TICKS,
    LIFT,
    LOWER,
    REST,
    SHIFT,
    SWING,
    Crawl,
)
from .swing import lift_foot, lower_foot, start_swing, swing_foot

_ORDER = const(0x0213)  # RL 3, FL 1, RR 2, FR 0, from the lowest four bits
_TRIES_UNKNOWN_STEP = const(2)  # of what may be a step where nothing is known: the next foot knows more
_TRIES = const(3)


@hot
def enter(crawl: Crawl, next: int) -> None:
    """Begin a stage, a swing at rest."""
    crawl.stage.stage = next
    crawl.stage.stage_tick = 0
    crawl.swing.speed = 0


@hot
def note_event(crawl: Crawl, code: int, z_lf: int) -> None:
    """Keep an event of the present leg with a height off the expected one."""
    event = crawl.event
    event.code = code
    event.leg = crawl.stage.leg
    event.z = z_lf >> LF_BITS
    event.number = event.number + 1 & 0xFFFFFF
    if code != EVENT_LANDED:
        crawl.ground.even_landings = 0


@hot
def start_stages(crawl: Crawl) -> None:
    """Begin with the shift off the first leg."""
    crawl.stage.order = 0
    crawl.stage.leg = _ORDER & 15
    plan_shift(crawl)


@hot
def take_stage(crawl: Crawl, ahead_lf: int) -> None:
    """Take one tick of the state machine. ahead_lf: as crawl_tick."""
    stage = crawl.stage
    step = stride_lf(crawl) >> 2  # of one leg brings the body that far
    stage.stage_tick = saturate(stage.stage_tick + 1, 0, 0xFFFFFF)
    stage.ahead = saturate(stage.ahead + saturate(ahead_lf, 0, step), -step, step)
    move_body(crawl.path)
    if stage.stage == REST:
        if ahead_lf > 0 and stage.ahead >= 0:
            plan_shift(crawl)
    elif stage.stage == SHIFT:
        shift_tick(crawl, stage.leg)
    else:
        swing_stage(crawl, stage.leg)


@hot
def swing_stage(crawl: Crawl, leg: int) -> None:
    """Take one tick of the stages in which ``leg`` is in the air."""
    stage = crawl.stage
    swing = crawl.swing
    keep_past(crawl.contact, swing.place.x)
    if corner_lift(crawl, leg) < -crawl.params.crawl.sink and (
        swing.tries < _TRIES or swing.place.z > crawl.map.feet[leg].z
    ):
        put_down(crawl, leg)
    elif stage.stage == LIFT:
        if lift_foot(crawl.params, swing):
            start_swing(crawl)
            enter(crawl, SWING)
    elif stage.stage == SWING:
        swing_tick(crawl, leg)
    elif stage.stage == HANG:
        hang_tick(crawl, leg)
    else:
        lower_tick(crawl, leg)


@hot
def plan_shift(crawl: Crawl) -> None:
    """Begin to shift the body off the present leg.

    Before a step down the hip goes over the landing place: a straight leg keeps its calf off the edge.
    """
    leg = crawl.stage.leg
    if leg >= RR and long_strides(crawl.ground) == 0:
        lay_between(crawl, leg)
    wanted = resting_x(crawl)
    if steps_down(crawl, leg):
        above = hip_over(crawl, leg, next_foothold_x(crawl.footholds, leg))
        if above > wanted:
            wanted = above
    enter(crawl, SHIFT)
    shift_to(crawl, leg, wanted, -1)


@hot
def hip_over(crawl: Crawl, leg: int, x_lf: int) -> int:
    """Return x in lu of the centre of mass that puts the hip of ``leg`` over the map's ``x``."""
    return (x_lf >> LF_BITS) - crawl.params.legs[leg].hip.x + crawl.params.com_x


@hot
def shift_to(crawl: Crawl, leg: int, wanted_x: int, skip: int) -> None:
    """Plan the body's move to ``wanted_x`` (lu), inside the support without ``leg``."""
    com_target(crawl, leg, wanted_x)
    plan_body(crawl, skip)


@hot
def shift_tick(crawl: Crawl, leg: int) -> None:
    """Take one tick of the shift: hand the load over, match the diagonals, lift when both are done."""
    params = crawl.params
    stage = crawl.stage
    support = crawl.support
    path = crawl.path
    step = FULL_SHARE_Q12 // params.crawl.share_ticks
    for other in range(LEGS):
        if other != leg:
            support.share_q12[other] = saturate(support.share_q12[other] + step, 0, FULL_SHARE_Q12)
    if path.move_ticks - stage.stage_tick < params.crawl.share_ticks or 2 * stage.stage_tick >= path.move_ticks:
        support.share_q12[leg] = saturate(support.share_q12[leg] - step, 0, FULL_SHARE_Q12)
    error = match_diagonals(crawl, leg)
    if support.share_q12[leg] or stage.stage_tick <= path.move_ticks + params.crawl.settle_ticks:
        return
    if stage.stage_tick > path.move_ticks + params.crawl.diagonal_ticks:
        note_event(crawl, EVENT_DIAGONALS, support.diagonal_offset)
        lift_off(crawl, leg)
    elif error < params.crawl.diagonal_error_q12 and error > -params.crawl.diagonal_error_q12:
        lift_off(crawl, leg)


@hot
def match_diagonals(crawl: Crawl, leg: int) -> int:
    """Move the diagonal offset so that both diagonals carry what they should; return the error, Q12 of the own weight.

    Four feet on uneven ground are one too many to know their loads: one diagonal may carry it all. Nothing
    is left to see once the leg that lifts is free.
    """
    params = crawl.params
    support = crawl.support
    if params.lateral_q12 == 0:
        return 0
    if support.share_q12[leg] == 0 and support.force_q12[leg] < params.crawl.free_q12:
        return 0
    error = 0
    for other in range(LEGS):
        gap = support.force_q12[other] - support.load_q12[other]
        if other == FL or other == RR:
            gap = -gap
        error += gap
    error = saturate(error, -16383, 16383)
    most = params.crawl.diagonal_max << LF_BITS
    step = saturate(error * params.crawl.diagonal_gain >> 12, -params.crawl.diagonal_speed, params.crawl.diagonal_speed)
    support.diagonal_offset = saturate(support.diagonal_offset + step, -most, most)
    return error


@hot
def lift_off(crawl: Crawl, leg: int) -> None:
    """Let the leg go: choose its foothold, start its swing where it stands."""
    swing = crawl.swing
    for axis in range(3):
        swing.place[axis] = crawl.map.feet[leg][axis]
    swing.departure.x = swing.place.x
    swing.departure.y = swing.place.y
    aim(crawl, leg)
    crawl.support.stance[leg] = 0
    crawl.support.share_q12[leg] = 0
    swing.tries = 0
    swing.risers = 0
    swing.dropped = 0
    if leg < RR:
        crawl.footholds.sides[leg].occupied = 0
    for at in range(HISTORY_TICKS):
        crawl.contact.past_x[at] = swing.place.x
    enter(crawl, LIFT)
    absorb_jump(crawl, leg, 1)


@hot
def swing_tick(crawl: Crawl, leg: int) -> None:
    """Take one tick across: into a riser go back and over, at the end hang."""
    swing = crawl.swing
    there = swing_foot(crawl)
    x = crawl.map.measured[leg].x
    if feel_riser(crawl, x):
        swing.risers += 1
        note_event(crawl, EVENT_RISER, crawl.map.measured[leg].z - swing.ground)
        swing.place.x = x - (crawl.params.crawl.riser_retreat << LF_BITS)
        swing.apex = swing.place.z + (crawl.params.crawl.clear_contact << LF_BITS)
        enter(crawl, LIFT)
    elif there:
        enter(crawl, HANG)


@hot
def hang_tick(crawl: Crawl, leg: int) -> None:
    """Take one tick of creeping down while the tare is taken."""
    params = crawl.params
    crawl.swing.place.z -= params.crawl.hang_speed
    take_tare(crawl.params, crawl.contact, crawl.support.force_q12[leg], crawl.stage.stage_tick)
    if crawl.stage.stage_tick >= params.crawl.hang_ticks:
        enter(crawl, LOWER)
        crawl.swing.speed = params.crawl.hang_speed
        start_contact(crawl.contact)


@hot
def put_down(crawl: Crawl, leg: int) -> None:
    """The body sinks over the leg in the air: from above where it stood, bring its foot down there in one jump.

    Another foot does not carry what it should: it slid off an edge, or hangs. Any ground will do, so nothing else is
    tried, and there is no time for a tare.
    """
    swing = crawl.swing
    start = crawl.map.feet[leg].z
    note_event(crawl, EVENT_SINKS, swing.place.z - start)
    if swing.place.z > start:
        swing.ground = start
        swing.place.z = start
    swing.tries = _TRIES
    crawl.contact.tare_q12 = 0
    enter(crawl, LOWER)
    start_contact(crawl.contact)


@hot
def lower_tick(crawl: Crawl, leg: int) -> None:
    """Take one tick down, and deal with what is met: calf, ground, nothing."""
    params = crawl.params
    swing = crawl.swing
    lower_foot(crawl)
    touches = feel_ground(crawl.params, crawl.contact, crawl.support.force_q12[leg])
    lift = corner_lift(crawl, leg)
    z = crawl.map.measured[leg].z
    below = swing.ground - swing.place.z >> LF_BITS
    if stands_straight(params, lift, z - swing.ground):
        land(crawl, leg)
    elif swing.tries < _TRIES and lift > params.crawl.calf_lift:
        free_calf(crawl, leg)
    elif touches and z < swing.ground + (params.crawl.highest_contact << LF_BITS):
        touch(crawl, leg, z)
    elif below > params.crawl.drop_depth and crawl.contact.load_ticks == 0 and swing.tries < _TRIES and (
        leg >= RR or swing.dropped == 0
    ):
        find_ground(crawl, leg)
    elif below > params.crawl.deepest:
        note_event(crawl, EVENT_NO_GROUND, -below << LF_BITS)
        land(crawl, leg)


@hot
def lift_again(crawl: Crawl, x_lf: int, apex_lf: int) -> None:
    """Lift the foot once more from where it is, to ``apex``, and come down at ``x``.

    From where it was told to be, deep in what it met, it would go on pushing the body up, and tip it over.
    """
    enter(crawl, LIFT)
    crawl.swing.tries += 1
    crawl.swing.place.z = crawl.map.measured[crawl.stage.leg].z
    crawl.swing.target.x = x_lf
    crawl.swing.apex = apex_lf


@hot
def free_calf(crawl: Crawl, leg: int) -> None:
    """Lift the leg off the edge its calf stands on, go on a little with the hip over the new place."""
    params = crawl.params
    swing = crawl.swing
    z = crawl.map.measured[leg].z
    note_event(crawl, EVENT_CALF, z - swing.ground)
    apex = z + (params.crawl.calf_clear << LF_BITS)
    least = swing.ground + (params.crawl.clear_ground << LF_BITS)
    if apex < least:
        apex = least
    x = swing.place.x + (params.crawl.edge_advance << LF_BITS)
    lift_again(crawl, x, apex)
    shift_to(crawl, leg, hip_over(crawl, leg, x), leg)


@hot
def touch(crawl: Crawl, leg: int, z: int) -> None:
    """There is ground at ``z``, lf: take it, or try beside it if it is a rim, or a step where none should be."""
    params = crawl.params
    swing = crawl.swing
    edge = params.crawl.edge_height << LF_BITS
    rise = z - swing.ground
    if leg >= RR and swing.dropped and swing.tries < _TRIES:
        leave_rim(crawl, z)
        return
    tries = _TRIES
    if swing.known == 0:
        tries = _TRIES_UNKNOWN_STEP
    if rise <= edge or swing.tries >= tries:
        land(crawl, leg)
        return
    note_event(crawl, EVENT_STEP, rise)
    further = params.crawl.edge_advance
    if swing.known == 0:
        swing.ground = z
    elif swing.ground >= crawl.map.feet[leg].z - edge:
        further = -params.crawl.edge_retreat
    lift_again(crawl, swing.place.x + (further << LF_BITS), z + (params.crawl.clear_contact << LF_BITS))


@hot
def find_ground(crawl: Crawl, leg: int) -> None:
    """No ground where it was expected: look for it elsewhere."""
    if leg < RR:
        drop_front(crawl, leg)
    else:
        drop_hind(crawl, leg)


@hot
def drop_front(crawl: Crawl, leg: int) -> None:
    """No ground under a front foot: step further out, unless the other already stands down there behind."""
    params = crawl.params
    swing = crawl.swing
    other = crawl.map.feet[FR + FL - leg]
    swing.dropped = 1
    low = swing.ground - (params.crawl.edge_height * 2 // 3 << LF_BITS)
    behind = swing.place.x - (params.crawl.edge_advance * 6 // 5 << LF_BITS)
    if other.z < low and other.x < behind:
        return
    note_event(crawl, EVENT_DROP, swing.place.z - swing.ground)
    x = swing.place.x + (params.crawl.drop_advance << LF_BITS)
    lift_again(crawl, x, swing.ground + (params.crawl.clear_ground << LF_BITS))
    shift_to(crawl, leg, hip_over(crawl, leg, x), leg)


@hot
def drop_hind(crawl: Crawl, leg: int) -> None:
    """No ground where the foothold is: further on when it goes up, else nearer."""
    params = crawl.params
    swing = crawl.swing
    swing.dropped = -1
    if swing.target.z > crawl.map.feet[leg].z + (params.crawl.edge_height << LF_BITS):
        swing.dropped = 1
    note_event(crawl, EVENT_DROP, swing.place.z - swing.ground)
    leave_drop(crawl, swing.ground)


@hot
def leave_rim(crawl: Crawl, z: int) -> None:
    """Ground at ``z``, lf, where a try beside it found none: the foot would slip off its rim, so go as far again."""
    note_event(crawl, EVENT_RIM, z - crawl.swing.ground)
    leave_drop(crawl, z)
    crawl.swing.dropped = 0


@hot
def leave_drop(crawl: Crawl, z: int) -> None:
    """Try once more beside the drop, clear of ground at ``z``, lf, the way that the drop sends a hind foot."""
    crawl_params = crawl.params.crawl
    x = crawl.swing.place.x + (crawl.swing.dropped * crawl_params.edge_advance << LF_BITS)
    lift_again(crawl, x, z + (crawl_params.clear_contact << LF_BITS))


@hot
def land(crawl: Crawl, leg: int) -> None:
    """The foot stands where it is measured: keep that, go to the next leg, rest for the command."""
    stage = crawl.stage
    foot = crawl.map.feet[leg]
    measured = crawl.map.measured[leg]
    for axis in range(3):
        foot[axis] = measured[axis]
    crawl.support.stance[leg] = 1
    crawl.support.share_q12[leg] = 0
    note_event(crawl, EVENT_LANDED, foot.z - crawl.swing.ground)
    if leg < RR:
        foothold_add(crawl.map, crawl.footholds, leg)
        crawl.footholds.sides[leg].occupied = 1
        if foot.z < crawl.swing.target.z - (crawl.params.crawl.edge_height << LF_BITS):
            draw_back(crawl, leg)
    note_landing(crawl, leg)
    absorb_jump(crawl, leg, 0)
    stage.order = stage.order + 1 & 3
    stage.leg = _ORDER >> (stage.order << 2) & 15
    stage.ahead -= stride_lf(crawl) >> 2
    enter(crawl, REST)
