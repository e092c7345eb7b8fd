"""Paper A's leg (eqs 1-6) in floats and metres, with arccosine, and paper B's coupled calf.

Frame of the hip: x forward, y left, z up. ``side_l1_m`` is the hip offset, + on the left; ``knee`` is
-1 for a knee behind the hip, +1 in front. Angles (hip, thigh, calf) in rad.
"""

import math

from .fixed import limit


def forward(joints_rad, side_l1_m, l2_m, l3_m):
    """Return the foot of a leg: three rotations applied one after the other, calf first."""
    hip, thigh, calf = joints_rad
    x, z = pitch(0.0, -l3_m, calf)
    x, z = pitch(x, z - l2_m, thigh)
    return x, side_l1_m * math.cos(hip) - z * math.sin(hip), side_l1_m * math.sin(hip) + z * math.cos(hip)


def pitch(x, z, angle_rad):
    """Return (x, z) turned about +y."""
    return x * math.cos(angle_rad) + z * math.sin(angle_rad), z * math.cos(angle_rad) - x * math.sin(angle_rad)


def inverse(foot_m, side_l1_m, l2_m, l3_m, knee):
    """Return the angles that put the foot there; outside the leg's shell, those of the nearest root."""
    x, y, z = foot_m
    drop = math.sqrt(max(0.0, y * y + z * z - side_l1_m * side_l1_m))
    cos_calf = (x * x + drop * drop - l2_m * l2_m - l3_m * l3_m) / (2 * l2_m * l3_m)
    calf = knee * math.acos(limit(cos_calf, -1.0, 1.0))
    thigh = -math.atan2(x, drop) - math.atan2(l3_m * math.sin(calf), l2_m + l3_m * math.cos(calf))
    return wrap(math.atan2(y, -z) - math.atan2(side_l1_m, drop)), wrap(thigh), calf


def wrap(angle_rad):
    """Return the same angle within -pi <= angle < pi."""
    return (angle_rad + math.pi) % (2 * math.pi) - math.pi
