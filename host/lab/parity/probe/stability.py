"""shared/body/stability.py: any feet, standing or not, and any point."""


from shared.body import stability
from shared.body.axes import Spot
from shared.body.feet import Feet
from shared.runtime import zeros

from .draw import Range
from .draws import LEG
from .probe import Block, Probe

PLACE = Range(-32767, 32767)
FEET = Block(Feet(), (12, PLACE))
WEIGHTS = Block(zeros(4), (4, Range(0, 1)))
POINT = Block(Spot(), (2, PLACE))

PROBES = (
    Probe("around", stability.around, (Range(-8, 8),)),
    Probe("next_standing", stability.next_standing, (WEIGHTS, LEG)),
    Probe("edge_margin", stability.edge_margin, (FEET, LEG, LEG, PLACE, PLACE)),
    Probe("support_margin", stability.support_margin, (FEET, WEIGHTS, PLACE, PLACE)),
    Probe("point_inside", stability.point_inside, (FEET, WEIGHTS, Range(0, 32767), POINT), watch=(POINT.array,)),
)
