"""Where the crawl's body goes before a leg lifts, in floats (m, rad, ticks): exact where the core goes step by step."""

import math

from . import crawl
from .fixed import limit
from .load import distance, left_of


class BodyMove:
    """The body's wanted pose on its way to a goal."""

    def __init__(self, k, pose):
        self.k = k
        self.wanted, self.start, self.goal = list(pose), list(pose), list(pose)
        self.tick, self.ticks, self.planned, self.acceleration = 0, 0, False, k.acceleration

    def step(self):
        """Take one tick of the way."""
        if self.tick < self.ticks:
            self.tick += 1
            share = crawl.quintic(self.tick / self.ticks)
            self.wanted = [a + share * (b - a) for a, b in zip(self.start, self.goal)]

    def plan(self, feet, leg, wanted_x, heavy, in_air, acceleration):
        """Begin a move that brings the centre of mass over ``wanted_x`` inside the support without ``leg``."""
        k, self.acceleration = self.k, acceleration
        pitch = crawl.slope_pitch(feet, k.half_length * 2 / 3)
        x, y = com_target(feet, leg, wanted_x, k.margin, k.planar)
        place = x - crawl.com_ahead((k.com_x, k.com_z), pitch), y
        ground = crawl.middle(feet)[2]
        tall = k.height + k.payload_height * heavy
        z = ground + crawl.body_height(feet, k.hips, k.sides, place, pitch, tall, k.reach, in_air)
        if in_air is not None:
            z = min(z, self.wanted[2])
        self.start, self.goal = list(self.wanted), [place[0], place[1], z, 0.0, pitch, 0.0]
        self.tick, self.ticks, self.planned = 0, self.how_long(), True

    def how_long(self):
        """Return the ticks of the move."""
        k, way = self.k, [b - a for a, b in zip(self.start, self.goal)]
        along = math.sqrt(way[0] ** 2 + way[1] ** 2)
        return crawl.move_seconds(along, way[2], way[4], k.half_length, self.acceleration, k.body_speed, k.body_ticks)


def com_target(feet, leg, wanted_x, margin, planar):
    """Return where the centre of mass goes before ``leg`` lifts: nearest to (wanted x, mean y), inside by a margin."""
    corners = [feet[other] for other in (0, 1, 3, 2) if other != leg]
    if planar:
        xs = [corner[0] for corner in corners]
        return limit(wanted_x, min(xs) + margin, max(xs) - margin), 0.0
    return nearest_inside(corners, margin, (wanted_x, crawl.middle(feet)[1]))


def nearest_inside(corners, margin, point):
    """Return the point nearest to ``point`` that is ``margin`` inside a triangle (against the clock).

    Where there is no room for the margin, the middle of the triangle's inscribed circle.
    """
    inner = shrunk(corners, margin)
    if inner is None:
        return incentre(corners)
    sides = list(zip(inner, inner[1:] + inner[:1]))
    if min([left_of(a, b, point) for a, b in sides]) >= 0:
        return point
    tries = [nearest_on(a, b, point) for a, b in sides]
    return min(tries, key=lambda at: (at[0] - point[0]) ** 2 + (at[1] - point[1]) ** 2)


def incentre(corners):
    """Return the middle of the inscribed circle: the corners weighted by the sides across from them."""
    across = [distance(corners[(i + 1) % 3], corners[(i + 2) % 3]) for i in range(3)]
    return tuple([sum([w * c[axis] for w, c in zip(across, corners)]) / sum(across) for axis in range(2)])


def shrunk(corners, margin):
    """Return the triangle whose sides lie ``margin`` inside, or None: similar to it about the inscribed circle."""
    a, b, c = corners
    middle = incentre(corners)
    radius = abs(left_of(a, b, c)) / (distance(a, b) + distance(b, c) + distance(c, a))
    if radius <= margin:
        return None
    share = 1 - margin / radius
    return [tuple([middle[i] + share * (corner[i] - middle[i]) for i in range(2)]) for corner in corners]


def nearest_on(a, b, point):
    """Return the nearest point of the way from a to b."""
    along = [b[0] - a[0], b[1] - a[1]]
    share = ((point[0] - a[0]) * along[0] + (point[1] - a[1]) * along[1]) / (along[0] ** 2 + along[1] ** 2)
    share = limit(share, 0.0, 1.0)
    return a[0] + share * along[0], a[1] + share * along[1]
