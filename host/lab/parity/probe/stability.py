"""shared/body/stability.py: any feet, standing or not, and any point."""


from shared.body import stability
from shared.body.axes import Spot
from shared.body.feet import Feet
from shared.runtime import zeros

from .draw import FLAG, LEG, SHARE, UNIT, Range
from .probe import Block, Probe

FEET = Block(Feet(), (12, UNIT))
WEIGHTS = Block(zeros(4), (4, FLAG))
POINT = Block(Spot(), (2, UNIT))

PROBES = (
    Probe(stability, "around", (Range(-8, 8),)),
    Probe(stability, "next_standing", (WEIGHTS, LEG)),
    Probe(stability, "edge_margin", (FEET, LEG, LEG, UNIT, UNIT)),
    Probe(stability, "support_margin", (FEET, WEIGHTS, UNIT, UNIT)),
    Probe(stability, "point_inside", (FEET, WEIGHTS, SHARE, POINT), watch=(POINT.array,)),
)
