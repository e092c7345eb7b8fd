"""Follows uneven ground: footholds take the ground's twist, feet are lifted higher where it is rough.

Roll, pitch and height loops can't see the fourth way four feet can err: FR and RL high against FL
and RR. Two diagonal feet then carry everything. The legs measure it.
"""

from ..body.params import LEGS, Params
from ..gait.steps import Steps
from ..num.fixed import cos_q15, saturate, sin_q15
from ..runtime import const, hot
from ..sense.legs import Sensing

_ROUGH_FROM = const(455)  # brad, 2.5 deg: what walking on the flat tilts
_ROUGH_RANGE = const(637)  # brad, 3.5 deg more: full extra lift


@hot
def twist(sensing: Sensing, roll_brad: int, pitch_brad: int) -> int:
    """Return the mean of FR, RL minus FL, RR of the measured feet's heights over the ground's plane, lu.

    sensing: a block of sense_legs; roll, pitch: how the ground's plane lies in level axes, brad. Error at most 4 lu.
    Intermediates: 4 * 65535 * 2^12 at most (feet as sense_legs leaves them).
    """
    x = sensing.level[0] - sensing.level[3] - sensing.level[6] + sensing.level[9] >> 2
    y = sensing.level[1] - sensing.level[4] - sensing.level[7] + sensing.level[10] >> 2
    z = sensing.level[2] - sensing.level[5] - sensing.level[8] + sensing.level[11] >> 2
    z = z * (cos_q15(pitch_brad) >> 2) - x * (sin_q15(pitch_brad) >> 2) >> 13
    return z * (cos_q15(roll_brad) >> 2) + y * (sin_q15(roll_brad) >> 2) >> 13


@hot
def follow_twist(params: Params, now_lf: int, measured_lu: int) -> int:
    """Return the believed twist in lf, moved from ``now`` towards the measured one in lu.

    A step is a share of at most 1/24 of the leg's length; the result within 1/12 of it.
    Range: now within +-2^22, measured within +-2^20. Intermediates: 1365 * 32767 * 16.
    """
    leg = params.leg_length
    gap = saturate(measured_lu - (now_lf >> 8), -(leg // 24), leg // 24)
    most = (leg << 8) // 12
    return saturate(now_lf + (gap * params.warp_gain_q15 >> 7), -most, most)


@hot
def press_feet(params: Params, steps: Steps, twist_lu: int) -> int:
    """Move the footholds' heights to the twisted ground: standing feet slowly, swing feet by their aim; return 0."""
    most = params.foothold_step
    for leg in range(LEGS):
        step = steps.legs[leg]
        floor = params.legs[leg].rest[2]
        if leg == 0 or leg == 3:
            floor += twist_lu
        else:
            floor -= twist_lu
        step.to_z = floor
        if step.ticks == 0 and step.z != floor:
            step.z += saturate(floor - step.z, -most, most)
    return 0


@hot
def roughness(params: Params, now: int, roll_brad: int, pitch_brad: int) -> int:
    """Return the largest tilt of late in 1/16 brad: the present one, or the last one faded; now 0 .. 2^19."""
    if roll_brad < 0:
        roll_brad = -roll_brad
    if pitch_brad < 0:
        pitch_brad = -pitch_brad
    if pitch_brad > roll_brad:
        roll_brad = pitch_brad
    faded = now - ((now >> 4) * params.rough_decay_q15 >> 11)
    if roll_brad << 4 > faded:
        return saturate(roll_brad << 4, 0, 0x7FFFF)
    return faded


@hot
def extra_lift(params: Params, rough: int, behind_lf: int, speed: int) -> int:
    """Return how much higher than usual to lift, 0 .. 1/12 of the leg's length, lu.

    rough: from roughness; behind: lf, within +-2^22, how far the robot is behind its reference; speed: lf / tick,
    within +-2^19. Tilts from 2.5 to 6 deg, or a lag of 1/12 of the leg beyond the usual, raise it from 0 to all.
    """
    leg = params.leg_length
    if speed < 0:
        speed = -speed
    most = leg // 12
    by_tilt = saturate((rough >> 4) - _ROUGH_FROM, 0, _ROUGH_RANGE) * most // _ROUGH_RANGE
    usual = leg // 60 + (speed * saturate(params.late_ticks, 0, 255) >> 8)
    by_lag = saturate((behind_lf >> 8) - usual, 0, most)
    if by_lag > by_tilt:
        return by_lag
    return by_tilt
