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
from .runtime import Ints, const, hot
from .stability import point_inside

_SLOPE_SHARE_Q15 = const(26214)  # 0.8 of the slope of the feet: the rest is left to the legs
_PITCH_MAX = const(3129)  # brad, 0.3 rad
_KP_Q15 = const(9830)  # 0.3
_TURN_RATE_Q15 = const(6434)  # 2 pi / 32: brad times lu to lf
_OWN_Q12 = const(4096)
_LOAD_MAX_Q12 = const(10240)


@hot
def mean_foot(state: Ints, axis: int) -> int:
    """Return the mean of all four footholds along ``axis`` (0 x, 1 y, 2 z), lf. Exact but for the floor."""
    at = C_FOOT + axis
    return (state[at] + state[at + 3] + state[at + 6] + state[at + 9]) >> 2


@hot
def feet_pitch(settings: Ints, state: Ints) -> int:
    """Return the body's pitch in brad that goes with the slope from hind to front feet, within +-0.3 rad.

    Going up (front feet higher) is pitch below 0: nose up. Feet closer than two thirds of half the body
    are taken as that far apart.
    """
    dx = (state[C_FOOT] + state[C_FOOT + 3] - state[C_FOOT + 6] - state[C_FOOT + 9]) >> 1
    dz = (state[C_FOOT + 2] + state[C_FOOT + 5] - state[C_FOOT + 8] - state[C_FOOT + 11]) >> 1
    least = settings[K_ARM_X] * 2 // 3 << LF_BITS
    if dx < least:
        dx = least
    return -saturate(mul_q15(atan2_brad(dz, dx), _SLOPE_SHARE_Q15), -_PITCH_MAX, _PITCH_MAX)


@hot
def mass_target(settings: Ints, state: Ints, leg: int, wanted_x: int, feet: Ints, weights: Ints, point: Ints) -> int:
    """Write into ``point`` (x, y in lu of the map) where the centre of mass goes before ``leg`` lifts; return 0.

    The nearest point to (wanted_x lu, mean y) that is K_MARGIN inside the triangle of the other three; in
    the plane, inside their range of x. feet (12 lu) and weights (4) are scratch.
    """
    low = 0x1FFFF
    high = -0x1FFFF
    for other in range(LEGS):
        weights[other] = 1
        for axis in range(3):
            feet[other * 3 + axis] = state[C_FOOT + other * 3 + axis] >> LF_BITS
        x = feet[other * 3]
        if other == leg:
            weights[other] = 0
        else:
            if x < low:
                low = x
            if x > high:
                high = x
    margin = settings[K_MARGIN]
    point[0] = saturate(wanted_x, -32767, 32767)
    point[1] = mean_foot(state, 1) >> LF_BITS
    if settings[K_PLANAR]:
        point[0] = saturate(wanted_x, low + margin, high - margin)
        point[1] = 0
    else:
        point_inside(feet, weights, margin, point)
    return 0


@hot
def resting_x(settings: Ints, state: Ints) -> int:
    """Return x in lu of the map where the centre of mass is to be without other wishes: the middle, ahead if heavy."""
    return (mean_foot(state, 0) >> LF_BITS) + (settings[K_AHEAD] * state[C_HEAVY] >> 12)


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
def plan_body(
    params: Params, settings: Ints, state: Ints, point: Ints, skip: int, pose: Ints, rotation, feet: Ints, hip_feet
) -> int:
    """Start a move of the body that brings its centre of mass over ``point`` (x, y lu); return its ticks.

    The height is K_HEIGHT above the feet (more under load), lowered until no leg but ``skip`` is longer than
    K_REACH; with a leg in the air (skip >= 0) it is not raised. The rest are scratch blocks.
    """
    pitch = feet_pitch(settings, state)
    ahead = mul_q15(settings[K_COM_X], cos_q15(pitch)) + mul_q15(settings[K_COM_Z], sin_q15(pitch))
    pose[0] = point[0] - ahead
    pose[1] = point[1]
    pose[2] = (mean_foot(state, 2) >> LF_BITS) + settings[K_HEIGHT] + (settings[K_TALL] * state[C_HEAVY] >> 12)
    pose[3] = 0
    pose[4] = pitch
    pose[5] = 0
    for axis in range(LEGS * 3):
        feet[axis] = state[C_FOOT + axis] >> LF_BITS
    for _ in range(8):
        excess = longest_leg(params, pose, rotation, feet, hip_feet, skip) - settings[K_REACH]
        if excess > 0:
            pose[2] -= excess + 4
    if skip >= 0 and pose[2] > state[C_REF + POSE_Z] >> LF_BITS:
        pose[2] = state[C_REF + POSE_Z] >> LF_BITS
    for axis in range(POSE_SIZE):
        state[C_FROM + axis] = state[C_REF + axis]
        state[C_TO + axis] = pose[axis] << LF_BITS
    state[C_BODY_TICK] = 0
    state[C_BODY_TICKS] = move_ticks(settings, state)
    return state[C_BODY_TICKS]


@hot
def move_ticks(settings: Ints, state: Ints) -> int:
    """Return how many ticks the body's planned move takes: its acceleration, its rise and its pitch limit it.

    sqrt(6 d / acc) s is a quintic's time at 1.04 of that acceleration. Ways within +-32767 lu.
    Intermediates: 6 * 32767 * 2^12 < 2^30; 2^16 * 2^14 = 2^30 - limited before.
    """
    dx = state[C_TO] - state[C_FROM] >> LF_BITS
    dy = state[C_TO + 1] - state[C_FROM + 1] >> LF_BITS
    way = saturate(hypot(dx, dy), 0, 32767)
    square_q12 = saturate((6 * way << 12) // (settings[K_ACC] + 1), 0, 65535)
    ticks = isqrt(square_q12 << 14) * settings[K_RATE] >> 13
    rise = state[C_TO + POSE_Z] - state[C_FROM + POSE_Z]
    if rise < 0:
        rise = -rise
    turn = state[C_TO + POSE_PITCH] - state[C_FROM + POSE_PITCH] >> LF_BITS
    if turn < 0:
        turn = -turn
    nod = mul_q15(saturate(turn, 0, 32767), _TURN_RATE_Q15) * (settings[K_ARM_X] >> 3)
    if nod > rise:
        rise = nod
    if rise // settings[K_BODY_V] > ticks:
        ticks = rise // settings[K_BODY_V]
    if ticks < settings[K_BODY_TICKS]:
        ticks = settings[K_BODY_TICKS]
    return ticks


@hot
def move_body(state: Ints) -> int:
    """Take one tick of the body's move; return 1 while it goes on, else 0. Error: 0.13 % of the way."""
    if state[C_BODY_TICK] >= state[C_BODY_TICKS]:
        return 0
    state[C_BODY_TICK] += 1
    share = quintic_q15(state[C_BODY_TICK], state[C_BODY_TICKS])
    for axis in range(POSE_SIZE):
        state[C_REF + axis] = state[C_FROM + axis] + fraction(state[C_TO + axis] - state[C_FROM + axis], share)
    return 1


@hot
def hold_pose(settings: Ints, state: Ints) -> int:
    """Take one tick of the pose loop: from wanted and measured pose to the commanded one; return 0.

    Per axis: command = wanted + limited(0.3 e + integral), with e the wanted pose as late as the servos are
    (so the integral does not wind up in a move) less the measured one. Under load the legs give more, so
    the integral gain goes down with the weight. Ways within 2^24 of the fine units.
    """
    load = saturate(state[C_WEIGHT], _OWN_Q12, _LOAD_MAX_Q12)
    gain = settings[K_KI] * 4096 // load
    for axis in range(POSE_SIZE):
        limit = settings[K_LIMIT_X]
        if axis > 2:
            limit = settings[K_LIMIT_A]
        ref = state[C_REF + axis]
        state[C_LAGGED + axis] += fraction(ref - state[C_LAGGED + axis], settings[K_LAG])
        error = saturate(state[C_LAGGED + axis] - state[C_BODY + axis], -0xFFFFFF, 0xFFFFFF)
        integral = saturate(state[C_INTEGRAL + axis] + fraction(error, gain), -limit, limit)
        state[C_INTEGRAL + axis] = integral
        state[C_CMD + axis] = ref + saturate(fraction(error, _KP_Q15) + integral, -limit, limit)
        away = saturate(state[C_BODY + axis] - ref, -0xFFFFFF, 0xFFFFFF)
        state[C_LOW + axis] += fraction(away - state[C_LOW + axis], settings[K_LOW])
        if settings[K_PLANAR] and (axis == 1 or axis == 3 or axis == 5):
            state[C_CMD + axis] = 0
    return 0
