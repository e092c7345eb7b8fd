"""Where the body is among its footholds: odometry of a walk with at least three feet down.

The tilt comes from the attitude filter as R = Rx(roll) Ry(pitch), the heading about the world's z is in
front of it, so a foot of the map is at b + Rz(heading) Rx Ry (hip + leg). For the small tilts of a walk this
is the ROS order but for roll times pitch. Stance feet stay where they are in the map, except that a round
foot rolls when its calf turns and that a foot which has slipped is followed slowly.
"""

from ..body.params import CALF, FL, FR, LEGS, LF_BITS, RL, RR, THIGH
from ..num.filters import fraction
from ..num.fixed import atan2_brad18, cos_q15, saturate, sin_q15
from ..runtime import Ints, const, hot
from ..sense.legs import Sensing
from .state import Crawl, Map

_LEAST_SHARE_Q8 = const(13)  # a stance foot always counts 5 %
_HALF_SHARE_Q12 = const(2048)  # only loaded feet tell of a slip: an unloaded one has risen with a tilting body
_NEAR_LU = const(16383)


@hot
def roll_feet(crawl: Crawl, joints: Ints) -> None:
    """Move the map places of the stance feet by how far their round feet have rolled.

    The centre of a foot of radius r moves by r times the turn of its calf (pitch + thigh + calf), along the
    heading. Turns above 840 brad in a tick are cut off. Largest intermediate 32767 * 32767.
    """
    map = crawl.map
    roll_q8 = crawl.params.foot_radius * 710 // 113
    pitch = map.body_pose.pitch >> LF_BITS
    yaw = map.body_pose.yaw >> LF_BITS
    for leg in range(LEGS):
        calf_pitch = pitch + joints[leg * 3 + THIGH] + joints[leg * 3 + CALF]
        turn = saturate(calf_pitch - map.calf_pitch[leg], -840, 840)
        map.calf_pitch[leg] = calf_pitch
        if crawl.support.stance[leg]:
            rolled = saturate(turn * roll_q8 >> 8, -32767, 32767)
            map.feet[leg].x += rolled * cos_q15(yaw) >> 15
            map.feet[leg].y += rolled * sin_q15(yaw) >> 15


@hot
def weigh_feet(crawl: Crawl) -> int:
    """Write how much each foot counts in the fit, Q8, into ``crawl.weights``; return the sum.

    0 in the air, 13 .. 256 by its share of the load.
    """
    support = crawl.support
    total = 0
    for leg in range(LEGS):
        weight = 0
        if support.stance[leg]:
            weight = saturate(support.share_q12[leg] >> 4, _LEAST_SHARE_Q8, 256)
        crawl.weights[leg] = weight
        total += weight
    return total


@hot
def fit_heading(crawl: Crawl, sensing: Sensing, total: int) -> int:
    """Return the heading, 2^-24 turn, that turns the levelled stance feet onto their map places best.

    Least squares in the plane (Procrustes): atan2(sum w (m x f), sum w (m . f)) about the weighted middles.
    total: 1 or more, the sum of ``crawl.weights``. Feet within 16383 lu * 2 of the middles.
    Intermediates: 2 * 16383^2 < 2^29; sums (2^19 + 1) * 256 * 4.
    """
    map = crawl.map
    weights = crawl.weights
    mx = 0
    my = 0
    fx = 0
    fy = 0
    for leg in range(LEGS):
        w = weights[leg]
        foot = map.feet[leg]
        mx += w * sensing.level[leg].x
        my += w * sensing.level[leg].y
        fx += w * (foot.x - map.body_pose.x >> LF_BITS)
        fy += w * (foot.y - map.body_pose.y >> LF_BITS)
    mx = mx // total
    my = my // total
    fx = fx // total
    fy = fy // total
    across = 0
    along = 0
    for leg in range(LEGS):
        w = weights[leg]
        foot = map.feet[leg]
        ax = saturate(sensing.level[leg].x - mx >> 1, -_NEAR_LU, _NEAR_LU)
        ay = saturate(sensing.level[leg].y - my >> 1, -_NEAR_LU, _NEAR_LU)
        bx = saturate((foot.x - map.body_pose.x >> LF_BITS) - fx >> 1, -_NEAR_LU, _NEAR_LU)
        by = saturate((foot.y - map.body_pose.y >> LF_BITS) - fy >> 1, -_NEAR_LU, _NEAR_LU)
        across += w * (ax * by - ay * bx >> 10)
        along += w * (ax * bx + ay * by >> 10)
    return atan2_brad18(across, along) << 6


@hot
def turn_feet(sensing: Sensing, map: Map) -> None:
    """Write the levelled feet, turned by the body's heading, as seen from the body's place.

    Intermediates: 45000 * 16383 * sqrt 2 < 2^30.
    """
    cosine = cos_q15(map.body_pose.yaw >> LF_BITS) >> 1
    sine = sin_q15(map.body_pose.yaw >> LF_BITS) >> 1
    for leg in range(LEGS):
        measured = map.measured[leg]
        level = sensing.level[leg]
        x = level.x
        y = level.y
        measured.x = x * cosine - y * sine + 32 >> 6
        measured.y = x * sine + y * cosine + 32 >> 6
        measured.z = level.z << LF_BITS


@hot
def fit_body(crawl: Crawl, sensing: Sensing) -> None:
    """Update heading and place of the body from the stance feet, and where the measured feet are.

    The place moves by the weighted mean of what separates the map places from the measured feet, in 1/16 lu,
    each within +-32767 lu. Intermediates: 2^19 * 256 * 4 = 2^29.
    """
    map = crawl.map
    weights = crawl.weights
    total = weigh_feet(crawl)
    map.body_pose.yaw = 0
    if crawl.params.lateral_q12 and total:
        map.body_pose.yaw = fit_heading(crawl, sensing, total)
    turn_feet(sensing, map)
    x = 0
    y = 0
    z = 0
    for leg in range(LEGS):
        foot = map.feet[leg]
        measured = map.measured[leg]
        x += weights[leg] * saturate(foot.x - map.body_pose.x - measured.x + 8 >> 4, -0x7FFFF, 0x7FFFF)
        y += weights[leg] * saturate(foot.y - map.body_pose.y - measured.y + 8 >> 4, -0x7FFFF, 0x7FFFF)
        z += weights[leg] * saturate(foot.z - map.body_pose.z - measured.z + 8 >> 4, -0x7FFFF, 0x7FFFF)
    if total:
        map.body_pose.x += x // total << 4
        map.body_pose.y += y // total << 4
        map.body_pose.z += z // total << 4
    for leg in range(LEGS):
        measured = map.measured[leg]
        measured.x += map.body_pose.x
        measured.y += map.body_pose.y
        measured.z += map.body_pose.z


@hot
def follow_slips(crawl: Crawl) -> None:
    """Let the map's places of loaded feet follow slowly where the feet are measured.

    Only feet that carry count, with more than half their share; in the plane, where no diagonal offset brings an
    unloaded foot down again, the others too. A foot that is far off in height is followed fast: it stood on something
    that gave way.
    """
    params = crawl.params
    support = crawl.support
    map = crawl.map
    least = params.crawl.free_q12
    if params.lateral_q12 == 0:
        least = -0x8000
    far = params.crawl.slip_far << LF_BITS
    for leg in range(LEGS):
        if support.stance[leg] and support.share_q12[leg] > _HALF_SHARE_Q12 and support.force_q12[leg] > least:
            foot = map.feet[leg]
            measured = map.measured[leg]
            foot.x += fraction(saturate(measured.x - foot.x, -0xFFFFFF, 0xFFFFFF), params.crawl.slip_level_q15)
            foot.y += fraction(saturate(measured.y - foot.y, -0xFFFFFF, 0xFFFFFF), params.crawl.slip_level_q15)
            gap = saturate(measured.z - foot.z, -0xFFFFFF, 0xFFFFFF)
            gain = params.crawl.slip_height_q15
            if gap > far or gap < -far:
                gain = params.crawl.slip_far_q15
            foot.z += fraction(gap, gain)


@hot
def mean_foot(map: Map, axis: int) -> int:
    """Return the mean of all four footholds along ``axis`` (0 x, 1 y, 2 z), lf. Exact but for the floor."""
    return map.feet[FR][axis] + map.feet[FL][axis] + map.feet[RR][axis] + map.feet[RL][axis] >> 2


@hot
def front_to_hind(map: Map, axis: int) -> int:
    """Return how far the two front footholds together are before (axis 0) or above (2) both hind ones, lf. Exact."""
    return map.feet[FR][axis] + map.feet[FL][axis] - map.feet[RR][axis] - map.feet[RL][axis]
