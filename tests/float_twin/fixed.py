"""The primitives as real numbers: what shared/num/fixed.py rounds. Plain math; runs on MicroPython too."""

import math


def sine(angle_brad):
    """Return the sine of an angle in 1/65536 turn."""
    return math.sin(2 * math.pi * angle_brad / 65536)


def cosine(angle_brad):
    """Return the cosine of an angle in 1/65536 turn."""
    return math.cos(2 * math.pi * angle_brad / 65536)


def angle_deg(y, x):
    """Return the angle of (x, y) in degrees, -180 <= angle < 180; (0, 0) gives 0."""
    angle = math.degrees(math.atan2(y, x))
    return -180.0 if angle >= 180.0 else angle


def length(*sides):
    """Return the square root of the sum of squares."""
    return math.sqrt(sum([side * side for side in sides]))


def limit(value, low, high):
    """Return ``value`` limited to ``low .. high``."""
    return low if value < low else high if value > high else value


def towards(now, wanted, step):
    """Return ``now`` moved towards ``wanted`` by at most ``step``."""
    return now + limit(wanted - now, -step, step)
