"""Six-degree-of-freedom body pose over feet that stay put (paper A, eqs 7-10).

R = Rx(roll) Ry(pitch) Rz(yaw): intrinsic x-y'-z'' order as the paper prints it (its eq 8), not the
fixed-axis roll-pitch-yaw of ROS. A foot at p in the base frame (the body frame at rest) is at
R^T (p - c) - h from a hip at h, with c the commanded translation (its eqs 9 and 10).
"""

from ..num.fixed import cos_q15, saturate, sin_q15
from ..runtime import Ints, hot
from .axes import Pose
from .feet import Feet
from .params import Params


@hot
def mul_unit(a_q15: int, b_q15: int) -> int:
    """Return the product of two Q15 numbers within +-32767, where 32767 stands for exactly 1.

    A rotation by 0 therefore changes nothing. Error at most 1/2 LSB beyond that convention.
    """
    if a_q15 == 32767:
        return b_q15
    if b_q15 == 32767:
        return a_q15
    return (a_q15 * b_q15 + 0x4000) >> 15


@hot
def body_rotation(pose: Pose, rotation: Ints) -> None:
    """Write R of paper A eq 8 as nine Q14 numbers, row by row, into ``rotation``.

    The angles may have any value. Each entry is within 2.5 LSB of Q14 (1.5e-4). Intermediates below 2^30.
    """
    sa = sin_q15(pose.roll)
    ca = cos_q15(pose.roll)
    sb = sin_q15(pose.pitch)
    cb = cos_q15(pose.pitch)
    sg = sin_q15(pose.yaw)
    cg = cos_q15(pose.yaw)
    rotation[0] = (mul_unit(cb, cg) + 1) >> 1
    rotation[1] = (1 - mul_unit(cb, sg)) >> 1
    rotation[2] = (sb + 1) >> 1
    sasb = mul_unit(sa, sb)
    casb = mul_unit(ca, sb)
    rotation[3] = (mul_unit(ca, sg) + mul_unit(sasb, cg) + 1) >> 1
    rotation[4] = (mul_unit(ca, cg) - mul_unit(sasb, sg) + 1) >> 1
    rotation[5] = (1 - mul_unit(sa, cb)) >> 1
    rotation[6] = (mul_unit(sa, sg) - mul_unit(casb, cg) + 1) >> 1
    rotation[7] = (mul_unit(sa, cg) + mul_unit(casb, sg) + 1) >> 1
    rotation[8] = (mul_unit(ca, cb) + 1) >> 1


@hot
def body_to_hip(params: Params, leg: int, pose: Pose, rotation: Ints, feet: Feet, hip_feet: Feet) -> None:
    """Write R^T (p - c) - h of ``leg`` into ``hip_feet`` (paper A eq 9).

    feet: lu in the base frame; hip_feet: lu, each from its hip in body axes. p - c is limited
    to +-65535 lu an axis. Error at most 0.08 mm at the foot for Caramelo and Parallel.
    Intermediates: 65535 * 16384 + 2^13 < 2^30 in each product.
    """
    hip = params.legs[leg].hip
    base = feet.legs[leg]
    foot = hip_feet.legs[leg]
    x = base.x - pose.x
    y = base.y - pose.y
    z = base.z - pose.z
    if x > 65535 or x < -65535 or y > 65535 or y < -65535 or z > 65535 or z < -65535:
        x = saturate(x, -65535, 65535)
        y = saturate(y, -65535, 65535)
        z = saturate(z, -65535, 65535)
    turned = (x * rotation[0] + 0x2000 >> 14) + (y * rotation[3] + 0x2000 >> 14) + (z * rotation[6] + 0x2000 >> 14)
    foot.x = turned - hip.x
    turned = (x * rotation[1] + 0x2000 >> 14) + (y * rotation[4] + 0x2000 >> 14) + (z * rotation[7] + 0x2000 >> 14)
    foot.y = turned - hip.y
    turned = (x * rotation[2] + 0x2000 >> 14) + (y * rotation[5] + 0x2000 >> 14) + (z * rotation[8] + 0x2000 >> 14)
    foot.z = turned - hip.z
