"""What the crawl carries and how it begins, in floats (m, rad, ticks; forces as parts of the own weight)."""

from . import crawl, load
from .fixed import limit

OWN, LEAST, MOST, EMPTY = 1.0, 0.7, 2.5, 1.15


class Carried:
    """The feet's smoothed forces and the weight learnt from them; gains are parts of the gap per tick."""

    def __init__(self, weight, force_gain, weight_gain):
        self.forces, self.learnt = [0.0] * 4, weight
        self.force_gain, self.weight_gain = force_gain, weight_gain

    def step(self, felt, stands):
        """Take one tick of forces; return (weight, heavy): heavy is 0 empty, 1 from 0.65 of the own weight on."""
        self.forces = [f + self.force_gain * (now - f) for f, now in zip(self.forces, felt)]
        total = limit(sum([f for f, down in zip(self.forces, stands) if down]), 0.0, 4.0)
        self.learnt += self.weight_gain * (total - self.learnt)
        weight = limit(self.learnt, LEAST, MOST)
        return weight, limit(2 * (max(OWN, weight) - EMPTY), 0.0, 1.0)


def start(level_feet, felt, pitch, roll):
    """Return (feet, body pose, weight) at the start: the map is level with the feet's mean, under the body."""
    ground = crawl.middle(level_feet)[2]
    feet = [[x, y, z - ground] for x, y, z in level_feet]
    return feet, [0.0, 0.0, -ground, roll, pitch, 0.0], limit(sum(felt), LEAST, MOST)


def planned_loads(feet, shares, pose, com, weight):
    """Return (loads, margin) under a pose: the feet that stand share the weight by their shares, about the mass."""
    ahead = crawl.com_ahead(com, pose[4])
    seen = [[foot[axis] - pose[axis] for axis in range(2)] for foot in feet]
    parts = load.shares(seen, shares, (ahead, 0.0))
    corners = [seen[leg] for leg in (0, 1, 3, 2) if shares[leg]]
    return [weight * part for part in parts], load.margin(corners, (ahead, 0.0))


def goals(feet, stands, swing_at, wanted, low, commanded, diagonal_offset, legs):
    """Return the legs' angles: those that stand under the commanded pose, the one in the air under the wanted.

    ``low``: what the measured pose was off the wanted one of late. ``diagonal_offset``: FR and RL up, FL and RR down.
    """
    angles = []
    for leg, shape in enumerate(legs):
        foot, pose = list(feet[leg]), commanded
        if stands[leg]:
            foot[2] += diagonal_offset if leg in (0, 3) else -diagonal_offset
        else:
            foot, pose = swing_at, [a + b for a, b in zip(wanted, low)]
        angles.append(crawl.leg_joints(foot, pose, shape))
    return angles
