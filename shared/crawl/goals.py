"""The joint goals of the crawl: every leg by inverse kinematics, sag fed forward, and no jump anywhere.

Stance feet stay at their map places under the commanded pose; the swing foot follows its path under the
wanted pose, corrected by what the measured one was off it lately. Where a leg changes from one to the
other, and at the start, the goal's jump is taken into an offset that fades, unless the crawl rests.
"""

from ..body.axes import POSE_AXES
from ..body.compliance import sag_leg
from ..body.leg import leg_inverse, limit_legs, plane_length
from ..body.load import load_share
from ..body.params import JOINTS, LEGS, LF_BITS
from ..body.pose import body_rotation, body_to_hip
from ..body.reach import reach_foot
from ..body.stability import support_margin
from ..num.filters import fraction
from ..num.fixed import cos_q15, saturate, sin_q15
from ..runtime import Ints, const, hot
from .pose import com_ahead
from .state import REST, Crawl, Support

_LOWERED_LEGS = const(6)  # bits of FL and RR: they go down where FR and RL go up


@hot
def foot_offset(support: Support, leg: int) -> int:
    """Return by how much the diagonal offset raises a stance foot, lf: FR and RL by it, FL and RR against it."""
    if _LOWERED_LEGS >> leg & 1:
        return -support.diagonal_offset
    return support.diagonal_offset


@hot
def plan_loads(crawl: Crawl) -> int:
    """Write what each foot should carry under the wanted pose, and the margin; return the margin, lu."""
    params = crawl.params
    path = crawl.path
    support = crawl.support
    feet = crawl.feet
    weights = crawl.weights
    ahead = com_ahead(params, path.wanted.pitch >> LF_BITS)
    planar = 0
    if params.lateral_q12 == 0:
        planar = 1
    for leg in range(LEGS):
        weights[leg] = 0
        if support.stance[leg]:
            weights[leg] = support.share_q12[leg] >> 4
        place = crawl.map.feet[leg]
        foot = feet.legs[leg]
        foot.x = saturate(place.x - path.wanted.x >> LF_BITS, -32767, 32767)
        foot.y = saturate(place.y - path.wanted.y >> LF_BITS, -32767, 32767)
        foot.z = saturate(place.z - path.wanted.z >> LF_BITS, -32767, 32767)
    load_share(feet, weights, ahead, 0, support.weight_q12, planar, crawl.load)
    for leg in range(LEGS):
        support.load_q12[leg] = crawl.load.wanted_q12[leg]
        weights[leg] = support.stance[leg]
    support.margin = support_margin(feet, weights, ahead, 0)
    return support.margin


@hot
def take_pose(crawl: Crawl, swings: int) -> None:
    """Write the pose of stance (0) or swing (1) legs: place in ``crawl.pose`` x y z as lu, tilt in ``crawl.rotation``.

    The heading is left for foot_in_body; it is kept in the pose, whose roll and pitch are the tilt.
    """
    path = crawl.path
    pose = crawl.pose
    for axis in range(POSE_AXES):
        value = path.commanded[axis]
        if swings:
            value = path.wanted[axis] + path.deviation[axis]
        pose[axis] = value + 128 >> LF_BITS
    heading = pose.yaw
    pose.yaw = 0
    body_rotation(pose, crawl.rotation)
    pose.yaw = heading


@hot
def foot_in_body(crawl: Crawl, leg: int, x_lf: int, y_lf: int, z_lf: int) -> None:
    """Write the map place of the foot of ``leg`` as seen from the body's place, turned back by its heading.

    Into ``crawl.feet``, lu. Each axis within +-32767 lu. Intermediates: 2 * 32767 * 16384 = 2^30 - 2^15.
    """
    pose = crawl.pose
    foot = crawl.feet.legs[leg]
    x = saturate((x_lf + 128 >> LF_BITS) - pose.x, -32767, 32767)
    y = saturate((y_lf + 128 >> LF_BITS) - pose.y, -32767, 32767)
    cosine = cos_q15(pose.yaw) + 1 >> 1
    sine = sin_q15(pose.yaw) + 1 >> 1
    foot.x = x * cosine + y * sine >> 14
    foot.y = y * cosine - x * sine >> 14
    foot.z = saturate((z_lf + 128 >> LF_BITS) - pose.z, -32767, 32767)


@hot
def place_foot(crawl: Crawl, leg: int, swings: int) -> None:
    """Write the foot of ``leg``, standing (0) or swinging (1), from its hip into ``crawl.hip_feet``.

    Under the pose taken last. A swing leg's length is kept.
    """
    swing = crawl.swing
    if swings:
        foot_in_body(crawl, leg, swing.place.x, swing.place.y, swing.place.z)
    else:
        foot = crawl.map.feet[leg]
        foot_in_body(crawl, leg, foot.x, foot.y, foot.z + foot_offset(crawl.support, leg))
    body_to_hip(crawl.params, leg, crawl.level, crawl.rotation, crawl.feet, crawl.hip_feet)
    if swings:
        swing.leg_length = plane_length(crawl.params, leg, crawl.hip_feet)


@hot
def leg_goal(crawl: Crawl, leg: int, swings: int) -> int:
    """Solve one leg into ``crawl.joints`` under the pose taken last, with its sag if it stands; return reach flags."""
    rotation = crawl.rotation
    place_foot(crawl, leg, swings)
    flags = reach_foot(crawl.params, leg, crawl.hip_feet, crawl.reached)
    leg_inverse(crawl.params, leg, crawl.reached, crawl.joints)
    if swings == 0:
        load = crawl.support.load_q12[leg]
        fx = load * rotation[6] + 0x2000 >> 14
        fy = load * rotation[7] + 0x2000 >> 14
        fz = load * rotation[8] + 0x2000 >> 14
        sag_leg(crawl.params, leg, crawl.reached, fx, fy, fz, crawl.joints)
    return flags


@hot
def absorb_jump(crawl: Crawl, leg: int, swings: int) -> None:
    """Take the jump that ``leg`` would make by changing to stance (0) or swing (1) into its offsets."""
    take_pose(crawl, swings)
    leg_goal(crawl, leg, swings)
    for joint in range(leg * 3, leg * 3 + 3):
        crawl.jumps[joint] = saturate(crawl.goals[joint] - crawl.joints[joint], -32768, 32767) << LF_BITS


@hot
def solve_legs(crawl: Crawl) -> int:
    """Solve the stance legs under the commanded pose, the swing leg under the wanted one; return their reach flags."""
    together = 0
    take_pose(crawl, 0)
    for leg in range(LEGS):
        if crawl.support.stance[leg]:
            together |= leg_goal(crawl, leg, 0)
    for leg in range(LEGS):
        if crawl.support.stance[leg] == 0:
            take_pose(crawl, 1)
            together |= leg_goal(crawl, leg, 1)
    return together


@hot
def legs_goals(crawl: Crawl, joints: Ints) -> int:
    """Write all twelve goals (brad) of this tick into ``joints``; return the flags of reach and limits together."""
    crawl.swing.limited = 0
    together = solve_legs(crawl)
    for joint in range(JOINTS):
        jump = crawl.jumps[joint]
        joints[joint] = saturate(crawl.joints[joint] + (jump + 128 >> LF_BITS), -32768, 32767)
        gain = crawl.params.crawl.jump_q15
        if crawl.stage.stage == REST:
            gain = 0
        elif crawl.support.stance[joint // 3]:
            gain = crawl.params.crawl.land_jump_q15
        crawl.jumps[joint] = jump - fraction(jump, gain)
    for leg in range(LEGS):
        crawl.flags[leg] = 0
    together |= limit_legs(crawl.params, joints, crawl.flags)
    if crawl.flags[crawl.stage.leg]:
        crawl.swing.limited = 1
    for joint in range(JOINTS):
        crawl.goals[joint] = joints[joint]
    return together
