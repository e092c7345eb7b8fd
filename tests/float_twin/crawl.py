"""The crawl's stages in floats (m, rad, s), one function each, from what they are for and not from the core.

Map: where the body is among its footholds. Pose: where it is to go. Goals: what the legs are told. Angles of a body
are roll, pitch, yaw with R = Rz(yaw) Rx(roll) Ry(pitch); legs FR, FL, RR, RL.
"""

import cmath
import math

from . import body as twin_body
from . import leg as twin_leg
from .fixed import limit


def heading(seen, places, weights):
    """Return the turn about z that brings the seen feet onto their places best: Procrustes with complex numbers."""
    total = sum(weights)
    a = [complex(*point[:2]) for point in seen]
    b = [complex(*point[:2]) for point in places]
    middle_a = sum([w * z for w, z in zip(weights, a)]) / total
    middle_b = sum([w * z for w, z in zip(weights, b)]) / total
    return cmath.phase(sum([w * (y - middle_b) * (x - middle_a).conjugate() for w, x, y in zip(weights, a, b)]))


def body_place(seen, places, weights, yaw):
    """Return where the body is: the weighted mean of places less turned seen feet."""
    total, turned = sum(weights), [turn(point, yaw) for point in seen]
    return [sum([w * (p[i] - s[i]) for w, p, s in zip(weights, places, turned)]) / total for i in range(3)]


def turn(point, yaw):
    """Return a point turned about z."""
    c, s = math.cos(yaw), math.sin(yaw)
    return [point[0] * c - point[1] * s, point[0] * s + point[1] * c, point[2]]


def rolled(radius, pitch_before, pitch, yaw):
    """Return how far (x, y) the contact of a round foot rolls on while its calf turns."""
    way = radius * (pitch - pitch_before)
    return way * math.cos(yaw), way * math.sin(yaw)


def uneven(feet, leg, came_from):
    """Return how far the footholds are off one slope along x, and a front leg's step off that slope too.

    The slope joins the middles of front and hind feet. ``came_from``: (x, z) of the leg's last foothold.
    """
    front, hind = middle(feet[:2]), middle(feet[2:])
    slope = (front[2] - hind[2]) / (front[0] - hind[0])
    off = [foot[2] - feet[0][2] - slope * (foot[0] - feet[0][0]) for foot in feet]
    spread = max(off) - min(off)
    if leg > 1:
        return spread
    step = feet[leg][2] - came_from[1] - slope * (feet[leg][0] - came_from[0])
    return max(spread, abs(step))


def middle(points):
    """Return the mean of some points."""
    return [sum([point[i] for point in points]) / len(points) for i in range(3)]


def slope_pitch(feet, least_m):
    """Return the body's pitch over the feet: 0.8 of their slope, nose up when they rise, within 0.3 rad."""
    front, hind = middle(feet[:2]), middle(feet[2:])
    slope = math.atan2(front[2] - hind[2], max(front[0] - hind[0], least_m))
    return -limit(0.8 * slope, -0.3, 0.3)


def com_ahead(com, pitch):
    """Return how far the centre of mass (x, z in the body) is ahead of the body's place when it pitches."""
    return com[0] * math.cos(pitch) + com[1] * math.sin(pitch)


def body_height(feet, hips, sides, place, pitch, wanted_m, reach_m, in_air=None):
    """Return the greatest height up to ``wanted`` above the feet's mean from which all legs reach, by bisection.

    ``in_air``: a leg that need not reach its old foothold.
    """
    ground = middle(feet)[2]

    def longest(height):
        pose = [place[0], place[1], ground + height, 0.0, pitch, 0.0]
        legs = [twin_body.from_base(pose, foot, hip) for foot, hip in zip(feet, hips)]
        lengths = [math.sqrt(max(0.0, x * x + y * y + z * z - s * s)) for (x, y, z), s in zip(legs, sides)]
        return max([length for leg, length in enumerate(lengths) if leg != in_air])

    if longest(wanted_m) <= reach_m:
        return wanted_m
    low, high = 0.0, wanted_m
    for _ in range(60):
        half = (low + high) / 2
        low, high = (half, high) if longest(half) <= reach_m else (low, half)
    return low


def move_seconds(way, rise, pitch, arm, acceleration, speed, least):
    """Return how long a body's move takes: sqrt(6 d / a) on the level, its speed in height and at the hips."""
    return max(math.sqrt(6 * way / acceleration), abs(rise) / speed, abs(pitch) * arm / speed, least)


def quintic(u):
    """Return the smooth share of a move."""
    return u**3 * (10 - 15 * u + 6 * u * u)


class PoseLoop:
    """One axis of the slow loop that brings the measured pose to the wanted one."""

    def __init__(self, start, lag, share, gain, most):
        self.lagged, self.integral = start, 0.0
        self.lag, self.share, self.gain, self.most = lag, share, gain, most

    def step(self, wanted, measured):
        """Return the pose to command in this tick."""
        self.lagged += self.lag * (wanted - self.lagged)
        error = self.lagged - measured
        self.integral = limit(self.integral + self.gain * error, -self.most, self.most)
        return wanted + limit(self.share * error + self.integral, -self.most, self.most)


def leg_joints(foot, pose, one):
    """Return the angles of a leg that put a foot of the map where it is, under a body with yaw in front of its tilt."""
    away = turn([foot[i] - pose[i] for i in range(3)], -pose[5])
    tilt = [0.0, 0.0, 0.0, pose[3], pose[4], 0.0]
    return twin_leg.inverse(twin_body.from_base(tilt, away, one.hip), one.side_l1, one.l2, one.l3, one.knee)
