"""The trot's rules in floats (m, rad, s), one per function, from their description and not from the core."""

import math


def follow(error, speed, moved, turned, most, yaw_most=0.35):
    """Return the (x, y, yaw) error to the reference after a tick, in the robot's turned axes."""
    x, y, yaw = error
    yaw = clip(yaw + speed[2] - turned, yaw_most)
    along = (speed[0] * math.cos(yaw) - speed[1] * math.sin(yaw), speed[1] * math.cos(yaw) + speed[0] * math.sin(yaw))
    x = clip(x + along[0] - moved[0], most)
    y = clip(y + along[1] - moved[1], most)
    return x * math.cos(turned) + y * math.sin(turned), y * math.cos(turned) - x * math.sin(turned), yaw


def clip(value, most):
    """Return value within -most .. most."""
    return max(-most, min(most, value))


def line_at(one, other, x):
    """Return y of the line through two points at x."""
    return one[1] + (other[1] - one[1]) * (x - one[0]) / (other[0] - one[0])


def smooth(u):
    """Return u^2 (3 - 2 u) for u limited to 0 .. 1."""
    u = max(0.0, min(1.0, u))
    return u * u * (3 - 2 * u)


def tip_forward(one, other, turned):
    """Return how far a turn (about x, y) tips forward about the line between two feet."""
    along = (other[0] - one[0], other[1] - one[1])
    if along[1] < 0:
        along = (-along[0], -along[1])
    return (turned[0] * along[0] + turned[1] * along[1]) / math.sqrt(along[0] ** 2 + along[1] ** 2)


def twist(feet, roll, pitch):
    """Return the mean of FR, RL minus FL, RR heights of level feet, seen from the ground's plane."""
    total = 0.0
    for sign, (x, y, z) in zip((1, -1, -1, 1), feet):
        down = -math.sin(pitch) * x + math.cos(pitch) * z
        total += sign * (math.sin(roll) * y + math.cos(roll) * down)
    return total / 4


def extra_lift(leg, tilt, behind, speed, late_s):
    """Return how much higher than usual to lift."""
    by_tilt = (math.degrees(tilt) - 2.5) / 3.5
    by_lag = (behind - leg / 60 - late_s * abs(speed)) / (leg / 12)
    return leg / 12 * max(0.0, min(1.0, max(by_tilt, by_lag)))


def pivot(height, roll, pitch):
    """Return P - R P for P = (0, 0, -height), R = Rx(roll) Ry(pitch): the shift that turns about the ground."""
    column = (math.sin(pitch), -math.sin(roll) * math.cos(pitch), math.cos(roll) * math.cos(pitch))
    return height * column[0], height * column[1], height * (column[2] - 1)
