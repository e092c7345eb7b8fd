"""What the measured feet tell the trot: the body's speed over them, and how far each is from where it was sent.

A stance foot at p in the body does not move over the ground, so the body's speed over it is -(dp/dt + w x p), with w
the body's turning rates. Tipping is included.
"""

from ..body.axes import Turn
from ..body.params import LEGS, LF_BITS, Params
from ..num.fixed import saturate
from ..runtime import const, hot
from .state import Trot

_TURN_MAX = const(16383)  # 2^-18 rad / tick: 3 rad/s at 50 Hz
_SPEED_MAX = const(524287)  # lf / tick
_GAP_MAX = const(131071)  # lu Q4


@hot
def estimate(params: Params, trot: Trot, turned: Turn, valid: int) -> None:
    """Take the measured feet and the turn of this tick.

    ``valid`` 0: not all was measured. Nothing is known then, and the commanded speed is taken for the measured one.
    """
    state = trot.state
    if valid == 0:
        state.known = 0
        for axis in range(2):
            state.measured_speed[axis] = state.foot_speed[axis]
        return
    if state.known:
        estimate_speed(params, trot, turned)
    if state.known > params.delay_ticks:
        update_residual(params, trot)
    elif state.known == params.delay_ticks:
        start_residual(params, trot)
    if state.known < 100:
        state.known += 1


@hot
def estimate_speed(params: Params, trot: Trot, turned: Turn) -> None:
    """Update the filtered mean speed of the body over the feet that certainly stand.

    These stood by plan in the last tick, and also a tick before the goals that the joints now answer: a foot that has
    just touched down tells no speed. Intermediates: 2 * 16383 * 32767 < 2^30; a speed's error of 2^19 times 2^9.
    """
    state = trot.state
    about_x = saturate(turned.x, -_TURN_MAX, _TURN_MAX)
    about_y = saturate(turned.y, -_TURN_MAX, _TURN_MAX)
    about_z = saturate(turned.z, -_TURN_MAX, _TURN_MAX)
    stood = trot.past_stance[state.ring_at - params.delay_ticks - 1 & 15] & trot.past_stance[state.ring_at - 1 & 15]
    count = 0
    ahead = 0
    aside = 0
    for leg in range(LEGS):
        if stood >> leg & 1:
            foot = trot.measured.legs[leg]
            before = trot.before.legs[leg]
            x = foot.x >> 1
            y = foot.y >> 1
            z = foot.z >> 1
            ahead -= (foot.x - before.x << LF_BITS) + (about_y * z - about_z * y >> 9)
            aside -= (foot.y - before.y << LF_BITS) + (about_z * x - about_x * z >> 9)
            count += 1
    if count:
        share_q10 = params.trot.speed_filter_q10
        ahead = saturate(ahead // count - state.measured_speed.x, -_SPEED_MAX, _SPEED_MAX)
        aside = saturate(aside // count - state.measured_speed.y, -_SPEED_MAX, _SPEED_MAX)
        state.measured_speed.x += ahead * share_q10 + 512 >> 10
        state.measured_speed.y += aside * share_q10 + 512 >> 10


@hot
def start_residual(params: Params, trot: Trot) -> None:
    """Begin the residuals: take each unhindered foot to be where it was sent."""
    sent = (trot.state.ring_at - params.delay_ticks & 15) * LEGS
    for leg in range(LEGS):
        trot.expected_x_q4[leg] = trot.past_x[sent + leg] << 4
        trot.residual_x[leg] = trot.measured.legs[leg].x - trot.past_x[sent + leg]
        trot.expected_z_q4[leg] = trot.past_z[sent + leg] << 4


@hot
def update_residual(params: Params, trot: Trot) -> None:
    """Write how far each foot is, along x and z, from where an unhindered foot would be, and how fast x changes.

    That is where the goals that the joints now answer sent it, behind by the drives' lag for which the goals do not
    compensate. Error of a step: 1/16 lu. Intermediates: 2^17 * 2^12.
    """
    share_q12 = params.trot.response_q12
    sent = (trot.state.ring_at - params.delay_ticks & 15) * LEGS
    for leg in range(LEGS):
        foot = trot.measured.legs[leg]
        ahead = trot.expected_x_q4[leg]
        up = trot.expected_z_q4[leg]
        gap = (trot.past_x[sent + leg] << 4) - ahead
        rise = (trot.past_z[sent + leg] << 4) - up
        if gap > _GAP_MAX or gap < -_GAP_MAX or rise > _GAP_MAX or rise < -_GAP_MAX:
            gap = saturate(gap, -_GAP_MAX, _GAP_MAX)
            rise = saturate(rise, -_GAP_MAX, _GAP_MAX)
        ahead += gap * share_q12 + 2048 >> 12
        up += rise * share_q12 + 2048 >> 12
        trot.expected_x_q4[leg] = ahead
        trot.expected_z_q4[leg] = up
        residual = foot.x - (ahead >> 4)
        trot.residual_rate[leg] = residual - trot.residual_x[leg]
        trot.residual_x[leg] = residual
        trot.residual_z[leg] = foot.z - (up >> 4)
