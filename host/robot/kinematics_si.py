"""One leg in SI floats: paper A's eqs 1-6 with atan2, for checks outside the integer core.

Frame of the hip: x forward, y left, z up; ``side`` is +1 left, -1 right; ``knee`` is -1 for a knee
behind the hip (elbow), +1 in front. Angles (hip, thigh, calf) in rad, 0 is straight down.
"""

from math import acos, atan2, cos, pi, sin, sqrt

Vector = tuple[float, float, float]


def leg_forward(links_m: Vector, side: int, joints_rad: Vector) -> Vector:
    """Return the foot (x, y, z) in m from the hip. ``links_m``: hip offset, thigh, calf."""
    l1, l2, l3 = links_m
    hip, thigh, calf = joints_rad
    drop = l2 * cos(thigh) + l3 * cos(thigh + calf)
    x = -l2 * sin(thigh) - l3 * sin(thigh + calf)
    return x, side * l1 * cos(hip) + drop * sin(hip), side * l1 * sin(hip) - drop * cos(hip)


def leg_inverse(links_m: Vector, side: int, knee: int, foot_m: Vector) -> Vector | None:
    """Return the three angles in rad that put the foot at ``foot_m``, or None if it is out of reach."""
    l1, l2, l3 = links_m
    x, y, z = foot_m
    drop_squared = y * y + z * z - l1 * l1
    if drop_squared < 0:
        return None
    drop = sqrt(drop_squared)
    cos_calf = (x * x + drop_squared - l2 * l2 - l3 * l3) / (2 * l2 * l3)
    if not -1 <= cos_calf <= 1:
        return None
    hip = atan2(y, -z) - atan2(side * l1, drop)
    calf = knee * acos(cos_calf)
    thigh = -atan2(x, drop) - atan2(l3 * sin(calf), l2 + l3 * cos(calf))
    return wrap(hip), wrap(thigh), calf


def wrap(angle_rad: float) -> float:
    """Return the same angle within -pi .. pi."""
    return (angle_rad + pi) % (2 * pi) - pi
