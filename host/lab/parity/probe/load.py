"""shared/body/load.py: any feet, any weights, any centre of mass."""


from shared.body import load
from shared.body.feet import Feet
from shared.body.load import Load
from shared.runtime import zeros

from .draw import FLAG, UNIT, Range
from .probe import Block, Probe

FORCE = Range(0, 16383)
FEET = Block(Feet(), (12, UNIT))
WEIGHTS = Block(zeros(4), (4, Range(0, 256)))
ARM = Range(-1023, 1023)
BLOCK = Block(
    Load(), (4, FORCE), (2, UNIT), (3, Range(0, 8191)), (3, Range(0, 14)), (8, ARM)
)


def _moments(values, dice):
    load.load_moments(FEET.array, WEIGHTS.array, values[2], BLOCK.array)


def _drawn(values, dice):
    FEET.fill(dice)
    WEIGHTS.fill(dice)
    _moments(values, dice)


PROBES = (
    Probe(load, "load_share", (FEET, WEIGHTS, UNIT, UNIT, FORCE, FLAG, BLOCK.array), watch=(BLOCK.array,), vectors=2),
    Probe(load, "load_moments", (FEET, WEIGHTS, FLAG, BLOCK.array), watch=(BLOCK.array,)),
    Probe(load, "load_middle", (FEET, WEIGHTS, BLOCK.array), watch=(BLOCK.array,)),
    Probe(load, "load_slope", (UNIT, UNIT, FLAG, BLOCK.array), watch=(BLOCK.array,), fit=_drawn),
)
