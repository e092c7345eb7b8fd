"""The attitude filter in floats: up turned by the gyro exactly, pulled by the accelerometer while that is near 1 g.

What goes on being pulled back is the gyro's bias (Mahony, Hamel, Pflimlin 2008, eq 48). At rest the gyro tells it.
"""

import math

from .fixed import length, limit

ALIGNING, ACCEL_REJECTED, MOVED_WHILE_ALIGNING = 1, 2, 4
RATE_MAX_RAD = 0.125  # a tick
MISSED_MAX_RAD = 1 / 16
BIAS_MAX = 8192  # counts
AT_REST = 8
OFF_MAX = 256 - 1 / 64  # counts


class Attitude:
    """``gyro_rad``: rad per count and tick; ``trust``: share of the accelerometer's correction a tick.

    ``learn``: counts of bias per rad corrected and tick; ``rest_change``: counts by which readings differ at rest.
    """

    def __init__(self, gyro_rad, one_g, trust, learn, tolerance, rest_change, align_ticks, still_counts=1310):
        self.gyro_rad, self.one_g, self.trust, self.learn = gyro_rad, one_g, trust, learn
        self.tolerance, self.rest_change = tolerance, rest_change
        self.align_ticks, self.still_counts = align_ticks, still_counts
        self.rest_reading = (0,) * 6
        self.reset()

    def reset(self):
        """Begin with the alignment at rest."""
        self.readings = []
        self.rest_ticks = 0
        self.bias = (0.0, 0.0, 0.0)
        self.up = (0.0, 0.0, 1.0)

    def step(self, gyro, accel):
        """Take one reading of counts; returns the flags."""
        if len(self.readings) < self.align_ticks:
            return self.align(gyro, accel)
        rates = [limit(self.gyro_rad * (c - b), -RATE_MAX_RAD, RATE_MAX_RAD) for c, b in zip(gyro, self.bias)]
        self.up = turned_back(self.up, rates)
        size = length(*accel)
        flags = 0
        if self.near_one_g(size):
            seen, trust = [a / size for a in accel], self.trust
            if self.count_rest(list(gyro) + list(accel)) >= self.align_ticks:
                trust = min(1.0, trust * AT_REST)
                off = [limit(c - b, -OFF_MAX, OFF_MAX) for c, b in zip(gyro, self.bias)]
                self.bias = [b + trust * o for b, o in zip(self.bias, off)]
            else:
                missed = [limit(m, -MISSED_MAX_RAD, MISSED_MAX_RAD) for m in cross(seen, self.up)]
                self.bias = [limit(b - self.learn * m, -BIAS_MAX, BIAS_MAX) for b, m in zip(self.bias, missed)]
            self.up = [u + trust * (a - u) for u, a in zip(self.up, seen)]
        else:
            flags, self.rest_ticks = ACCEL_REJECTED, 0
        self.up = unit(self.up)
        return flags

    def count_rest(self, reading):
        """Return for how many ticks the readings have stayed as they are."""
        self.rest_ticks += 1
        if any(abs(c - s) > self.rest_change[at // 3] for at, (c, s) in enumerate(zip(reading, self.rest_reading))):
            self.rest_ticks = 0
        if self.rest_ticks == 0:
            self.rest_reading = tuple(reading)
        return self.rest_ticks

    def near_one_g(self, size):
        """Return True if an accelerometer reading of this length is near enough to 1 g."""
        return size >= 1 and abs(size - self.one_g) <= self.tolerance

    def align(self, gyro, accel):
        """Gather one reading at rest; the last sets attitude and bias."""
        moved = self.count_rest(list(gyro) + list(accel)) < len(self.readings)
        if moved or max([abs(c) for c in gyro]) > self.still_counts:
            self.reset()
            return ALIGNING | MOVED_WHILE_ALIGNING
        self.readings.append((gyro, accel))
        if len(self.readings) < self.align_ticks:
            return ALIGNING
        self.bias = [sum([one[0][i] for one in self.readings]) / self.align_ticks for i in range(3)]
        mean = [sum([one[1][i] for one in self.readings]) / self.align_ticks for i in range(3)]
        if not self.near_one_g(length(*mean)):
            self.reset()
            return ALIGNING | ACCEL_REJECTED
        self.up = unit(mean)
        return ALIGNING

    def angles(self):
        """Return roll and pitch in rad."""
        x, y, z = self.up
        return math.atan2(y, length(x, z)), math.atan2(-x, z)


def of_block(block):
    """Return the filter with the settings of a block of the core's (shared/sense/attitude.py)."""
    return Attitude(
        block.gyro_q30 / 2.0**30, block.one_g, block.trust_q15 / 2.0**15, block.learn_q12 / 2.0**14,
        block.tolerance, list(block.rest_change), block.align_ticks,
    )


def unit(vector):
    """Return the vector at length 1."""
    size = length(*vector)
    return [part / size for part in vector]


def turned_back(vector, turn):
    """Return a fixed vector as seen from a body that has turned by ``turn`` rad about an axis (Rodrigues)."""
    angle = length(*turn)
    if angle == 0:
        return list(vector)
    axis = [part / angle for part in turn]
    along = sum([a * v for a, v in zip(axis, vector)])
    c, s = math.cos(angle), math.sin(angle)
    across = cross(vector, axis)
    return [v * c + k * s + a * along * (1 - c) for v, k, a in zip(vector, across, axis)]


def cross(a, b):
    """Return the cross product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
