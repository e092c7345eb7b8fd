"""The crawl's swing in floats (m, s, rad): footholds, profiles of the foot, what it feels."""

import math


def first_footholds(hind, front, side):
    """Return x, z of the footholds a robot has behind it that came half a stride a leg: thirds right, sixths left."""
    shares = (2 / 6, 4 / 6, 6 / 6) if side == 0 else (1 / 6, 3 / 6, 5 / 6)
    return [(hind[0] + u * (front[0] - hind[0]), hind[1] + u * (front[1] - hind[1])) for u in shares]


def front_target(own_x, other_x, stride):
    """Return x of a front foothold: half a stride beyond the other, 0.5 to 1.4 strides beyond its own."""
    return min(max(other_x + stride / 2, own_x + stride / 2), own_x + 1.4 * stride)


def fall_speed(above, slow, fastest, brake):
    """Return the speed at which a foot may come down ``above`` its foothold: v^2 = slow^2 + 2 a h."""
    return min(fastest, math.sqrt(slow * slow + 2 * brake * max(0.0, above)))


def corner_lift(nose_up, left_up, arm_x, arm_y, leg):
    """Return how far the corner over a leg is above its plan for small tilts beyond it."""
    along = nose_up * arm_x if leg < 2 else -nose_up * arm_x
    across = left_up * arm_y if leg % 2 else -left_up * arm_y
    return along + across
