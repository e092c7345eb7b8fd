"""How swings react to what a foot meets: ground higher than planned, or an obstacle; high swings follow."""

from ..body.params import LEGS, LF_BITS, Params
from ..num.fixed import saturate
from ..runtime import const, hot
from .ground import climbs, ground_z, level_z, rise_q20
from .state import CYCLE_Q20, Trot

_MIDDLE = const(16384)  # middle of a swing, Q15: from here on a foot comes down
_RISEN = const(3277)  # 0.1 of a swing
_FREE = const(13107)  # 0.4 of a swing: from here on both feet of a diagonal are certainly off the ground
_QUARTER_Q12 = const(1024)  # of own weight
# Parts of the leg, Q10, from walks of Caramelo and Parallel on level ground and over steps
_HIGH_Q10 = const(31)  # 0.03: too high by this, and by 1.5 times its excess lag, a foot that comes down has met ground
_LAGS_Q10 = const(15)  # 0.015: lag of a rising foot that is not in excess
_LANDED_Q10 = const(51)  # 0.05: too high at a landing; 0.01 on level ground, up to 0.13 in high swings
_BEHIND_EARLY_Q10 = const(61)  # 0.06: a foot this far behind its mate is held up, while one may still be on the ground
_BEHIND_Q10 = const(26)  # 0.025: the same later in the swing; on level ground 0.02 and 0.05 were seen
_USUAL_Q10 = const(41)  # 0.04: farther behind is never usual, but held up: 0.01 on level ground, 0.06 in high swings
_SMALL_Q10 = const(36)  # 0.035: less counts as nothing, and the foot goes to where the ground was expected
# Quarters of the met height by which a foot gives way; with two in the air, or one at a landing, Caramelo climbed
# fewer stairs
_MET_QUARTERS = const(1)
_LANDED_QUARTERS = const(2)
_SWINGS_MAX = const(100)
_DOWN_Q20 = const(20972)  # 0.02: ground that falls more steeply goes down; before a wall it seemed to rise by 0 .. 0.04
EARLY = const(1)  # of ``early_contact``: the foot has met ground higher than planned
EARLY_NOW = const(2)  # it has met it in this tick, in whose goals no lag is compensated


@hot
def react(params: Params, walk: Trot, leg: int) -> int:
    """Watch one swing foot; return 1 if it stands from now on, 0 if it swings on."""
    state = walk.state
    ascent_lag = walk.ascent_lag
    if state.known <= params.delay_ticks:
        return 0
    up = walk.residual_z[leg]
    if state.swing_q15 <= _MIDDLE:
        if state.swing_q15 > _RISEN and -up > ascent_lag[leg]:
            ascent_lag[leg] = -up
    else:
        slack = saturate(ascent_lag[leg] - (params.leg_length * _LAGS_Q10 >> 10), 0, 32767)
        if up > (params.leg_length * _HIGH_Q10 >> 10) + slack + (slack >> 1):
            state.high_left = params.trot.high_distance
            meet_ground(params, walk, leg, _MET_QUARTERS)
            return 1
    if state.swing_q15 > _RISEN:
        see_held_up(params, walk, leg)
    give_way(walk, leg)
    return 0


@hot
def see_held_up(params: Params, walk: Trot, leg: int) -> None:
    """Mark a foot as held up, and swing high from now on, if it is further behind its path than its diagonal mate.

    Both feet of a diagonal lag alike behind drives and bus, whether that lag is known or not. The difference that a
    load or an unknown delay leaves recurs in every swing, and counts as usual. The longer the bus delay, the further
    behind a foot may be that still goes ahead, because its lag is known later. Intermediates: 2^16 * 2^12.
    """
    state = walk.state
    setup = params.trot
    high = 0
    if walk.apex[leg] >= setup.high_lift:
        high = 1
    behind = walk.residual_x[3 - leg] - walk.residual_x[leg]
    if state.foot_speed.x < 0:
        behind = -behind
    turn = state.turn_18
    if turn < 0:
        turn = -turn
    most = params.leg_length * _BEHIND_EARLY_Q10 >> 10
    if state.swing_q15 > _FREE and high == 0:
        most = params.leg_length * _BEHIND_Q10 >> 10
    if most > setup.push_lag:
        most = setup.push_lag
    if behind > walk.peak_lag[leg]:
        walk.peak_lag[leg] = behind
    most += walk.usual_lag[leg] + (turn * setup.turn_side >> 10)
    if behind <= most or (high == 0 and behind <= most + (most * setup.late_lag_q8 >> 8) and may_be_late(walk, leg)):
        return
    walk.held_up[leg] = 1
    if high == 0:
        state.held_up_count += 1
        state.high_left = setup.high_distance
        walk.apex[leg] = setup.high_lift


@hot
def may_be_late(walk: Trot, leg: int) -> int:
    """Return 1 if a swing foot that is behind its mate may just be late, 0 if something holds it.

    A late foot goes ahead faster than the body is commanded to; and while the bus delay still hides the swing, its mate
    does not go ahead either.
    """
    mate = 3 - leg
    speed = walk.state.foot_speed.x
    gone = walk.measured.legs[leg].x - walk.before.legs[leg].x << LF_BITS
    mate_gone = walk.measured.legs[mate].x - walk.before.legs[mate].x
    if speed < 0:
        speed = -speed
        gone = -gone
        mate_gone = -mate_gone
    if gone > speed or (mate_gone <= 0 and walk.state.swing_q15 > _FREE):
        return 1
    return 0


@hot
def give_way(walk: Trot, leg: int) -> None:
    """Send a held-up foot only half as far ahead of where it is.

    It then pushes with half the force, gets free by rising, and still reaches its foothold. Sent no further than it is,
    it would come down short of it, and the body would go on over it. At a command to stop it does not push.
    """
    shortened = walk.shortened
    shortened[leg] = 0
    if walk.held_up[leg]:
        shortened[leg] = -walk.residual_x[leg]
        if walk.state.foot_speed.x:
            shortened[leg] = -(walk.residual_x[leg] >> 1)


@hot
def count_held_up(params: Params, walk: Trot, leg: int) -> None:
    """Begin a swing of ``leg``: was its last one held up, or the body slow?

    While swings are high, a leg's score grows by 2 with each held-up swing and falls by 1 with any other; the highest
    score counts. The measured speed alone would not do: before a wall the stance feet slip, and the robot seems to move
    on. Where the ground climbs it does: on stairs each riser holds a foot up, yet the robot has its commanded speed.
    The usual lag is limited, else being held up by a wall would become usual. A foot that was held up gets free first,
    but not where the foot beside it was held up as well, as before a wall or in the plane, nor where the ground climbs.
    """
    state = walk.state
    held_up = walk.held_up
    stuck_score = walk.stuck_score
    speed = state.foot_speed.x
    seen = state.measured_speed.x
    if speed < 0:
        speed = -speed
        seen = -seen
    count = stuck_score[leg] - 1
    walk.apex[leg] = swing_apex(params, walk, leg)
    walk.rises_first[leg] = 0
    if state.high_left and (held_up[leg] or seen * 3 < speed):
        up = climbs(params, walk)
        if up == 0 or seen < speed:
            count += 3
        if params.lateral_q12 and up == 0:
            walk.rises_first[leg] = held_up[leg]
    if walk.apex[leg ^ 1] >= params.trot.highest_lift:
        walk.rises_first[leg] = 0
    count_in_row(walk, leg)
    if held_up[leg] == 0:
        usual = walk.usual_lag[leg] + (walk.peak_lag[leg] - walk.usual_lag[leg] >> 2)
        walk.usual_lag[leg] = saturate(usual, 0, params.leg_length * _USUAL_Q10 >> 10)
    walk.peak_lag[leg] = 0
    held_up[leg] = 0
    stuck_score[leg] = saturate(count, 0, _SWINGS_MAX)
    most = 0
    for other in range(LEGS):
        if stuck_score[other] > most:
            most = stuck_score[other]
    state.stuck_ticks = 0
    if speed:
        state.stuck_ticks = most * (CYCLE_Q20 >> 1) // params.trot.phase_step_q20


@hot
def count_in_row(walk: Trot, leg: int) -> None:
    """Count the held-up swings in a row of both front or both hind feet: at an edge they are few, at a wall all.

    Not where the ground goes down: after a step down, slow drives lag in high swings as if their feet were held up.
    """
    in_row = walk.held_up_in_row
    pair = leg >> 1
    if walk.held_up[leg] == 0 or walk.state.foot_speed.x == 0:
        in_row[pair] = 0
    elif rise_q20(walk) < -_DOWN_Q20:
        in_row[pair] = -_SWINGS_MAX
    elif in_row[pair] < _SWINGS_MAX:
        in_row[pair] += 1


@hot
def swing_apex(params: Params, walk: Trot, leg: int) -> int:
    """Return the apex of a leg's next swing, lu: the highest after a held-up swing, while swings are high."""
    if walk.state.high_left and walk.held_up[leg]:
        return params.trot.highest_lift
    return walk.state.lift


@hot
def land(params: Params, walk: Trot, leg: int) -> None:
    """Check a foot that has just touched down as planned: where the ground climbs, did it land too high?

    It would push its corner of the body up by as much, and tip it over. It is checked once, while the joints still show
    the landing: later it would be a leg that sags under its load. On the level a high swing just lags by as much.
    """
    if walk.early_contact[leg] or walk.state.known <= params.delay_ticks:
        return
    if walk.residual_z[leg] > params.leg_length * _LANDED_Q10 >> 10 and climbs(params, walk):
        meet_ground(params, walk, leg, _LANDED_QUARTERS)


@hot
def meet_ground(params: Params, walk: Trot, leg: int, quarters: int) -> None:
    """Let the foot stand from now on where it was measured, giving way by ``quarters`` / 4 of the height it met."""
    measured = walk.measured.legs[leg]
    foot = walk.feet.legs[leg]
    met = level_z(walk, leg) + params.trot.height - ground_z(walk, measured.x, measured.y)
    given = met - (met * quarters >> 2)
    small = params.leg_length * _SMALL_Q10 >> 10
    if met < small and met > -small:
        given = met
    foot.x = measured.x << LF_BITS
    foot.y = measured.y << LF_BITS
    foot.z = measured.z - given << LF_BITS
    walk.load_q12[leg] = _QUARTER_Q12
    walk.early_contact[leg] = EARLY_NOW
    walk.state.early_contacts += 1


@hot
def lift_on(params: Params, walk: Trot) -> None:
    """Write the apex of the next swings: as commanded, the robot's own, or high after something was met."""
    state = walk.state
    state.lift = params.trot.low_lift
    if walk.wish.height > 0:
        state.lift = saturate(walk.wish.height, 0, params.trot.highest_lift)
    if state.high_left:
        if state.lift < params.trot.high_lift:
            state.lift = params.trot.high_lift
        if climbs(params, walk) == 0:
            count_high(params, walk)


@hot
def count_high(params: Params, walk: Trot) -> None:
    """Count down the way left to go with high swings.

    Not done where the ground climbs: on stairs the feet land where their plane expects them, and meet nothing.
    """
    state = walk.state
    setup = params.trot
    ahead = state.measured_speed.x
    aside = state.measured_speed.y
    if ahead < 0:
        ahead = -ahead
    if aside < 0:
        aside = -aside
    gone = saturate(ahead + aside, setup.high_slowest, setup.high_distance)
    state.high_left = saturate(state.high_left - gone, 0, setup.high_distance)
