"""The joint goals of the crawl: every leg by inverse kinematics, sag fed forward, and no jump anywhere.

Stance feet stay at their map places under the commanded pose; the swing foot follows its path under the
wanted pose, corrected by what the measured one was off it lately. Where a leg changes from one to the
other, and at the start, the goal's jump is taken into an offset that fades.
"""

from .body import POSE_PITCH, POSE_SIZE, POSE_YAW, body_rotation, body_to_hip
from .compliance import sag_leg
from .crawl_layout import (
    C_CLIPPED,
    C_CMD,
    C_FOOT,
    C_GOAL,
    C_LEG,
    C_LENGTH,
    C_LOAD,
    C_LOW,
    C_MARGIN,
    C_OFFSET,
    C_POS,
    C_REF,
    C_SHARE,
    C_STANDS,
    C_WARP,
    C_WEIGHT,
    K_COM_X,
    K_COM_Z,
    K_FADE,
    K_PLANAR,
)
from .crawl_state import Crawl
from .filters import fraction
from .fixed import cos_q15, mul_q15, saturate, sin_q15
from .leg import leg_inverse, limit_joints, plane_length
from .load import Load, load_share
from .params import JOINTS, LEGS, LF_BITS
from .reach import reach_foot
from .runtime import Ints, const, hot
from .stability import support_margin

_WARP_SIGNS = const(6)  # bits of the legs FL and RR: they go down where FR and RL go up


@hot
def warped(state: Ints, leg: int) -> int:
    """Return the warp of ``leg``, lf: + for FR and RL, - for FL and RR."""
    if _WARP_SIGNS >> leg & 1:
        return -state[C_WARP]
    return state[C_WARP]


@hot
def share_load(settings: Ints, state: Ints, feet: Ints, weights: Ints, load: Load) -> int:
    """Write into C_LOAD what each foot should carry under the wanted pose, and the margin; return the margin, lu.

    feet (12 lu), weights (4) and load (LOAD_SIZE) are scratch. The middle of mass is (K_COM_X, K_COM_Z) in
    the body, turned by the wanted pitch.
    """
    pitch = state[C_REF + POSE_PITCH] >> LF_BITS
    ahead = mul_q15(settings[K_COM_X], cos_q15(pitch)) + mul_q15(settings[K_COM_Z], sin_q15(pitch))
    for leg in range(LEGS):
        weights[leg] = 0
        if state[C_STANDS + leg]:
            weights[leg] = state[C_SHARE + leg] >> 4
        for axis in range(3):
            away = state[C_FOOT + leg * 3 + axis] - state[C_REF + axis] >> LF_BITS
            feet[leg * 3 + axis] = saturate(away, -32767, 32767)
    load_share(feet, weights, ahead, 0, saturate(state[C_WEIGHT], 0, 16383), settings[K_PLANAR], load)
    for leg in range(LEGS):
        state[C_LOAD + leg] = load.wanted_q12[leg]
        weights[leg] = state[C_STANDS + leg]
    state[C_MARGIN] = support_margin(feet, weights, ahead, 0)
    return state[C_MARGIN]


@hot
def take_pose(state: Ints, swings: int, pose: Ints, rotation) -> int:
    """Write the pose of stance (0) or swing (1) legs: place in ``pose`` x y z as lu, tilt in ``rotation``; return 0.

    The heading is left for foot_in_body; it is kept in pose[5], brad. pose[3 .. 4] hold the tilt.
    """
    for axis in range(POSE_SIZE):
        value = state[C_CMD + axis]
        if swings:
            value = state[C_REF + axis] + state[C_LOW + axis]
        pose[axis] = value + 128 >> LF_BITS
    heading = pose[POSE_YAW]
    pose[POSE_YAW] = 0
    body_rotation(pose, rotation)
    pose[POSE_YAW] = heading
    return 0


@hot
def foot_in_body(state: Ints, leg: int, swings: int, pose: Ints, feet: Ints) -> int:
    """Write the map place of a foot as seen from the body's place, turned back by its heading; return 0.

    feet: 12 lu out. Each axis within +-32767 lu. Intermediates: 2 * 32767 * 16384 = 2^30 - 2^15.
    """
    at = leg * 3
    if swings:
        x = state[C_POS]
        y = state[C_POS + 1]
        z = state[C_POS + 2]
    else:
        x = state[C_FOOT + at]
        y = state[C_FOOT + at + 1]
        z = state[C_FOOT + at + 2] + warped(state, leg)
    x = saturate((x + 128 >> LF_BITS) - pose[0], -32767, 32767)
    y = saturate((y + 128 >> LF_BITS) - pose[1], -32767, 32767)
    cosine = cos_q15(pose[POSE_YAW]) + 1 >> 1
    sine = sin_q15(pose[POSE_YAW]) + 1 >> 1
    feet[at] = x * cosine + y * sine >> 14
    feet[at + 1] = y * cosine - x * sine >> 14
    feet[at + 2] = saturate((z + 128 >> LF_BITS) - pose[2], -32767, 32767)
    return 0


@hot
def leg_goal(crawl: Crawl, leg: int, swings: int) -> int:
    """Solve one leg into ``crawl.joints`` under the pose taken last, with its sag if it stands; return reach flags."""
    c = crawl.state
    r = crawl.rotation
    foot_in_body(crawl.state, leg, swings, crawl.pose, crawl.feet)
    body_to_hip(crawl.limbs, leg, crawl.level, crawl.rotation, crawl.feet, crawl.hip_feet)
    if swings:
        c[C_LENGTH] = plane_length(crawl.limbs, leg, crawl.hip_feet)
    flags = reach_foot(crawl.limbs, leg, crawl.hip_feet, crawl.reached)
    leg_inverse(crawl.limbs, leg, crawl.reached, crawl.joints)
    if swings == 0:
        load = c[C_LOAD + leg]
        fx = load * r[6] + 0x2000 >> 14
        fy = load * r[7] + 0x2000 >> 14
        fz = load * r[8] + 0x2000 >> 14
        sag_leg(crawl.limbs, leg, crawl.reached, fx, fy, fz, crawl.joints)
    return flags


@hot
def bridge(crawl: Crawl, leg: int, swings: int) -> int:
    """Take the jump that ``leg`` would make by changing to stance (0) or swing (1) into its offsets; return 0."""
    c = crawl.state
    q = crawl.joints
    take_pose(crawl.state, swings, crawl.pose, crawl.rotation)
    leg_goal(crawl, leg, swings)
    for joint in range(leg * 3, leg * 3 + 3):
        c[C_OFFSET + joint] = saturate(c[C_GOAL + joint] - q[joint], -32768, 32767) << LF_BITS
    return 0


@hot
def legs_goals(crawl: Crawl, joints: Ints) -> int:
    """Write all twelve goals (brad) of this tick into ``joints``; return the flags of reach and limits together."""
    k = crawl.settings
    c = crawl.state
    q = crawl.joints
    c[C_CLIPPED] = 0
    together = 0
    take_pose(crawl.state, 0, crawl.pose, crawl.rotation)
    for leg in range(LEGS):
        if c[C_STANDS + leg]:
            together |= leg_goal(crawl, leg, 0)
    for leg in range(LEGS):
        if c[C_STANDS + leg] == 0:
            take_pose(crawl.state, 1, crawl.pose, crawl.rotation)
            together |= leg_goal(crawl, leg, 1)
    for joint in range(JOINTS):
        offset = c[C_OFFSET + joint]
        joints[joint] = saturate(q[joint] + (offset + 128 >> LF_BITS), -32768, 32767)
        c[C_OFFSET + joint] = offset - fraction(offset, k[K_FADE])
    for leg in range(LEGS):
        limited = limit_joints(crawl.limbs, leg, joints)
        if limited and leg == c[C_LEG]:
            c[C_CLIPPED] = 1
        together |= limited
    for joint in range(JOINTS):
        c[C_GOAL + joint] = joints[joint]
    return together
