"""One leg: forward and inverse kinematics, joint limits, and robot B's coupled calf.

Paper A, eqs 1-6, in the form that is right in every quadrant: with s = +1 left, -1 right and
k = -1 knee behind, +1 in front, the foot from the hip in body axes is

    a = L2 cos q2 + L3 cos(q2 + q3)
    x = -L2 sin q2 - L3 sin(q2 + q3),  y = s L1 cos q1 + a sin q1,  z = s L1 sin q1 - a cos q1

The paper's theta1 = q1, theta2 = -q2, theta3 = -q3. Paper B's leg (its eqs 1-12) is the same leg
in other axes. All four knee configurations differ only in the k of each leg.
"""

from ..num.fixed import atan2_brad18, cos_q15, isqrt, mul_q15, round_brad, round_sqrt, saturate, sin_q15
from ..runtime import Ints, const, hot
from .feet import Feet
from .params import CALF, LEGS, THIGH, Params

LIMIT_HIP = const(8)
LIMIT_THIGH = const(16)
LIMIT_CALF = const(32)


@hot
def leg_forward(params: Params, leg: int, joints: Ints, feet: Feet) -> None:
    """Write the foot of ``leg`` into ``feet`` from its three angles in ``joints``.

    joints: 12 brad, any value (they wrap). feet: lu, each from its hip in body axes.
    Error at most 3 lu + 4e-5 of the leg's length. Intermediates below 32767 * 32767 + 2^14.
    Paper A eqs 1-6 inverted (joint to foot).
    """
    base = params.legs[leg]
    foot = feet.legs[leg]
    at = leg * 3
    l2 = base.thigh_length
    l3 = base.calf_length
    l1 = base.hip_length
    thigh = joints[at + THIGH]
    calf_pitch = thigh + joints[at + CALF]
    foot.x = -mul_q15(l2, sin_q15(thigh)) - mul_q15(l3, sin_q15(calf_pitch))
    drop = mul_q15(l2, cos_q15(thigh)) + mul_q15(l3, cos_q15(calf_pitch))
    sine = sin_q15(joints[at])
    cosine = cos_q15(joints[at])
    foot.y = mul_q15(l1, cosine) + mul_q15(drop, sine)
    foot.z = mul_q15(l1, sine) - mul_q15(drop, cosine)


@hot
def leg_inverse(params: Params, leg: int, feet: Feet, joints: Ints) -> None:
    """Write the three angles of ``leg`` into ``joints`` for its foot in ``feet``.

    feet: lu, each from its hip in body axes, inside the reachable shell (reach_foot sees to that;
    outside it the nearest root is taken). joints: 12 brad, -32768 .. 32767. Never fails.
    Foot error through an exact forward kinematics: at most 0.05 mm for Caramelo and Parallel.
    Paper A eqs 1-6 without arccos: with d^2 = x^2 + a^2,
    |q3| = 2 atan2(sqrt((L2+L3)^2 - d^2), sqrt(d^2 - (L2-L3)^2)), and the two arctangents of q1 as
    one, of the product of two complex numbers. Intermediates: products of two sides of one
    triangle, below (L1^2 + (L2+L3)^2) < 2^30.
    """
    base = params.legs[leg]
    foot = feet.legs[leg]
    at = leg * 3
    x = foot.x
    y = foot.y
    z = foot.z
    l1 = base.hip_length
    drop_sq = y * y + z * z - l1 * l1
    if drop_sq < 0:
        drop_sq = 0
    drop = round_sqrt(drop_sq)
    length_sq = x * x + drop_sq
    outer = round_sqrt(base.outer_sq - length_sq)
    inner = round_sqrt(length_sq - base.inner_sq)
    bend = 2 * atan2_brad18(outer, inner)
    half_diff = base.half_diff
    if half_diff:
        lead = atan2_brad18(outer * inner >> 1, (length_sq >> 1) + half_diff)
    else:
        lead = bend >> 1
    if base.knee < 0:
        bend = -bend
        lead = -lead
    joints[at] = round_brad(atan2_brad18(y * drop + z * l1, y * l1 - z * drop))
    joints[at + THIGH] = round_brad(-atan2_brad18(x, drop) - lead)
    joints[at + CALF] = round_brad(bend)


@hot
def plane_length(params: Params, leg: int, hip_feet: Feet) -> int:
    """Return the distance d from thigh joint to foot, lu, of ``leg``'s foot in ``hip_feet``, in reach or not.

    hip_feet: lu from the hips in body axes, any. Halves of the sides are limited to 16383 lu: 3 * 2^28 in the
    sum of squares. Error at most 4 lu up to 32767 lu. With L1: d^2 = x^2 + y^2 + z^2 - L1^2 (paper A eqs 1-6).
    """
    foot = hip_feet.legs[leg]
    x = saturate(foot.x >> 1, -16383, 16383)
    y = saturate(foot.y >> 1, -16383, 16383)
    z = saturate(foot.z >> 1, -16383, 16383)
    side = params.legs[leg].hip_length >> 1
    return 2 * isqrt(x * x + y * y + z * z - side * side)


@hot
def limit_legs(params: Params, joints: Ints, flags: Ints) -> int:
    """Limit 12 ``joints`` to the joint limits; add the limits that acted to each leg's ``flags``; return all together.

    joints: brad within -32768 .. 32767, changed in place. flags: 4, each gets LIMIT_HIP, LIMIT_THIGH, LIMIT_CALF or
    several. Exact.
    """
    together = 0
    at = 0
    for leg in range(LEGS):
        lowest = params.legs[leg].lowest
        highest = params.legs[leg].highest
        hip = joints[at]
        thigh = joints[at + THIGH]
        calf = joints[at + CALF]
        if hip < lowest.hip or hip > highest.hip or thigh < lowest.thigh or thigh > highest.thigh or (
            calf < lowest.calf or calf > highest.calf
        ):
            acted = limit_leg(params, leg, joints)
            flags[leg] |= acted
            together |= acted
        at += 3
    return together


@hot
def limit_leg(params: Params, leg: int, joints: Ints) -> int:
    """Limit the joints of one leg as limit_legs does; return the flags of the limits that acted."""
    limb = params.legs[leg]
    acted = 0
    for joint in range(3):
        at = leg * 3 + joint
        angle = joints[at]
        joints[at] = saturate(angle, limb.lowest[joint], limb.highest[joint])
        if joints[at] != angle:
            acted |= LIMIT_HIP << joint
    return acted
