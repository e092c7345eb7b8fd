"""How swings react to what a foot meets: ground higher than planned, or an obstacle; high swings follow."""

from ..body.params import LEGS, LF_BITS, Params
from ..num.fixed import saturate
from ..runtime import const, hot
from .ground import climbs, ground_z, level_z, slope_ahead_q20
from .state import CYCLE_Q20, Trot

_MIDDLE = const(16384)  # middle of a swing, Q15: from here on a foot comes down
_RISEN = const(3277)  # 0.1 of a swing
_FREE = const(13107)  # 0.4 of a swing: from here on both feet of a diagonal are certainly off the ground
_FALLS_MAX = const(4095)  # lu / tick
_QUARTER_Q12 = const(1024)  # of own weight
# Parts of the leg, Q10, from walks of Caramelo and Parallel on level ground and over steps
_HIGH_Q10 = const(31)  # 0.03: too high by this, a foot that came down and falls no more has met ground
_LANDED_Q10 = const(51)  # 0.05: the same while it lands; 0.01 on level ground
_FALLEN_Q10 = const(32)  # 0.03: less far below its highest place, a foot has not come down yet
_BEHIND_EARLY_Q10 = const(61)  # 0.06: a foot so far behind its mate is held up, while one may still be on the ground
_BEHIND_Q10 = const(26)  # 0.025: the same later in the swing. On level ground feet were 0.05 behind early, 0.02 later
_STIFF_Q10 = const(51)  # 0.05: legs that give more are soft. Caramelo's give 0.061, and scuff the ground at 0.3 m/s
_STRIKE_Q10 = const(41)  # 0.04: less is no strike, however stiff the leg is; Pupper took scuffs for strikes at 0.03
_USUAL_Q10 = const(41)  # 0.04: farther behind is never usual, but held up: 0.01 on level ground, 0.06 in high swings
_SMALL_Q10 = const(36)  # 0.035: less counts as nothing, and the foot goes to where the ground was expected
# Quarters of the met height by which a foot gives way; with two in the air, or one at a landing, Caramelo climbed
# fewer stairs
_MET_QUARTERS = const(1)
_LANDED_QUARTERS = const(2)
_FALL_QUARTER = const(128)  # a quarter of the mean fall of a planned swing, apex over half its time, which is Q8
_SWINGS_MAX = const(100)
_SLOW_SWINGS = const(16)  # four cycles. As a loaded robot sets off, up to 8 are; with 12 Pupper crawled more often
_DOWN_Q20 = const(20972)  # 0.02: ground that falls more steeply goes down; before a wall it seemed to rise by 0 .. 0.04
EARLY = const(1)  # of ``early_contact``: the foot has met ground higher than planned
EARLY_NOW = const(2)  # it has met it in this tick, in whose goals no lag is compensated


@hot
def react(params: Params, trot: Trot, leg: int) -> int:
    """Watch one swing foot; return 1 if it stands from now on, 0 if it swings on."""
    state = trot.state
    if state.known <= params.delay_ticks:
        return 0
    if state.swing_q15 > _MIDDLE and stands_high(params, trot, leg, _HIGH_Q10):
        state.high_left = params.trot.high_distance
        meet_ground(params, trot, leg, _MET_QUARTERS)
        return 1
    if state.swing_q15 > _RISEN:
        detect_held_up(params, trot, leg)
    shorten_swing(trot, leg)
    return 0


@hot
def stands_high(params: Params, trot: Trot, leg: int, high_q10: int) -> int:
    """Return 1 if a foot stands on ground that is higher than planned by ``high_q10`` of the leg or more, else 0.

    Its height alone does not show this: slow drives are late in high swings, and at the planned touchdown their feet
    still fall, or even rise. A foot that stands has come down, and falls no more.
    """
    z = trot.measured.legs[leg].z
    top = trot.swing_top
    if z > top[leg]:
        top[leg] = z
    if trot.residual_z[leg] <= params.leg_length * high_q10 >> 10:
        return 0
    if top[leg] - z < params.leg_length * _FALLEN_Q10 >> 10:
        return 0
    if trot.before.legs[leg].z - z > trot.apex[leg] * _FALL_QUARTER // params.trot.swing_q8:
        return 0
    return 1


@hot
def detect_held_up(params: Params, trot: Trot, leg: int) -> None:
    """Mark a foot as held up, and swing high from now on, if it is further behind its path than its diagonal mate.

    Both feet of a diagonal lag alike behind drives and bus, whether that lag is known or not. The difference that a
    load or an unknown delay leaves recurs in every swing, and counts as usual. A foot in a high swing lags more, and in
    the highest it may just be late: swings do not stay high for that one. In the plane nothing turns: feet that are
    told to are not held up.
    """
    state = trot.state
    setup = params.trot
    turn = state.turn_18
    if turn < 0:
        turn = -turn
    if turn and params.lateral_q12 == 0:
        return
    mate_lag = -trot.residual_x[3 - leg]
    behind = -mate_lag - trot.residual_x[leg]
    if state.foot_speed.x < 0:
        mate_lag = -mate_lag
        behind = -behind
    if behind > trot.peak_lag[leg]:
        trot.peak_lag[leg] = behind
    usual = trot.usual_lag[leg] + (turn * setup.turn_side >> 10)
    behind -= usual
    high = 1
    most = params.leg_length * _BEHIND_EARLY_Q10 >> 10
    if trot.apex[leg] < setup.high_lift:
        high = 0
        most = most_behind(params, trot, leg, mate_lag, usual)
    if behind <= most and (high or strikes(params, trot, leg, behind) == 0):
        return
    trot.held_up[leg] = 1
    if trot.apex[leg] < setup.highest_lift:
        state.high_left = setup.high_distance
    if high == 0:
        state.held_up_count += 1
        trot.apex[leg] = setup.high_lift


@hot
def most_behind(params: Params, trot: Trot, leg: int, mate_lag: int, usual: int) -> int:
    """Return how far more than ``usual`` behind its mate a foot may be in a low swing, lu.

    Drives that reach their limits, as while the body speeds up, leave a difference that grows with the lag of the mate.
    The longer the bus delay, the further behind a foot may be that still goes ahead, because its lag is known later.
    Intermediates: 2^16 * 2^12.
    """
    most = params.leg_length * _BEHIND_EARLY_Q10 >> 10
    if trot.state.swing_q15 > _FREE:
        most = params.leg_length * _BEHIND_Q10 >> 10
    if mate_lag > 0:
        most += mate_lag >> 2
    if most > params.trot.push_lag:
        most = params.trot.push_lag
    if may_be_late(trot, leg):
        most += (most + usual) * params.trot.late_lag_q8 >> 8
    return most


@hot
def strikes(params: Params, trot: Trot, leg: int, behind: int) -> int:
    """Return 1 if a swing foot pushes hard against something that has just stopped it, else 0.

    A drive pushes by how far its joint is from the goal, less its lag times its speed. So a foot that is stopped pushes
    at once with all the lag that a free foot has, long before it is that far behind: ``behind`` its mate, more than
    usual, plus the lag times how fast it falls behind both its path and its mate. Soft legs are held up before they
    push hard. Knees in front of the hips need faster joints than elbows, and may just be late.
    Intermediates: 2^15 * 2^14.
    """
    state = trot.state
    most = params.trot.push_lag
    if most > params.leg_length * _STIFF_Q10 >> 10 or state.swing_q15 < _FREE:
        return 0
    if state.swing_q15 * params.trot.ahead_rate_q13 >> 13 > 32767:
        return 0
    mate = 3 - leg
    falls = -trot.residual_rate[leg]
    mate_falls = -trot.residual_rate[mate]
    if state.foot_speed.x < 0:
        falls = -falls
        mate_falls = -mate_falls
    if mate_falls > 0:
        falls -= mate_falls
    least = params.leg_length * _STRIKE_Q10 >> 10
    if most < least:
        most = least
    if behind + (saturate(falls, 0, _FALLS_MAX) * params.trot.lag_q8 >> 8) <= most:
        return 0
    if params.legs[leg].knee > params.legs[mate].knee and may_be_late(trot, leg):
        return 0
    return 1


@hot
def may_be_late(trot: Trot, leg: int) -> int:
    """Return 1 if a swing foot that is behind its mate may just be late, 0 if something holds it.

    A late foot goes ahead faster than the body is commanded to; and while the bus delay still hides the swing, its mate
    does not go ahead either.
    """
    mate = 3 - leg
    speed = trot.state.foot_speed.x
    moved = trot.measured.legs[leg].x - trot.before.legs[leg].x << LF_BITS
    mate_moved = trot.measured.legs[mate].x - trot.before.legs[mate].x
    if speed < 0:
        speed = -speed
        moved = -moved
        mate_moved = -mate_moved
    if moved > speed or (mate_moved <= 0 and trot.state.swing_q15 > _FREE):
        return 1
    return 0


@hot
def shorten_swing(trot: Trot, leg: int) -> None:
    """Send a held-up foot only half as far ahead of where it is.

    It then pushes with half the force, gets free by rising, and still reaches its foothold. Sent no further than it is,
    it would come down short of it, and the body would go on over it. At a command to stop it does not push.
    """
    shortened = trot.shortened
    shortened[leg] = 0
    if trot.held_up[leg]:
        shortened[leg] = -trot.residual_x[leg]
        if trot.state.foot_speed.x:
            shortened[leg] = -(trot.residual_x[leg] >> 1)


@hot
def count_held_up(params: Params, trot: Trot, leg: int) -> None:
    """Begin a swing of ``leg``: was its last one held up, or the body slow?

    While swings are high, a leg's score grows by 2 with each held-up swing and falls by 1 with any other; the highest
    score counts. The measured speed alone would not do: before a wall the stance feet slip, and the robot seems to move
    on. Where the ground climbs it does: on stairs each riser holds a foot up, yet the robot has its commanded speed.
    The usual lag is limited, else being held up by a wall would become usual. A foot that was held up gets free first,
    but not where the foot beside it was held up as well, as before a wall or in the plane, nor where the ground climbs.
    """
    state = trot.state
    held_up = trot.held_up
    stuck_score = trot.stuck_score
    speed = state.foot_speed.x
    measured_speed = state.measured_speed.x
    if speed < 0:
        speed = -speed
        measured_speed = -measured_speed
    count = stuck_score[leg] - 1
    trot.apex[leg] = swing_apex(params, trot, leg)
    trot.rises_first[leg] = 0
    if state.high_left and (held_up[leg] or measured_speed * 3 < speed):
        up = climbs(params, trot)
        if up == 0 or measured_speed < speed:
            count += 3
        if params.lateral_q12 and up == 0:
            trot.rises_first[leg] = held_up[leg]
    if trot.apex[leg ^ 1] >= params.trot.highest_lift:
        trot.rises_first[leg] = 0
    count_in_row(trot, leg)
    count_slow(params, trot, speed, measured_speed)
    if held_up[leg] == 0:
        usual = trot.usual_lag[leg] + (trot.peak_lag[leg] - trot.usual_lag[leg] >> 2)
        trot.usual_lag[leg] = saturate(usual, 0, params.leg_length * _USUAL_Q10 >> 10)
    trot.peak_lag[leg] = 0
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
def count_slow(params: Params, trot: Trot, speed: int, measured_speed: int) -> None:
    """Begin a swing: swing high from now on if the body has long been slow, commanded to ``speed``, lf / tick.

    A slow robot's feet never are so far behind their mates that they count as held up: its swings are too short.
    """
    state = trot.state
    if state.high_left or speed == 0 or measured_speed * 2 >= speed:
        state.slow_swings = 0
    else:
        state.slow_swings += 1
    if state.slow_swings >= _SLOW_SWINGS:
        state.high_left = params.trot.high_distance
        state.held_up_count += 1


@hot
def count_in_row(trot: Trot, leg: int) -> None:
    """Count the held-up swings in a row of both front or both hind feet: at an edge they are few, at a wall all.

    Not where the ground goes down: after a step down, slow drives lag in high swings as if their feet were held up.
    """
    in_row = trot.held_up_in_row
    pair = leg >> 1
    if trot.held_up[leg] == 0 or trot.state.foot_speed.x == 0:
        in_row[pair] = 0
    elif slope_ahead_q20(trot) < -_DOWN_Q20:
        in_row[pair] = -_SWINGS_MAX
    elif in_row[pair] < _SWINGS_MAX:
        in_row[pair] += 1


@hot
def swing_apex(params: Params, trot: Trot, leg: int) -> int:
    """Return the apex of a leg's next swing, lu: the highest after a held-up swing, while swings are high."""
    if trot.state.high_left and trot.held_up[leg]:
        return params.trot.highest_lift
    return trot.state.lift


@hot
def check_landing(params: Params, trot: Trot, leg: int) -> None:
    """Check a foot that has just touched down as planned: did it land too high?

    It would push its corner of the body up by as much, and tip it over. It is checked while the joints still show the
    landing: later it would be a leg that sags under its load.
    """
    if trot.early_contact[leg] or trot.state.known <= params.delay_ticks:
        return
    if stands_high(params, trot, leg, _LANDED_Q10):
        meet_ground(params, trot, leg, _LANDED_QUARTERS)


@hot
def meet_ground(params: Params, trot: Trot, leg: int, quarters: int) -> None:
    """Let the foot stand from now on where it was measured, giving way by ``quarters`` / 4 of the height it met."""
    measured = trot.measured.legs[leg]
    foot = trot.feet.legs[leg]
    met = level_z(trot, leg) + params.trot.height - ground_z(trot, measured.x, measured.y)
    given = met - (met * quarters >> 2)
    small = params.leg_length * _SMALL_Q10 >> 10
    if met < small and met > -small:
        given = met
    foot.x = measured.x << LF_BITS
    foot.y = measured.y << LF_BITS
    foot.z = measured.z - given << LF_BITS
    trot.load_q12[leg] = _QUARTER_Q12
    trot.early_contact[leg] = EARLY_NOW
    trot.state.early_contacts += 1


@hot
def choose_lift(params: Params, trot: Trot) -> None:
    """Write the apex of the next swings: as commanded, the robot's own, or high after something was met."""
    state = trot.state
    state.lift = params.trot.low_lift
    if state.careful > 0:
        state.lift = params.trot.careful_lift
    if trot.command.height > 0:
        state.lift = saturate(trot.command.height, 0, params.trot.highest_lift)
    if state.high_left:
        if state.lift < params.trot.high_lift:
            state.lift = params.trot.high_lift
        if climbs(params, trot) == 0:
            count_high(params, trot)


@hot
def count_high(params: Params, trot: Trot) -> None:
    """Count down the way left to go with high swings.

    Not done where the ground climbs: on stairs the feet land where their plane expects them, and meet nothing.
    """
    state = trot.state
    setup = params.trot
    ahead = state.measured_speed.x
    aside = state.measured_speed.y
    if ahead < 0:
        ahead = -ahead
    if aside < 0:
        aside = -aside
    distance = saturate(ahead + aside, setup.high_slowest, setup.high_distance)
    state.high_left = saturate(state.high_left - distance, 0, setup.high_distance)
