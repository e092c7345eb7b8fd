"""Where the crawl wants the body: over the legs that stay, as level as the ground lets it, and how it gets there.

A move of the body is a quintic in all six axes, long enough that the zero-moment point stays inside
the support (acceleration times z / g). A slow outer loop brings the measured pose to the wanted one: it
takes out what the joints still give after the sag is fed forward.
"""

from ..body.axes import POSE_AXES
from ..body.leg import plane_length
from ..body.params import LEGS, LF_BITS, Params
from ..body.pose import body_rotation, body_to_hip
from ..body.stability import point_inside
from ..num.filters import fraction, quintic_q15
from ..num.fixed import atan2_brad, cos_q15, hypot, isqrt, mul_q15, saturate, sin_q15
from ..runtime import const, hot
from .ground import long_strides
from .map import front_to_hind, mean_foot
from .state import BodyPath, Crawl, Map

_OWN_WEIGHT_Q12 = const(4096)
_TURN_RATE_Q15 = const(6434)  # 2 pi / 32: brad times lu to lf


@hot
def feet_pitch(params: Params, map: Map) -> int:
    """Return the body's pitch in brad that goes with the slope from hind to front feet, within its limit.

    Going up (front feet higher) is pitch below 0: nose up. Feet closer than two thirds of half the body
    are taken as that far apart.
    """
    dx = front_to_hind(map, 0) >> 1
    least = params.crawl.half_length * 2 // 3 << LF_BITS
    if dx < least:
        dx = least
    slope = atan2_brad(front_to_hind(map, 2) >> 1, dx)
    pitch = mul_q15(slope, params.crawl.slope_share_q15)
    return -saturate(pitch, -params.crawl.pitch_max, params.crawl.pitch_max)


@hot
def com_ahead(params: Params, pitch: int) -> int:
    """Return how far the centre of mass is in front of the body's place at ``pitch`` (brad), lu. Error 1 lu."""
    return mul_q15(params.com_x, cos_q15(pitch)) + mul_q15(params.crawl.com_z, sin_q15(pitch))


@hot
def take_feet(crawl: Crawl) -> None:
    """Write the map's feet into ``crawl.feet``, lu."""
    for leg in range(LEGS):
        place = crawl.map.feet[leg]
        foot = crawl.feet.legs[leg]
        foot.x = place.x >> LF_BITS
        foot.y = place.y >> LF_BITS
        foot.z = place.z >> LF_BITS


@hot
def com_target(crawl: Crawl, leg: int, wanted_x: int) -> None:
    """Write into ``crawl.point`` (x, y in lu of the map) where the centre of mass goes before ``leg`` lifts.

    The nearest point to (wanted_x lu, mean y) that is inside the triangle of the other three by the margin; in
    the plane, inside their range of x.
    """
    params = crawl.params
    map = crawl.map
    feet = crawl.feet
    weights = crawl.weights
    point = crawl.point
    low = 0x1FFFF
    high = -0x1FFFF
    take_feet(crawl)
    for other in range(LEGS):
        weights[other] = 1
        x = feet.legs[other].x
        if other == leg:
            weights[other] = 0
        else:
            if x < low:
                low = x
            if x > high:
                high = x
    margin = params.crawl.margin
    point.x = saturate(wanted_x, -32767, 32767)
    point.y = mean_foot(map, 1) >> LF_BITS
    if params.lateral_q12 == 0:
        point.x = saturate(wanted_x, low + margin, high - margin)
        point.y = 0
    else:
        point_inside(feet, weights, margin, point)


@hot
def resting_x(crawl: Crawl) -> int:
    """Return x in lu of the map where the centre of mass is to be without other wishes: the middle, ahead if heavy."""
    return (mean_foot(crawl.map, 0) >> LF_BITS) + (crawl.params.crawl.payload_forward * crawl.support.payload_q12 >> 12)


@hot
def longest_leg(crawl: Crawl, skip: int) -> int:
    """Return the longest leg but ``skip``, thigh joint to foot in lu, of a body in ``crawl.pose`` over ``crawl.feet``.

    Error as plane_length.
    """
    params = crawl.params
    body_rotation(crawl.pose, crawl.rotation)
    longest = 0
    for leg in range(LEGS):
        if leg != skip:
            body_to_hip(params, leg, crawl.pose, crawl.rotation, crawl.feet, crawl.hip_feet)
            length = plane_length(params, leg, crawl.hip_feet)
            if length > longest:
                longest = length
    return longest


@hot
def plan_body(crawl: Crawl, skip: int) -> int:
    """Start a move of the body that brings its centre of mass over ``crawl.point`` (x, y lu); return its ticks.

    The body is at its height above the feet (more under load), lowered until no leg but ``skip`` is longer than
    its reach; with a leg in the air (skip >= 0) it is not raised.
    """
    params = crawl.params
    map = crawl.map
    path = crawl.path
    pose = crawl.pose
    pitch = feet_pitch(params, map)
    pose.x = crawl.point.x - com_ahead(params, pitch)
    pose.y = crawl.point.y
    height = params.crawl.height + (params.crawl.payload_height * crawl.support.payload_q12 >> 12)
    pose.z = (mean_foot(map, 2) >> LF_BITS) + height
    pose.roll = 0
    pose.pitch = pitch
    pose.yaw = 0
    take_feet(crawl)
    for _ in range(8):
        excess = longest_leg(crawl, skip) - params.crawl.reach
        if excess > 0:
            pose.z -= excess + 4
    if skip >= 0 and pose.z > path.wanted.z >> LF_BITS:
        pose.z = path.wanted.z >> LF_BITS
    return start_body(crawl)


@hot
def start_body(crawl: Crawl) -> int:
    """Start a move of the body from where it should be now to ``crawl.pose`` (lu, brad); return its ticks.

    Its acceleration, its rise and its pitch limit it: sqrt(6 d / acc) s is a quintic's time at 1.04 of that
    acceleration. Ways within +-32767 lu. Intermediates: 6 * 32767 * 2^12 < 2^30; 2^16 * 2^14 = 2^30 - limited before.
    """
    path = crawl.path
    for axis in range(POSE_AXES):
        path.from_pose[axis] = path.wanted[axis]
        path.to_pose[axis] = crawl.pose[axis] << LF_BITS
    path.move_tick = 0
    path.move_ticks = move_ticks(crawl)
    return path.move_ticks


@hot
def move_ticks(crawl: Crawl) -> int:
    """Return how many ticks the body's planned move takes, as start_body says."""
    params = crawl.params
    path = crawl.path
    acceleration = params.crawl.body_acceleration
    if long_strides(crawl.ground):
        acceleration = params.crawl.quick_body_acceleration
    dx = path.to_pose.x - path.from_pose.x >> LF_BITS
    dy = path.to_pose.y - path.from_pose.y >> LF_BITS
    way = saturate(hypot(dx, dy), 0, 32767)
    square_q12 = saturate((6 * way << 12) // (acceleration + 1), 0, 65535)
    ticks = isqrt(square_q12 << 14) * params.rate_hz >> 13
    rise = path.to_pose.z - path.from_pose.z
    if rise < 0:
        rise = -rise
    turn = path.to_pose.pitch - path.from_pose.pitch >> LF_BITS
    if turn < 0:
        turn = -turn
    hip_rise = mul_q15(saturate(turn, 0, 32767), _TURN_RATE_Q15) * (params.crawl.half_length >> 3)
    if hip_rise > rise:
        rise = hip_rise
    if rise // params.crawl.body_speed > ticks:
        ticks = rise // params.crawl.body_speed
    if ticks < params.crawl.body_ticks:
        ticks = params.crawl.body_ticks
    return ticks


@hot
def move_body(path: BodyPath) -> int:
    """Take one tick of the body's move; return 1 while it goes on, else 0. Error: 0.13 % of the way."""
    if path.move_tick >= path.move_ticks:
        return 0
    path.move_tick += 1
    share = quintic_q15(path.move_tick, path.move_ticks)
    for axis in range(POSE_AXES):
        path.wanted[axis] = path.from_pose[axis] + fraction(path.to_pose[axis] - path.from_pose[axis], share)
    return 1


@hot
def hold_pose(crawl: Crawl) -> None:
    """Take one tick of the pose loop: from wanted and measured pose to the commanded one.

    Per axis: command = wanted + limited(0.3 e + integral), with e the wanted pose as late as the servos are
    (so the integral does not wind up in a move) less the measured one. Under load the legs give more, so
    the integral gain goes down with the weight. Ways within 2^24 of the fine units.
    """
    params = crawl.params
    map = crawl.map
    path = crawl.path
    gain = params.crawl.integral_q15
    if crawl.support.weight_q12 > _OWN_WEIGHT_Q12:
        gain = gain * _OWN_WEIGHT_Q12 // crawl.support.weight_q12
    limit = params.crawl.position_limit << LF_BITS
    for axis in range(POSE_AXES):
        if axis > 2:
            limit = params.crawl.angle_limit << LF_BITS
        wanted = path.wanted[axis]
        measured = map.body_pose[axis]
        path.lagged[axis] += fraction(wanted - path.lagged[axis], params.crawl.lag_q15)
        error = saturate(path.lagged[axis] - measured, -0xFFFFFF, 0xFFFFFF)
        integral = saturate(path.integral[axis] + fraction(error, gain), -limit, limit)
        path.integral[axis] = integral
        path.commanded[axis] = wanted + saturate(fraction(error, params.crawl.error_q15) + integral, -limit, limit)
        deviation = saturate(measured - wanted, -0xFFFFFF, 0xFFFFFF)
        path.deviation[axis] += fraction(deviation - path.deviation[axis], params.crawl.deviation_q15)
    if params.lateral_q12 == 0:
        path.commanded.y = 0
        path.commanded.roll = 0
        path.commanded.yaw = 0
