"""What the legs tell: where the feet are, how far the body has moved over them, how much each carries.

Forward kinematics of the measured joints (paper A eqs 1-6) give the feet in the body; roll and
pitch turn them level. A foot that stands does not move, so the body moves against the mean of the
standing feet; the foot is round, so its contact rolls on by radius times the shank's turn. The
joints give in proportion to their load, so goal minus measured, times stiffness, is the torque, and
two torques are the foot's force along the leg:

    F = (ak t3 - ac t2') / (-L2 L3 sin q3),  ak = L2 cos q2, ac = L3 cos(q2 + q3), t2' = t2 - t3

with t2' = t2 where the calf's motor is on the body (paper B).
"""

from .fixed import cos_q15, saturate, sin_q15
from .params import (
    JOINTS,
    LEGS,
    LF_BITS,
    Params,
)
from .runtime import Ints, const, hot

M_LEVEL = const(0)  # 12 lu: the feet from the middle of the hips, in level axes that turn with the body
M_FORCE_Q12 = const(12)  # 4 values: each foot's force along its leg, of the own weight
M_ROLLED = const(16)  # 8 lu: x, y of each foot less what it rolled
M_BEFORE = const(24)  # 8 lu: the same in the tick before
M_JOINTS = const(32)  # 12 brad: the joints in the tick before
M_KNOWN = const(44)  # ticks that were measured in a row, up to 100
M_MOVED_X = const(45)  # lf: how far the body moved in this tick, level axes
M_MOVED_Y = const(46)
M_SENT_AT = const(47)  # where in the ring the next goals go
M_SENT = const(48)  # 16 * 12 brad: the goals of the last 16 ticks
# What is the same for all legs in a tick
M_ROLL = const(240)  # brad
M_PITCH = const(241)
M_ROLL_SINE_Q13 = const(242)
M_ROLL_COSINE_Q13 = const(243)
M_PITCH_SINE_Q13 = const(244)
M_PITCH_COSINE_Q13 = const(245)
M_ROLLS_Q12 = const(246)  # lu that a foot rolls per brad
M_ANSWERED = const(247)  # where the goals begin that the measured joints answer; 0: there are none yet
SENSING_SIZE = const(248)

_BRAD_TO_RAD_Q26 = const(6434)  # 2 pi / 65536 in Q26 = 6433.98
_ERROR_MAX = const(4095)  # brad, 22 deg: beyond it a drive gives all it has anyway
_TURN_MAX = const(4095)  # brad per tick
_FORCE_MAX_Q12 = const(16383)
_STRAIGHT = const(1024)  # d / 2^13 below which the leg is too straight to tell a force


@hot
def sensing_reset(block: Ints) -> int:
    """Forget all that was measured, and the goals; return 0."""
    for at in range(SENSING_SIZE):
        block[at] = 0
    return 0


@hot
def keep_sent(block: Ints, joints: Ints) -> int:
    """Keep the goals that are sent in this tick (12 brad); return 0."""
    at = M_SENT + block[M_SENT_AT] * JOINTS
    for joint in range(JOINTS):
        block[at + joint] = joints[joint]
    block[M_SENT_AT] = block[M_SENT_AT] + 1 & 15
    return 0


@hot
def sense_legs(params: Params, joints: Ints, first: int, roll_brad: int, pitch_brad: int, block: Ints) -> int:
    """Take 12 measured joints from ``joints[first]`` on, update feet and forces; return the ticks known, up to 100.

    joints: brad, within +-32768; roll, pitch: brad, 0 where they are not known. M_LEVEL within 6 lu + 2e-4 of
    the foot's distance. M_FORCE_Q12 answers the goals of P_SENT_TICKS ticks ago and is limited to +-16383; it
    is 0 until there are any. Intermediates: 113510 * 8192 + 2^12 < 2^30.
    """
    block[M_ROLL] = roll_brad
    block[M_PITCH] = pitch_brad
    block[M_ROLL_SINE_Q13] = sin_q15(roll_brad) >> 2
    block[M_ROLL_COSINE_Q13] = cos_q15(roll_brad) >> 2
    block[M_PITCH_SINE_Q13] = sin_q15(pitch_brad) >> 2
    block[M_PITCH_COSINE_Q13] = cos_q15(pitch_brad) >> 2
    block[M_ROLLS_Q12] = params.foot_radius * _BRAD_TO_RAD_Q26 >> 14
    block[M_ANSWERED] = 0
    if block[M_KNOWN] > params.sent_ticks:
        block[M_ANSWERED] = M_SENT + (block[M_SENT_AT] - params.sent_ticks & 15) * JOINTS
    for leg in range(LEGS):
        sense_leg(params, leg, joints, first + leg * 3, block)
    for joint in range(JOINTS):
        block[M_JOINTS + joint] = joints[first + joint]
    if block[M_KNOWN] < 100:
        block[M_KNOWN] += 1
    return block[M_KNOWN]


@hot
def sense_leg(params: Params, leg: int, joints: Ints, at_joint: int, block: Ints) -> int:
    """Write one foot into M_LEVEL and M_ROLLED and its force into M_FORCE_Q12; return 0. Used by sense_legs.

    A foot is within 65534 lu of the body's middle along each axis, because leg and hip are within 32767 lu.
    """
    base = params.legs[leg]
    hip = joints[at_joint]
    thigh = joints[at_joint + 1]
    shank = thigh + joints[at_joint + 2]
    length = base.thigh_length
    knee_drop = length * cos_q15(thigh) + 0x4000 >> 15  # mul_q15 without its call, here and below
    place = base.hip
    x = place[0] - (length * sin_q15(thigh) + 0x4000 >> 15)
    length = base.calf_length
    calf_drop = length * cos_q15(shank) + 0x4000 >> 15
    x -= length * sin_q15(shank) + 0x4000 >> 15
    drop = knee_drop + calf_drop
    side = base.hip_length
    sine = sin_q15(hip)
    cosine = cos_q15(hip)
    y = place[1] + (side * cosine + 0x4000 >> 15) + (drop * sine + 0x4000 >> 15)
    z = place[2] + (side * sine + 0x4000 >> 15) - (drop * cosine + 0x4000 >> 15)
    keep_foot(leg, hip, shank, x, y, z, block)
    block[M_FORCE_Q12 + leg] = 0
    if block[M_ANSWERED]:
        block[M_FORCE_Q12 + leg] = leg_force(params, leg, joints, at_joint, knee_drop, calf_drop, block)
    return 0


@hot
def keep_foot(leg: int, hip_brad: int, shank_brad: int, x: int, y: int, z: int, block: Ints) -> int:
    """Turn a foot at (x, y, z) in the body level into M_LEVEL; write where its contact had been without rolling.

    x, y, z: lu within +-65534. hip, shank: angles of the leg in the body about x and y, brad. M_ROLLED: error at
    most 1/600 of the way rolled + 1 lu; its last values go to M_BEFORE. Returns 0. Used by sense_leg.
    Intermediates: 113510 * 8192 + 2^12 and 5147 * 32768.
    """
    at = leg * 3
    sine = block[M_PITCH_SINE_Q13]
    cosine = block[M_PITCH_COSINE_Q13]
    ahead = x * cosine + z * sine + 0x1000 >> 13
    z = z * cosine - x * sine + 0x1000 >> 13
    sine = block[M_ROLL_SINE_Q13]
    cosine = block[M_ROLL_COSINE_Q13]
    aside = y * cosine - z * sine + 0x1000 >> 13
    block[at] = ahead
    block[at + 1] = aside
    block[at + 2] = y * sine + z * cosine + 0x1000 >> 13
    at = M_ROLLED + leg * 2
    before = M_BEFORE + leg * 2
    block[before] = block[at]
    block[before + 1] = block[at + 1]
    rolls_q12 = block[M_ROLLS_Q12]
    shank_brad = (shank_brad + block[M_PITCH] + 0x8000 & 0xFFFF) - 0x8000
    hip_brad = (hip_brad + block[M_ROLL] + 0x8000 & 0xFFFF) - 0x8000
    block[at] = ahead - (rolls_q12 * shank_brad >> 12)
    block[at + 1] = aside + (rolls_q12 * hip_brad >> 12)
    return 0


@hot
def leg_force(
    params: Params, leg: int, joints: Ints, at_joint: int, knee_drop: int, calf_drop: int, block: Ints
) -> int:
    """Return the force of one foot along its leg from the errors of thigh and calf, Q12, +-16383.

    knee_drop, calf_drop: ak and ac of this file's head, lu. A calf motor on the body answers the errors of thigh
    and calf together. A leg within about 2 deg of straight gives 0. Intermediates: two halves of 32767 * 32767.
    """
    at = leg * 3 + 1
    sent = block[M_ANSWERED] + at
    thigh = joints[at_joint + 1]
    calf = joints[at_joint + 2]
    error = block[sent] - thigh
    turned = thigh - block[M_JOINTS + at]
    above = joint_torque(params.stiff_q8[1], params.damp_q8[1], error, turned)
    if params.coupled:
        error += block[sent + 1] - calf
        turned += calf - block[M_JOINTS + at + 1]
        below = joint_torque(params.stiff_q8[2], params.damp_q8[2], error, turned)
    else:
        error = block[sent + 1] - calf
        turned = calf - block[M_JOINTS + at + 1]
        below = joint_torque(params.stiff_q8[2], params.damp_q8[2], error, turned)
        above = saturate(above - below, -32767, 32767)
    base = params.legs[leg]
    arms = -((base.thigh_length * base.calf_length >> 13) * sin_q15(calf) + 0x4000 >> 15)
    if arms < _STRAIGHT and arms > -_STRAIGHT:
        return 0
    force = ((knee_drop * below >> 1) - (calf_drop * above >> 1)) // arms
    return saturate(force, -_FORCE_MAX_Q12, _FORCE_MAX_Q12)


@hot
def joint_torque(stiff_q8: int, damp_q8: int, error_brad: int, turned_brad: int) -> int:
    """Return a joint's torque, stiffness * error - damping * speed, in own weight times lu, +-32767.

    stiff, damp: P_STIFF_Q8 and P_DAMP_Q8 of the joint; error: goal minus measured; turned: way in one tick; each
    limited to +-4095 brad. Intermediates: 4095 * 32767 * 2.
    """
    if error_brad > _ERROR_MAX:
        error_brad = _ERROR_MAX
    elif error_brad < -_ERROR_MAX:
        error_brad = -_ERROR_MAX
    if turned_brad > _TURN_MAX:
        turned_brad = _TURN_MAX
    elif turned_brad < -_TURN_MAX:
        turned_brad = -_TURN_MAX
    torque = stiff_q8 * error_brad - damp_q8 * turned_brad >> 8
    if torque > 32767:
        return 32767
    if torque < -32767:
        return -32767
    return torque


@hot
def sense_moved(block: Ints, weights: Ints) -> int:
    """Write how far the body moved over the feet whose weight is above 0 into M_MOVED_...; return how many.

    Level axes that turn with the body, lf; 0 without such a foot or in the first tick. A foot's own way is
    limited to +-4095 lu a tick. About 1 % of the way in simulation.
    """
    count = 0
    x = 0
    y = 0
    if block[M_KNOWN] > 1:
        at = M_ROLLED
        before = M_BEFORE
        for leg in range(LEGS):
            if weights[leg] > 0:
                x -= saturate(block[at] - block[before], -_TURN_MAX, _TURN_MAX)
                y -= saturate(block[at + 1] - block[before + 1], -_TURN_MAX, _TURN_MAX)
                count += 1
            at += 2
            before += 2
    if count:
        x = (x << LF_BITS) // count
        y = (y << LF_BITS) // count
    block[M_MOVED_X] = x
    block[M_MOVED_Y] = y
    return count


@hot
def stands_level(params: Params, block: Ints) -> int:
    """Return 1 if all four feet are within 1/32 of the leg in height (7.5 mm for Caramelo), or unknown; else 0.

    A trot on a floor leaves them within half of that; one foot on an edge, or two beyond it, do not.
    """
    if block[M_KNOWN] == 0:
        return 1
    low = block[M_LEVEL + 2]
    high = low
    for at in range(M_LEVEL + 5, M_LEVEL + 12, 3):
        if block[at] < low:
            low = block[at]
        if block[at] > high:
            high = block[at]
    if high - low > params.leg_length >> 5:
        return 0
    return 1
