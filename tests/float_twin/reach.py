"""What a leg can reach, and where an unreachable foot goes: along the ray from the hip to the boundary."""

import math

from .fixed import length

TOO_FAR, TOO_NEAR, INSIDE_HIP = 1, 2, 4


def nearest_and_farthest(l1_m, l2_m, l3_m):
    """Return the shortest and the longest distance from hip to foot."""
    return length(l1_m, l2_m - l3_m), length(l1_m, l2_m + l3_m)


def usable(one):
    """Return the shortest and the longest distance from hip to foot that the limits of a leg's calf leave."""
    straight, bent = leg_lengths(one)
    near, far = nearest_and_farthest(one.l1, one.l2, one.l3)
    return max(near, length(one.l1, bent)), min(far, length(one.l1, straight))


def leg_lengths(one):
    """Return (straightest, most bent) distance from thigh joint to foot that the calf's limits leave."""
    ends = [math.sqrt(one.l2**2 + one.l3**2 + 2 * one.l2 * one.l3 * math.cos(q)) for q in (one.low[2], one.high[2])]
    return max(ends), min(ends)


def to_ends(foot_m, one):
    """Return how far a foot is within the longest leg, outside the shortest, and below where it is clear of the hip."""
    near, far = usable(one)
    distance = length(*foot_m)
    return far - distance, distance - near, -(near + one.l1) / 2 - foot_m[2]


def clear_of_hip(foot_m, one):
    """Return a trot's foot no higher than half way from the hip's offset to the leg's shortest below the hip."""
    x, y, z = foot_m
    return x, y, min(z, -(usable(one)[0] + one.l1) / 2)


def clamp(foot_m, l1_m, l2_m, l3_m, ends=None):
    """Return the reachable foot and the reasons it had to move, 0 if none; ``ends``: other than the leg's own.

    Too far and too near end on the sphere, inside the hip offset on the cylinder; a ray that leaves the sphere
    before it leaves the cylinder has no such point: then the foot goes straight out from the hip axis. Without a
    ray, at the hip or on its axis, the way out is down.
    """
    near, far = ends or nearest_and_farthest(l1_m, l2_m, l3_m)
    reasons = 0
    distance = length(*foot_m)
    if distance > far:
        reasons |= TOO_FAR
        foot_m = scaled(foot_m, far / distance)
    x, y, z = foot_m
    around = length(y, z)
    if around < l1_m:
        reasons |= INSIDE_HIP
        x, y, z = (x, 0.0, -l1_m) if around == 0 else scaled(foot_m, l1_m / around)
        if abs(x) > l2_m + l3_m:
            reasons |= TOO_FAR
            x = math.copysign(l2_m + l3_m, x)
    distance = length(x, y, z)
    if distance < near * (1 - 1e-12):
        reasons |= TOO_NEAR
        return (0.0, 0.0, -near) if distance == 0 else scaled((x, y, z), near / distance), reasons
    return (x, y, z), reasons


def scaled(vector, factor):
    """Return the vector times a number."""
    return tuple([part * factor for part in vector])
