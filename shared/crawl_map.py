"""Where the body is among its footholds: odometry of a walk with at least three feet down.

The tilt comes from the attitude filter as R = Rx(roll) Ry(pitch), the heading about the world's z is in
front of it, so a foot of the map is at b + Rz(heading) Rx Ry (hip + leg). For the small tilts of a walk this
is the ROS order but for roll times pitch. Stance feet stay where they are in the map, except that a round
foot rolls when its shank turns and that a foot which has slipped is followed slowly.
"""

from .body import POSE_PITCH, POSE_YAW
from .crawl_layout import (
    C_BODY,
    C_CMD,
    C_EXPECT,
    C_FOOT,
    C_FORCE,
    C_FROM,
    C_LAGGED,
    C_ON_PRINT,
    C_PAST,
    C_POS,
    C_PRINT,
    C_PRINTS,
    C_REF,
    C_SEEN,
    C_SHANK,
    C_SHARE,
    C_SOURCE,
    C_STANDS,
    C_TARGET,
    C_TO,
    C_TOP,
    K_FAR,
    K_PLANAR,
    K_REBASE,
    K_ROLL_Q8,
    K_SLIP_FAR,
    K_SLIP_XY,
    K_SLIP_Z,
    PAST_SIZE,
)
from .filters import fraction
from .fixed import atan2_brad18, cos_q15, saturate, sin_q15
from .params import LEGS, LF_BITS
from .runtime import Ints, const, hot
from .sensing import Sensing

_LEAST_SHARE_Q8 = const(13)  # a stance foot always counts 5 %
_HALF_SHARE_Q12 = const(2048)  # only loaded feet tell of a slip: an unloaded one has risen with a tilting body
_LOADED_Q12 = const(379)  # 2 N of Caramelo's 21.6
_NEAR_LU = const(16383)


@hot
def roll_feet(settings: Ints, joints: Ints, state: Ints) -> int:
    """Move the map places of the stance feet by how far their round feet have rolled; return 0.

    The centre of a foot of radius r moves by r times the turn of its shank (pitch + thigh + calf), along the
    heading. Turns above 840 brad in a tick are cut off. Largest intermediate 32767 * 32767.
    """
    pitch = state[C_BODY + POSE_PITCH] >> LF_BITS
    yaw = state[C_BODY + POSE_YAW] >> LF_BITS
    for leg in range(LEGS):
        shank = pitch + joints[leg * 3 + 1] + joints[leg * 3 + 2]
        turn = saturate(shank - state[C_SHANK + leg], -840, 840)
        state[C_SHANK + leg] = shank
        if state[C_STANDS + leg]:
            way = saturate(turn * settings[K_ROLL_Q8] >> 8, -32767, 32767)
            state[C_FOOT + leg * 3] += way * cos_q15(yaw) >> 15
            state[C_FOOT + leg * 3 + 1] += way * sin_q15(yaw) >> 15
    return 0


@hot
def foot_weight_q8(state: Ints, leg: int) -> int:
    """Return how much a foot counts in the fit, 0 in the air, 13 .. 256 by its share of the load."""
    if state[C_STANDS + leg] == 0:
        return 0
    weight = state[C_SHARE + leg] >> 4
    if weight < _LEAST_SHARE_Q8:
        return _LEAST_SHARE_Q8
    return weight


@hot
def fit_heading(sensing: Sensing, state: Ints) -> int:
    """Return the heading, 2^-24 turn, that turns the levelled stance feet onto their map places best; 0 if none stand.

    Least squares in the plane (Procrustes): atan2(sum w (m x f), sum w (m . f)) about the weighted middles.
    Feet within 16383 lu * 2 of the middles. Intermediates: 2 * 16383^2 < 2^29; sums (2^19 + 1) * 256 * 4.
    """
    total = 0
    mx = 0
    my = 0
    fx = 0
    fy = 0
    for leg in range(LEGS):
        w = foot_weight_q8(state, leg)
        at = leg * 3
        total += w
        mx += w * sensing.level[at]
        my += w * sensing.level[at + 1]
        fx += w * (state[C_FOOT + at] - state[C_BODY] >> LF_BITS)
        fy += w * (state[C_FOOT + at + 1] - state[C_BODY + 1] >> LF_BITS)
    if total == 0:
        return 0
    mx = mx // total
    my = my // total
    fx = fx // total
    fy = fy // total
    across = 0
    along = 0
    for leg in range(LEGS):
        w = foot_weight_q8(state, leg)
        at = leg * 3
        ax = saturate(sensing.level[at] - mx >> 1, -_NEAR_LU, _NEAR_LU)
        ay = saturate(sensing.level[at + 1] - my >> 1, -_NEAR_LU, _NEAR_LU)
        bx = saturate((state[C_FOOT + at] - state[C_BODY] >> LF_BITS) - fx >> 1, -_NEAR_LU, _NEAR_LU)
        by = saturate((state[C_FOOT + at + 1] - state[C_BODY + 1] >> LF_BITS) - fy >> 1, -_NEAR_LU, _NEAR_LU)
        across += w * (ax * by - ay * bx >> 10)
        along += w * (ax * bx + ay * by >> 10)
    return atan2_brad18(across, along) << 6


@hot
def fit_body(settings: Ints, sensing: Sensing, state: Ints) -> int:
    """Update the heading and place of the body from the stance feet; return 0.

    The place moves by the weighted mean of what separates the map places from the measured feet, in 1/16 lu,
    each within +-32767 lu. Intermediates: 45000 * 16383 * sqrt 2 < 2^30, 2^19 * 256 * 4 = 2^29.
    """
    yaw = 0
    if settings[K_PLANAR] == 0:
        yaw = fit_heading(sensing, state)
    state[C_BODY + POSE_YAW] = yaw
    cosine = cos_q15(yaw >> LF_BITS) >> 1
    sine = sin_q15(yaw >> LF_BITS) >> 1
    total = 0
    dx = 0
    dy = 0
    dz = 0
    for leg in range(LEGS):
        at = leg * 3
        x = sensing.level[at]
        y = sensing.level[at + 1]
        turned_x = x * cosine - y * sine + 32 >> 6
        turned_y = x * sine + y * cosine + 32 >> 6
        state[C_SEEN + at] = turned_x
        state[C_SEEN + at + 1] = turned_y
        state[C_SEEN + at + 2] = sensing.level[at + 2] << LF_BITS
        w = foot_weight_q8(state, leg)
        total += w
        for axis in range(3):
            gap = state[C_FOOT + at + axis] - state[C_BODY + axis] - state[C_SEEN + at + axis] + 8 >> 4
            gap = w * saturate(gap, -0x7FFFF, 0x7FFFF)
            if axis == 0:
                dx += gap
            elif axis == 1:
                dy += gap
            else:
                dz += gap
    if total:
        state[C_BODY] += dx // total << 4
        state[C_BODY + 1] += dy // total << 4
        state[C_BODY + 2] += dz // total << 4
    for at in range(LEGS * 3):
        state[C_SEEN + at] += state[C_BODY + at % 3]
    return 0


@hot
def follow_slips(settings: Ints, state: Ints) -> int:
    """Let the map's places of loaded feet follow slowly where the feet are seen, and prints their feet; return 0.

    Only feet that carry count, with more than half their share; in the plane, where no warp brings an unloaded foot
    down again, the others too. A foot more than K_FAR off in height is followed fast: it stood on something that
    gave way.
    """
    least = _LOADED_Q12
    if settings[K_PLANAR]:
        least = -0x8000
    for leg in range(LEGS):
        at = leg * 3
        if state[C_STANDS + leg] and state[C_SHARE + leg] > _HALF_SHARE_Q12 and state[C_FORCE + leg] > least:
            for axis in range(3):
                gap = saturate(state[C_SEEN + at + axis] - state[C_FOOT + at + axis], -0xFFFFFF, 0xFFFFFF)
                gain = settings[K_SLIP_XY]
                if axis == 2:
                    gain = settings[K_SLIP_Z]
                    if gap > settings[K_FAR] or gap < -settings[K_FAR]:
                        gain = settings[K_SLIP_FAR]
                state[C_FOOT + at + axis] += fraction(gap, gain)
        if leg < 2 and state[C_STANDS + leg] and state[C_ON_PRINT + leg] and state[C_PRINTS + leg]:
            last = C_PRINT + leg * 12 + (state[C_PRINTS + leg] - 1) * 3
            for axis in range(3):
                state[last + axis] = state[C_FOOT + at + axis]
    return 0


@hot
def shift_points(state: Ints, at: int, count: int, dx: int, dy: int, dz: int) -> int:
    """Subtract (dx, dy, dz) from ``count`` points of three values from ``at`` on; return 0. Exact."""
    for _ in range(count):
        state[at] -= dx
        state[at + 1] -= dy
        state[at + 2] -= dz
        at += 3
    return 0


@hot
def rebase(settings: Ints, state: Ints) -> int:
    """Move the map's origin to the body's x and z if those are farther than K_REBASE; return 1 if it was moved.

    y stays, because its axis is the line that is walked along, until the body is half as far again off it: a new line.
    Farther out the body's next target, which is limited to 32767 lu, would be cut short.

    Exact: the same whole number is taken from everything that is a place, so nothing in the robot's
    motion changes, and the numbers stay within 2^16 lu however far it walks.
    """
    far = 0
    aside = settings[K_REBASE] * 3 >> 1
    for axis in range(3):
        most = settings[K_REBASE]
        if axis == 1:
            most = aside
        if state[C_BODY + axis] > most or state[C_BODY + axis] < -most:
            far = 1
    if far == 0:
        return 0
    dx = state[C_BODY]
    dy = 0
    if state[C_BODY + 1] > aside or state[C_BODY + 1] < -aside:
        dy = state[C_BODY + 1]
    dz = state[C_BODY + 2]
    shift_points(state, C_FOOT, 4, dx, dy, dz)
    shift_points(state, C_SEEN, 4, dx, dy, dz)
    shift_points(state, C_PRINT, 8, dx, dy, dz)
    shift_points(state, C_BODY, 1, dx, dy, dz)
    shift_points(state, C_REF, 1, dx, dy, dz)
    shift_points(state, C_FROM, 1, dx, dy, dz)
    shift_points(state, C_TO, 1, dx, dy, dz)
    shift_points(state, C_LAGGED, 1, dx, dy, dz)
    shift_points(state, C_CMD, 1, dx, dy, dz)
    shift_points(state, C_POS, 1, dx, dy, dz)
    shift_points(state, C_TARGET, 1, dx, dy, dz)
    state[C_SOURCE] -= dx
    state[C_SOURCE + 1] -= dy
    state[C_EXPECT] -= dz
    state[C_TOP] -= dz
    for at in range(PAST_SIZE):
        state[C_PAST + at] -= dx
    return far
