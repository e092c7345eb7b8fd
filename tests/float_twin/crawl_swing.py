"""The crawl's swing in floats (m, s, rad): footholds, profiles of the foot, what it feels."""

import math


def first_footholds(hind, front, side):
    """Return x, z of the footholds a robot has behind it that came half a stride a leg: thirds right, sixths left."""
    shares = (2 / 6, 4 / 6, 6 / 6) if side == 0 else (1 / 6, 3 / 6, 5 / 6)
    return [(hind[0] + u * (front[0] - hind[0]), hind[1] + u * (front[1] - hind[1])) for u in shares]


def front_target(own_x, other_x, stride):
    """Return x of a front foothold: half a stride beyond the other, 0.5 to 1.4 strides beyond its own."""
    return min(max(other_x + stride / 2, own_x + stride / 2), own_x + 1.4 * stride)


def front_top(own_z, other_z, other_x, target_x, lift, hit):
    """Return how high a front foot is lifted: over the other too, unless that stands beyond where it is to land."""
    counts = other_x <= target_x + hit * 5 / 3
    return max(own_z, other_z if counts else own_z) + lift


def rise(z, top, v_up, a_up, brake, v_top, period, ticks):
    """Return the heights of a foot going up tick by tick: it gains speed, and brakes before the top."""
    speed, heights = 0.0, []
    for _ in range(ticks):
        speed = min(speed + a_up * period, math.sqrt(2 * brake * max(0.0, top - z)) + v_top, v_up)
        z = min(top, z + speed * period)
        heights.append(z)
    return heights


def fall_speed(above, slow, fastest, brake):
    """Return the speed at which a hind foot may come down ``above`` its foothold: v^2 = slow^2 + 2 a h."""
    return min(fastest, math.sqrt(slow * slow + 2 * brake * max(0.0, above)))


def corner_lift(nose_up, left_up, arm_x, arm_y, leg):
    """Return how far the corner over a leg is above its plan for small tilts beyond it."""
    along = nose_up * arm_x if leg < 2 else -nose_up * arm_x
    across = left_up * arm_y if leg % 2 else -left_up * arm_y
    return along + across


def held_up(behind, least, way, seconds, lag):
    """Return whether a foot is farther behind its command than its mean speed and the servos' lag explain."""
    return behind > least + abs(way) / seconds * lag
