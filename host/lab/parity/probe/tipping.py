"""shared/trot/tipping.py: any turns over any diagonal, with what was learnt before."""


from shared.runtime import zeros
from shared.trot import tipping
from shared.trot.tipping import Tipping

from .draw import Range
from .draws import HALF30, LEG, ROBOT
from .probe import Block, Probe

SOURCES = ("trot.tipping",)

SUM = Range(-16383, 16383)
LF = Range(-(1 << 20), 1 << 20)
TIP = Block(Tipping(), (2, SUM), (2, LF), (1, Range(0, 8)))
FEET = Block(zeros(12), (12, Range(-32767, 32767)))

PROBES = (
    Probe("tip_reset", tipping.tip_reset, (TIP, Range(0, 1)), watch=(TIP.array,)),
    Probe("tip_add", tipping.tip_add, (TIP, HALF30, HALF30), watch=(TIP.array,)),
    Probe("tip_learn", tipping.tip_learn, (ROBOT, FEET, LEG, LEG, TIP), watch=(TIP.array,)),
)
