"""Brings a wanted foot into the leg's reachable shell, along the hip-foot ray, and says why.

The shell of the leg of paper A (eqs 1-6): its foot is never farther than
sqrt(L1^2 + (L2 + L3)^2), never nearer than sqrt(L1^2 + (L2 - L3)^2), and never inside the
cylinder of radius L1 about the hip axis; here the calf's limits make it narrower. No public implementation does
both: clamp and report.

A foot too far or too near moves along the ray from the hip to the boundary; one inside the hip offset
moves out along the ray too, unless the ray leaves the shell before it leaves the cylinder:
then it goes straight out from the hip axis and x is limited, and TOO_FAR is set as well.
A foot less than 1 lu outside the shell may be on it but for rounding, and passes as it is; a foot
more than 3 lu outside never does.
"""

from ..num.fixed import isqrt, round_sqrt
from ..runtime import const, hot
from .feet import Feet
from .params import Params

TOO_FAR = const(1)
TOO_NEAR = const(2)
INSIDE_HIP = const(4)


@hot
def scale_down(value: int, numerator: int, denominator: int) -> int:
    """Return value * numerator / denominator rounded towards 0; a denominator below 1 gives 0.

    Range: \\|value * numerator\\| < 2^30, any common unit.
    """
    if denominator < 1:
        return 0
    if value < 0:
        return -(-value * numerator // denominator)
    return value * numerator // denominator


@hot
def reach_foot(params: Params, leg: int, feet: Feet, reached: Feet) -> int:
    """Copy the foot of ``leg`` from ``feet`` to ``reached``, clamped if it must be; return why: 0 or the flags.

    feet, reached: lu, each from its hip; any 30 bits. Error 5 lu. Intermediates: 3/4 of 2^30 (quarter).
    """
    limb = params.legs[leg]
    wanted = feet.legs[leg]
    foot = reached.legs[leg]
    x = wanted.x
    y = wanted.y
    z = wanted.z
    flags = 0
    while x > 32767 or x < -32767 or y > 32767 or y < -32767 or z > 32767 or z < -32767:
        x >>= 1
        y >>= 1
        z >>= 1
        flags = TOO_FAR
    far = limb.longest
    quarter = (x * x >> 2) + (y * y >> 2) + (z * z >> 2)
    if flags or quarter > (far + 2) * (far + 2) >> 2:
        flags = TOO_FAR
        distance = 2 * isqrt(quarter) + 1
        x = scale_down(x, far, distance)
        y = scale_down(y, far, distance)
        z = scale_down(z, far, distance)
    foot.x = x
    foot.y = y
    foot.z = z
    radius = limb.hip_length
    if radius < 0:
        radius = -radius
    if radius > 1 and y * y + z * z < (radius - 1) * (radius - 1):
        flags |= leave_hip(params, leg, radius, reached)
    near = limb.shortest
    if near > 2 and foot.x * foot.x + foot.y * foot.y + foot.z * foot.z < (near - 2) * (near - 2):
        flags |= leave_centre(near, leg, reached)
    return flags


@hot
def leave_hip(params: Params, leg: int, radius: int, reached: Feet) -> int:
    """Move the foot of ``leg`` in ``reached`` out of the hip offset; return INSIDE_HIP, with TOO_FAR if x gave way.

    Used by reach_foot, on a foot within reach. Without a ray, on the hip axis, the way out is down. y and z
    are first doubled until one has 14 bits, so that a foot close to the axis keeps its direction.
    Intermediates: 32767 * 32767 at most.
    """
    limb = params.legs[leg]
    foot = reached.legs[leg]
    y = foot.y
    z = foot.z
    doubled = 0
    if y == 0 and z == 0:
        z = -radius
    while y < 0x2000 and y > -0x2000 and z < 0x2000 and z > -0x2000:
        y <<= 1
        z <<= 1
        doubled += 1
    around = round_sqrt(y * y + z * z)
    foot.y = scale_down(y, radius, around)
    foot.z = scale_down(z, radius, around)
    x = foot.x
    size = x
    if size < 0:
        size = -size
    limit = limb.thigh_length + limb.calf_length
    whole = size * radius // around
    flags = INSIDE_HIP
    if whole <= limit:
        size = (whole << doubled) + ((size * radius - whole * around << doubled) // around)
    if whole > limit or size > limit:
        size = limit
        flags |= TOO_FAR
    if x < 0:
        size = -size
    foot.x = size
    return flags


@hot
def leave_centre(near: int, leg: int, reached: Feet) -> int:
    """Move the foot of ``leg`` in ``reached`` out along its ray to the shortest leg; return TOO_NEAR.

    Used by reach_foot, on a foot outside the hip offset. At the hip itself there is no ray: straight down.
    """
    foot = reached.legs[leg]
    x = foot.x
    y = foot.y
    z = foot.z
    if x == 0 and y == 0 and z == 0:
        foot.z = -near
        return TOO_NEAR
    while x < 0x2000 and x > -0x2000 and y < 0x2000 and y > -0x2000 and z < 0x2000 and z > -0x2000:
        x <<= 1
        y <<= 1
        z <<= 1
    distance = isqrt(x * x + y * y + z * z)
    foot.x = scale_down(x, near, distance)
    foot.y = scale_down(y, near, distance)
    foot.z = scale_down(z, near, distance)
    return TOO_NEAR
