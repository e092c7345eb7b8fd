"""What the legs tell: where the feet are, how far the body has moved over them, how much each carries.

Forward kinematics of the measured joints (paper A eqs 1-6) give the feet in the body; roll and
pitch turn them level. A foot that stands does not move, so the body moves against the mean of the
standing feet; the foot is round, so its contact rolls on by radius times the shank's turn. The
joints give in proportion to their load, so goal minus measured, times stiffness, is the torque, and
two torques are the foot's force along the leg:

    F = (ak t3 - ac t2') / (-L2 L3 sin q3),  ak = L2 cos q2, ac = L3 cos(q2 + q3), t2' = t2 - t3

with t2' = t2 where the calf's motor is on the body (paper B).
"""

from .fixed import cos_q15, mul_q15, saturate, sin_q15
from .params import (
    JOINTS,
    LEG_HIP,
    LEG_L2,
    LEG_L3,
    LEG_SIDE_L1,
    LEG_SIZE,
    LEGS,
    LF_BITS,
    P_COUPLED,
    P_DAMP_Q8,
    P_FOOT_RADIUS,
    P_SENT_TICKS,
    P_SIZE_BODY,
    P_STIFF_Q8,
)
from .runtime import const, hot, ptr32

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
SENSING_SIZE = const(240)

_BRAD_TO_RAD_Q26 = const(6434)  # 2 pi / 65536 in Q26 = 6433.98
_ERROR_MAX = const(4095)  # brad, 22 deg: beyond it a drive gives all it has anyway
_TURN_MAX = const(4095)  # brad per tick
_PLACE_MAX = const(65535)  # lu, per axis
_FORCE_MAX_Q12 = const(16383)
_STRAIGHT = const(1024)  # d / 2^13 below which the leg is too straight to tell a force


@hot
def sensing_reset(block) -> int:
    """Forget all that was measured, and the goals; return 0."""
    m = ptr32(block)
    for at in range(SENSING_SIZE):
        m[at] = 0
    return 0


@hot
def keep_sent(block, joints) -> int:
    """Keep the goals that are sent in this tick (12 brad); return 0."""
    m = ptr32(block)
    q = ptr32(joints)
    at = M_SENT + m[M_SENT_AT] * JOINTS
    for joint in range(JOINTS):
        m[at + joint] = q[joint]
    m[M_SENT_AT] = m[M_SENT_AT] + 1 & 15
    return 0


@hot
def sense_legs(params, joints, first: int, roll_brad: int, pitch_brad: int, block) -> int:
    """Take 12 measured joints from ``joints[first]`` on, update feet and forces; return the ticks known, up to 100.

    joints: brad, within +-32768; roll, pitch: brad, 0 where they are not known. M_LEVEL within 6 lu + 2e-4 of
    the foot's distance, which is limited to +-65535 lu an axis. M_FORCE_Q12 answers the goals of P_SENT_TICKS
    ticks ago and is limited to +-16383; it is 0 until there are any. Intermediates: 113510 * 8192 + 2^12 < 2^30.
    """
    m = ptr32(block)
    q = ptr32(joints)
    sine_roll = sin_q15(roll_brad) >> 2
    cosine_roll = cos_q15(roll_brad) >> 2
    sine_pitch = sin_q15(pitch_brad) >> 2
    cosine_pitch = cos_q15(pitch_brad) >> 2
    for leg in range(LEGS):
        sense_leg(params, leg, joints, first + leg * 3, block)
        at = M_LEVEL + leg * 3
        x = m[at]
        y = m[at + 1]
        z = m[at + 2]
        m[at] = x * cosine_pitch + z * sine_pitch + 0x1000 >> 13
        z = z * cosine_pitch - x * sine_pitch + 0x1000 >> 13
        m[at + 1] = y * cosine_roll - z * sine_roll + 0x1000 >> 13
        m[at + 2] = y * sine_roll + z * cosine_roll + 0x1000 >> 13
        joint = first + leg * 3
        shank = q[joint + 1] + q[joint + 2] + pitch_brad
        roll_off(params, leg, q[joint] + roll_brad, shank, block)
    for joint in range(JOINTS):
        m[M_JOINTS + joint] = q[first + joint]
    if m[M_KNOWN] < 100:
        m[M_KNOWN] += 1
    return m[M_KNOWN]


@hot
def sense_leg(params, leg: int, joints, at_joint: int, block) -> int:
    """Write one foot in body axes into M_LEVEL and its force into M_FORCE_Q12; return 0. Used by sense_legs."""
    p = ptr32(params)
    q = ptr32(joints)
    m = ptr32(block)
    base = P_SIZE_BODY + leg * LEG_SIZE
    thigh = q[at_joint + 1]
    shank = thigh + q[at_joint + 2]
    knee_drop = mul_q15(p[base + LEG_L2], cos_q15(thigh))
    calf_drop = mul_q15(p[base + LEG_L3], cos_q15(shank))
    drop = knee_drop + calf_drop
    sine = sin_q15(q[at_joint])
    cosine = cos_q15(q[at_joint])
    l1 = p[base + LEG_SIDE_L1]
    hip = base + LEG_HIP
    at = M_LEVEL + leg * 3
    x = p[hip] - mul_q15(p[base + LEG_L2], sin_q15(thigh)) - mul_q15(p[base + LEG_L3], sin_q15(shank))
    m[at] = saturate(x, -_PLACE_MAX, _PLACE_MAX)
    y = p[hip + 1] + mul_q15(l1, cosine) + mul_q15(drop, sine)
    m[at + 1] = saturate(y, -_PLACE_MAX, _PLACE_MAX)
    m[at + 2] = mul_q15(l1, sine) - mul_q15(drop, cosine) + p[hip + 2]
    m[M_FORCE_Q12 + leg] = leg_force(params, leg, joints, at_joint, knee_drop, calf_drop, block)
    return 0


@hot
def leg_force(params, leg: int, joints, at_joint: int, knee_drop: int, calf_drop: int, block) -> int:
    """Return the force of one foot along its leg from the errors of thigh and calf, Q12, +-16383; 0 if unknown.

    knee_drop, calf_drop: ak and ac of this file's head, lu. A calf motor on the body answers the errors of thigh
    and calf together. A leg within about 2 deg of straight gives 0. Intermediates: two halves of 32767 * 32767.
    """
    p = ptr32(params)
    q = ptr32(joints)
    m = ptr32(block)
    if m[M_KNOWN] <= p[P_SENT_TICKS]:
        return 0
    base = P_SIZE_BODY + leg * LEG_SIZE
    at = leg * 3 + 1
    sent = M_SENT + (m[M_SENT_AT] - p[P_SENT_TICKS] & 15) * JOINTS + at
    thigh = q[at_joint + 1]
    calf = q[at_joint + 2]
    error = m[sent] - thigh
    turned = thigh - m[M_JOINTS + at]
    above = joint_torque(params, 1, error, turned)
    if p[P_COUPLED]:
        below = joint_torque(params, 2, error + m[sent + 1] - calf, turned + calf - m[M_JOINTS + at + 1])
    else:
        below = joint_torque(params, 2, m[sent + 1] - calf, calf - m[M_JOINTS + at + 1])
        above = saturate(above - below, -32767, 32767)
    arms = -mul_q15(p[base + LEG_L2] * p[base + LEG_L3] >> 13, sin_q15(calf))
    if arms < _STRAIGHT and arms > -_STRAIGHT:
        return 0
    force = ((knee_drop * below >> 1) - (calf_drop * above >> 1)) // arms
    return saturate(force, -_FORCE_MAX_Q12, _FORCE_MAX_Q12)


@hot
def joint_torque(params, joint: int, error_brad: int, turned_brad: int) -> int:
    """Return the torque of thigh (1) or calf (2): stiffness * error - damping * speed; own weight times lu, +-32767.

    error: goal minus measured; turned: way in one tick; each limited to +-4095 brad. Intermediates: 4095 * 32767 * 2.
    """
    p = ptr32(params)
    if error_brad > _ERROR_MAX:
        error_brad = _ERROR_MAX
    elif error_brad < -_ERROR_MAX:
        error_brad = -_ERROR_MAX
    if turned_brad > _TURN_MAX:
        turned_brad = _TURN_MAX
    elif turned_brad < -_TURN_MAX:
        turned_brad = -_TURN_MAX
    return saturate((p[P_STIFF_Q8 + joint] * error_brad - p[P_DAMP_Q8 + joint] * turned_brad) >> 8, -32767, 32767)


@hot
def roll_off(params, leg: int, hip_brad: int, shank_brad: int, block) -> int:
    """Write where the contact of ``leg`` would be had its foot not rolled into M_ROLLED, keep the last; return 0.

    hip, shank: angles of the leg in the world about x and y, brad. Error at most 1/600 of the way rolled + 1 lu.
    Intermediates: 5147 * 32768 and less.
    """
    p = ptr32(params)
    m = ptr32(block)
    per_brad_q12 = p[P_FOOT_RADIUS] * _BRAD_TO_RAD_Q26 >> 14
    at = leg * 2
    m[M_BEFORE + at] = m[M_ROLLED + at]
    m[M_BEFORE + at + 1] = m[M_ROLLED + at + 1]
    shank = (shank_brad + 0x8000 & 0xFFFF) - 0x8000
    hip = (hip_brad + 0x8000 & 0xFFFF) - 0x8000
    m[M_ROLLED + at] = m[M_LEVEL + leg * 3] - (per_brad_q12 * shank >> 12)
    m[M_ROLLED + at + 1] = m[M_LEVEL + leg * 3 + 1] + (per_brad_q12 * hip >> 12)
    return 0


@hot
def sense_moved(block, weights) -> int:
    """Write how far the body moved over the feet whose weight is above 0 into M_MOVED_...; return how many.

    Level axes that turn with the body, lf; 0 without such a foot or in the first tick. A foot's own way is
    limited to +-4095 lu a tick. About 1 % of the way in simulation.
    """
    m = ptr32(block)
    w = ptr32(weights)
    count = 0
    x = 0
    y = 0
    if m[M_KNOWN] > 1:
        for leg in range(LEGS):
            if w[leg] > 0:
                x -= saturate(m[M_ROLLED + leg * 2] - m[M_BEFORE + leg * 2], -_TURN_MAX, _TURN_MAX)
                y -= saturate(m[M_ROLLED + leg * 2 + 1] - m[M_BEFORE + leg * 2 + 1], -_TURN_MAX, _TURN_MAX)
                count += 1
    if count:
        x = (x << LF_BITS) // count
        y = (y << LF_BITS) // count
    m[M_MOVED_X] = x
    m[M_MOVED_Y] = y
    return count
