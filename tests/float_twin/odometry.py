"""The way over the feet in floats: least squares where the core has its integers, with exact rotations.

A foot is at (x, y) in the body's level axes, m, and has rolled by (x, y) since whenever; forces are parts of the
robot's own weight.
"""

import math

from .crawl import heading
from .fixed import limit

BIAS_RAD_S = math.radians(0.0075)
SMOOTH_S = 0.2


class Odometry:
    """One robot's: x, y, yaw, and the error vectors of its covariance."""

    def __init__(self, rate_hz, leg_m, delay_ticks):
        self.rate_hz, self.leg_m, self.delay_ticks = rate_hz, leg_m, delay_ticks
        self.share = 1 / (1 + SMOOTH_S * rate_hz)
        self.x = self.y = self.yaw = self.walked = self.slip = self.heading_sigma = 0.0
        self.vx = self.vy = self.wz = 0.0
        self.heading_spread = [0.0, 0.0]
        self.before, self.stance_ticks, self.load = None, [0] * 4, [0.0] * 4

    def step(self, feet, rolled, forces, swinging, turned, tilt, walks):
        """Take a tick; ``turned``: (x, y, z) in rad, None without a gyroscope."""
        weights = self.weights(forces, swinging)
        was, self.before = self.before, (feet, rolled)
        if was is None:
            return
        before = [(there[0] - there_rolled[0] + is_rolled[0], there[1] - there_rolled[1] + is_rolled[1])
                  for there, there_rolled, is_rolled in zip(*was, rolled)]
        total = sum(weights)
        if walks and turned is not None:
            by_gyro, turn = True, body_turn(turned, tilt)
        else:
            by_gyro, turn = False, feet_turn(before, feet, weights) if total else self.wz / self.rate_hz
        self.wz += self.share * (turn * self.rate_hz - self.wz)
        shift, slip = (self.vx / self.rate_hz, self.vy / self.rate_hz), 0.0
        if total:
            turn_mean = turn if by_gyro else self.wz / self.rate_hz
            shifts = [shift_of(b, n, turn_mean) for b, n in zip(before, feet)]
            shift = [sum([w * d[axis] for w, d in zip(weights, shifts)]) / total for axis in range(2)]
            slip = sum([w * (abs(d[0] - shift[0]) + abs(d[1] - shift[1])) for w, d in zip(weights, shifts)]) / total
        self.move(shift, turn, slip, walks, by_gyro)

    def weights(self, forces, swinging):
        """Return the squares of what the feet carry before and now; none of those that swing for a while already.

        By the plan alone where the joints tell of less than a quarter of the weight.
        """
        swings = [swinging >> leg & 1 for leg in range(4)]
        whole = self.delay_ticks + 2
        self.stance_ticks = [limit(was + 1 - 2 * each, 0, whole) for was, each in zip(self.stance_ticks, swings)]
        carried = [limit(force, 0.0, 1.0) if stance_ticks or not each else 0.0
                   for force, stance_ticks, each in zip(forces, self.stance_ticks, swings)]
        before, self.load = self.load, carried
        if sum(carried) < 0.25:
            return [float(not swinging >> leg & 1) for leg in range(4)]
        return [min(was, force) ** 2 for was, force in zip(before, carried)]

    def move(self, shift, turn, slip, walks, by_gyro):
        """Move by a shift and a turn, and let the uncertainties grow."""
        if walks:
            self.walked += math.sqrt(shift[0] ** 2 + shift[1] ** 2)
            self.slip += slip
            self.heading_sigma += slip / self.leg_m / (256 if by_gyro else 16)
            if by_gyro:
                self.heading_sigma += BIAS_RAD_S / self.rate_hz
        self.vx += self.share * (shift[0] * self.rate_hz - self.vx)
        self.vy += self.share * (shift[1] * self.rate_hz - self.vy)
        half = self.yaw + turn / 2
        dx = shift[0] * math.cos(half) - shift[1] * math.sin(half)
        dy = shift[0] * math.sin(half) + shift[1] * math.cos(half)
        self.x, self.y, self.yaw = self.x + dx, self.y + dy, self.yaw + turn
        if walks:
            sigma, (x, y) = min(0.5, self.heading_sigma), self.heading_spread
            self.heading_spread = [x - dy * sigma, y + dx * sigma]

    def spread(self):
        """Return the vectors: (scale_spread x, y), place_spread; m."""
        share = limit(1 / 256 + (self.slip / self.walked / 8 if self.walked else 0.0), 0.0, 1.0)
        return (self.x * share, self.y * share), 0.001 + self.walked / 256 + self.slip / 32


def body_turn(turned, tilt):
    """Return the turn of the heading of a body at R = Rx(roll) Ry(pitch) that turns about its own axes."""
    return (turned[2] * math.cos(tilt[1]) - turned[0] * math.sin(tilt[1])) / math.cos(tilt[0])


def feet_turn(before, now, weights):
    """Return the turn of the body that fits feet which stay (planar Procrustes)."""
    turn = heading(now, before, weights)
    return turn if abs(turn) < math.pi / 2 else 0.0


def shift_of(before, now, turn):
    """Return the body's shift over a foot that stays, in axes turned by half of the turn."""
    c, s = math.cos(turn / 2), math.sin(turn / 2)
    bx, by = c * before[0] + s * before[1], c * before[1] - s * before[0]
    nx, ny = c * now[0] - s * now[1], c * now[1] + s * now[0]
    return bx - nx, by - ny
