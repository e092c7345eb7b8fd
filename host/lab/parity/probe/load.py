"""shared/body/load.py: any feet, any weights, any centre of mass."""


from shared.body import load
from shared.body.feet import Feet
from shared.body.load import Load
from shared.runtime import zeros

from .draw import Range
from .probe import Block, Probe

PLACE = Range(-32767, 32767)
FORCE = Range(0, 16383)
PLANAR = Range(0, 1)
FEET = Block(Feet(), (12, PLACE))
WEIGHTS = Block(zeros(4), (4, Range(0, 256)))
ARM = Range(-1023, 1023)
BLOCK = Block(
    Load(), (4, FORCE), (2, PLACE), (3, Range(0, 8191)), (3, Range(0, 14)), (8, ARM)
)


def _moments(values, dice):
    load.load_moments(FEET.array, WEIGHTS.array, values[2], BLOCK.array)


def _drawn(values, dice):
    FEET.fill(dice)
    WEIGHTS.fill(dice)
    _moments(values, dice)


PROBES = (
    Probe(
        "load_share",
        load.load_share,
        (FEET, WEIGHTS, PLACE, PLACE, FORCE, PLANAR, BLOCK.array),
        watch=(BLOCK.array,),
        vectors=2,
    ),
    Probe("load_moments", load.load_moments, (FEET, WEIGHTS, PLANAR, BLOCK.array), watch=(BLOCK.array,)),
    Probe("load_middle", load.load_middle, (FEET, WEIGHTS, BLOCK.array), watch=(BLOCK.array,)),
    Probe("load_slope", load.load_slope, (PLACE, PLACE, PLANAR, BLOCK.array), watch=(BLOCK.array,), fit=_drawn),
)
