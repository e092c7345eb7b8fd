"""Where the crawl wants the body: over the legs that stay, as level as the ground lets it, and how it gets there.

A move of the body is a quintic in all six axes, long enough that the zero-moment point stays inside
the support (acceleration times z / g). A slow outer loop brings the measured pose to the wanted one: it
takes out what the joints still give after the sag is fed forward.
"""

from .body import POSE_PITCH, POSE_SIZE, POSE_Z, body_rotation, body_to_hip
from .crawl_layout import (
    C_BODY,
    C_BODY_TICK,
    C_BODY_TICKS,
    C_CMD,
    C_FOOT,
    C_FROM,
    C_HEAVY,
    C_INTEGRAL,
    C_LAGGED,
    C_LOW,
    C_REF,
    C_TO,
    C_WEIGHT,
    K_ACC,
    K_AHEAD,
    K_ARM_X,
    K_BODY_TICKS,
    K_BODY_V,
    K_COM_X,
    K_COM_Z,
    K_HEIGHT,
    K_KI,
    K_LAG,
    K_LIMIT_A,
    K_LIMIT_X,
    K_LOW,
    K_MARGIN,
    K_PLANAR,
    K_RATE,
    K_REACH,
    K_TALL,
)
from .filters import fraction, quintic_q15
from .fixed import atan2_brad, cos_q15, hypot, isqrt, mul_q15, saturate, sin_q15
from .leg import plane_length
from .params import LEGS, LF_BITS, Params
from .runtime import const, hot, ptr32
from .stability import point_inside

_SLOPE_SHARE_Q15 = const(26214)  # 0.8 of the slope of the feet: the rest is left to the legs
_PITCH_MAX = const(3129)  # brad, 0.3 rad
_KP_Q15 = const(9830)  # 0.3
_TURN_RATE_Q15 = const(6434)  # 2 pi / 32: brad times lu to lf
_OWN_Q12 = const(4096)
_LOAD_MAX_Q12 = const(10240)


@hot
def mean_foot(state, axis: int) -> int:
    """Return the mean of all four footholds along ``axis`` (0 x, 1 y, 2 z), lf. Exact but for the floor."""
    c = ptr32(state)
    at = C_FOOT + axis
    return (c[at] + c[at + 3] + c[at + 6] + c[at + 9]) >> 2


@hot
def feet_pitch(settings, state) -> int:
    """Return the body's pitch in brad that goes with the slope from hind to front feet, within +-0.3 rad.

    Going up (front feet higher) is pitch below 0: nose up. Feet closer than two thirds of half the body
    are taken as that far apart.
    """
    k = ptr32(settings)
    c = ptr32(state)
    dx = (c[C_FOOT] + c[C_FOOT + 3] - c[C_FOOT + 6] - c[C_FOOT + 9]) >> 1
    dz = (c[C_FOOT + 2] + c[C_FOOT + 5] - c[C_FOOT + 8] - c[C_FOOT + 11]) >> 1
    least = k[K_ARM_X] * 2 // 3 << LF_BITS
    if dx < least:
        dx = least
    return -saturate(mul_q15(atan2_brad(dz, dx), _SLOPE_SHARE_Q15), -_PITCH_MAX, _PITCH_MAX)


@hot
def mass_target(settings, state, leg: int, wanted_x: int, feet, weights, point) -> int:
    """Write into ``point`` (x, y in lu of the map) where the centre of mass goes before ``leg`` lifts; return 0.

    The nearest point to (wanted_x lu, mean y) that is K_MARGIN inside the triangle of the other three; in
    the plane, inside their range of x. feet (12 lu) and weights (4) are scratch.
    """
    k = ptr32(settings)
    c = ptr32(state)
    f = ptr32(feet)
    w = ptr32(weights)
    out = ptr32(point)
    low = 0x1FFFF
    high = -0x1FFFF
    for other in range(LEGS):
        w[other] = 1
        for axis in range(3):
            f[other * 3 + axis] = c[C_FOOT + other * 3 + axis] >> LF_BITS
        x = f[other * 3]
        if other == leg:
            w[other] = 0
        else:
            if x < low:
                low = x
            if x > high:
                high = x
    margin = k[K_MARGIN]
    out[0] = saturate(wanted_x, -32767, 32767)
    out[1] = mean_foot(state, 1) >> LF_BITS
    if k[K_PLANAR]:
        out[0] = saturate(wanted_x, low + margin, high - margin)
        out[1] = 0
    else:
        point_inside(feet, weights, margin, point)
    return 0


@hot
def resting_x(settings, state) -> int:
    """Return x in lu of the map where the centre of mass is to be without other wishes: the middle, ahead if heavy."""
    k = ptr32(settings)
    c = ptr32(state)
    return (mean_foot(state, 0) >> LF_BITS) + (k[K_AHEAD] * c[C_HEAVY] >> 12)


@hot
def longest_leg(params: Params, pose, rotation, feet, hip_feet, skip: int) -> int:
    """Return the longest leg but ``skip``, thigh joint to foot in lu, of a body in ``pose`` over ``feet``.

    pose: 6 values, lu and brad; feet: 12 lu; rotation (9) and hip_feet (12) are scratch. Error as plane_length.
    """
    body_rotation(pose, rotation)
    longest = 0
    for leg in range(LEGS):
        if leg != skip:
            body_to_hip(params, leg, pose, rotation, feet, hip_feet)
            length = plane_length(params, leg, hip_feet)
            if length > longest:
                longest = length
    return longest


@hot
def plan_body(params: Params, settings, state, point, skip: int, pose, rotation, feet, hip_feet) -> int:
    """Start a move of the body that brings its centre of mass over ``point`` (x, y lu); return its ticks.

    The height is K_HEIGHT above the feet (more under load), lowered until no leg but ``skip`` is longer than
    K_REACH; with a leg in the air (skip >= 0) it is not raised. The rest are scratch blocks.
    """
    k = ptr32(settings)
    c = ptr32(state)
    at = ptr32(point)
    w = ptr32(pose)
    f = ptr32(feet)
    pitch = feet_pitch(settings, state)
    ahead = mul_q15(k[K_COM_X], cos_q15(pitch)) + mul_q15(k[K_COM_Z], sin_q15(pitch))
    w[0] = at[0] - ahead
    w[1] = at[1]
    w[2] = (mean_foot(state, 2) >> LF_BITS) + k[K_HEIGHT] + (k[K_TALL] * c[C_HEAVY] >> 12)
    w[3] = 0
    w[4] = pitch
    w[5] = 0
    for axis in range(LEGS * 3):
        f[axis] = c[C_FOOT + axis] >> LF_BITS
    for _ in range(8):
        excess = longest_leg(params, pose, rotation, feet, hip_feet, skip) - k[K_REACH]
        if excess > 0:
            w[2] -= excess + 4
    if skip >= 0 and w[2] > c[C_REF + POSE_Z] >> LF_BITS:
        w[2] = c[C_REF + POSE_Z] >> LF_BITS
    for axis in range(POSE_SIZE):
        c[C_FROM + axis] = c[C_REF + axis]
        c[C_TO + axis] = w[axis] << LF_BITS
    c[C_BODY_TICK] = 0
    c[C_BODY_TICKS] = move_ticks(settings, state)
    return c[C_BODY_TICKS]


@hot
def move_ticks(settings, state) -> int:
    """Return how many ticks the body's planned move takes: its acceleration, its rise and its pitch limit it.

    sqrt(6 d / acc) s is a quintic's time at 1.04 of that acceleration. Ways within +-32767 lu.
    Intermediates: 6 * 32767 * 2^12 < 2^30; 2^16 * 2^14 = 2^30 - limited before.
    """
    k = ptr32(settings)
    c = ptr32(state)
    dx = c[C_TO] - c[C_FROM] >> LF_BITS
    dy = c[C_TO + 1] - c[C_FROM + 1] >> LF_BITS
    way = saturate(hypot(dx, dy), 0, 32767)
    square_q12 = saturate((6 * way << 12) // (k[K_ACC] + 1), 0, 65535)
    ticks = isqrt(square_q12 << 14) * k[K_RATE] >> 13
    rise = c[C_TO + POSE_Z] - c[C_FROM + POSE_Z]
    if rise < 0:
        rise = -rise
    turn = c[C_TO + POSE_PITCH] - c[C_FROM + POSE_PITCH] >> LF_BITS
    if turn < 0:
        turn = -turn
    nod = mul_q15(saturate(turn, 0, 32767), _TURN_RATE_Q15) * (k[K_ARM_X] >> 3)
    if nod > rise:
        rise = nod
    if rise // k[K_BODY_V] > ticks:
        ticks = rise // k[K_BODY_V]
    if ticks < k[K_BODY_TICKS]:
        ticks = k[K_BODY_TICKS]
    return ticks


@hot
def move_body(state) -> int:
    """Take one tick of the body's move; return 1 while it goes on, else 0. Error: 0.13 % of the way."""
    c = ptr32(state)
    if c[C_BODY_TICK] >= c[C_BODY_TICKS]:
        return 0
    c[C_BODY_TICK] += 1
    share = quintic_q15(c[C_BODY_TICK], c[C_BODY_TICKS])
    for axis in range(POSE_SIZE):
        c[C_REF + axis] = c[C_FROM + axis] + fraction(c[C_TO + axis] - c[C_FROM + axis], share)
    return 1


@hot
def hold_pose(settings, state) -> int:
    """Take one tick of the pose loop: from wanted and measured pose to the commanded one; return 0.

    Per axis: command = wanted + limited(0.3 e + integral), with e the wanted pose as late as the servos are
    (so the integral does not wind up in a move) less the measured one. Under load the legs give more, so
    the integral gain goes down with the weight. Ways within 2^24 of the fine units.
    """
    k = ptr32(settings)
    c = ptr32(state)
    load = saturate(c[C_WEIGHT], _OWN_Q12, _LOAD_MAX_Q12)
    gain = k[K_KI] * 4096 // load
    for axis in range(POSE_SIZE):
        limit = k[K_LIMIT_X]
        if axis > 2:
            limit = k[K_LIMIT_A]
        ref = c[C_REF + axis]
        c[C_LAGGED + axis] += fraction(ref - c[C_LAGGED + axis], k[K_LAG])
        error = saturate(c[C_LAGGED + axis] - c[C_BODY + axis], -0xFFFFFF, 0xFFFFFF)
        integral = saturate(c[C_INTEGRAL + axis] + fraction(error, gain), -limit, limit)
        c[C_INTEGRAL + axis] = integral
        c[C_CMD + axis] = ref + saturate(fraction(error, _KP_Q15) + integral, -limit, limit)
        away = saturate(c[C_BODY + axis] - ref, -0xFFFFFF, 0xFFFFFF)
        c[C_LOW + axis] += fraction(away - c[C_LOW + axis], k[K_LOW])
        if k[K_PLANAR] and (axis == 1 or axis == 3 or axis == 5):
            c[C_CMD + axis] = 0
    return 0
