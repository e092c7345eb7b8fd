"""shared/body/legs.py: any joints, and feet in and out of reach."""

from shared.body import legs
from shared.body.feet import Feet
from shared.runtime import zeros

from .draw import Range
from .draws import ROBOT
from .probe import Block, Probe
from .row import clear

ANY_ANGLES = Block(zeros(12), (12, Range(-(1 << 28), 1 << 28)))
ANY_FEET = Block(Feet(), (12, Range(-40000, 40000)))
WORK = legs.LegsWork()
WAVES = zeros(24)
FEET = Feet()
JOINTS = zeros(12)
FEET_LEFT = ANY_FEET.array
SQUARES = WORK.squares
HALF_WORK = (WORK.squares, WORK.drops, WORK.lengths, WORK.roots, WORK.rises, WORK.runs, WORK.turns)


def _begin():
    for block in HALF_WORK:
        clear(block)


def _solved(values, dice):
    """What the first half of the inverse has left."""
    legs.legs_inverse(values[0], ANY_FEET.array, WORK, JOINTS)


PROBES = (
    Probe(legs, "legs_waves", (ANY_ANGLES, WAVES), watch=(WAVES,)),
    Probe(legs, "legs_forward", (ROBOT, ANY_ANGLES, WAVES, FEET), watch=(FEET, WAVES)),
    Probe(legs, "legs_inverse", (ROBOT, ANY_FEET, WORK, JOINTS), watch=(JOINTS, FEET_LEFT), vectors=4),
    Probe(legs, "reach_feet", (ROBOT, ANY_FEET, SQUARES), watch=(FEET_LEFT, SQUARES), begin=_begin),
    Probe(legs, "fill_turns", (ROBOT, ANY_FEET, WORK), watch=(WORK.turns,), fit=_solved, begin=_begin),
    Probe(legs, "finish_turns", (ROBOT, WORK, JOINTS), watch=(JOINTS,), fit=_solved, begin=_begin),
)
