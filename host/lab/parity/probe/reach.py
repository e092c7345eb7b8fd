"""shared/body/reach.py: feet anywhere a 30-bit number can put them."""


from shared.body import reach
from shared.body.params import Params
from shared.runtime import zeros

from .draw import Range
from .draws import INT30, LEG, ROBOT
from .probe import Block, Probe

ANYWHERE = Block(zeros(12), (12, INT30))
NEARBY = Block(zeros(12), (12, Range(-40000, 40000)))
WITHIN = Block(zeros(12), (12, Range(-18000, 18000)))
CLOSE = Block(zeros(12), (12, Range(-15000, 15000)))
REACHED = zeros(12)
SIDE = Range(-32767, 32767)


def _one_leg(values, dice):
    """leg, radius and at belong to one leg of one robot."""
    one = values[4]
    params: Params = values[0]
    values[1] = one
    values[2] = abs(params.legs[one].hip_length)
    values[4] = one * 3


def _off_centre(values, dice):
    foot, at = values[1], values[2] * 3
    values[2] = at
    if foot[at] == 0 and foot[at + 1] == 0 and foot[at + 2] == 0:
        foot[at] = 1


PROBES = (
    Probe("scale_down", reach.scale_down, (SIDE, Range(0, 32767), INT30)),
    Probe("reach_foot", reach.reach_foot, (ROBOT, LEG, ANYWHERE, REACHED), watch=(REACHED,)),
    Probe("reach_foot:near", reach.reach_foot, (ROBOT, LEG, NEARBY, REACHED), watch=(REACHED,)),
    Probe(
        "leave_hip",
        reach.leave_hip,
        (ROBOT, LEG, LEG, WITHIN, LEG),
        watch=(WITHIN.array,),
        fit=_one_leg,
    ),
    Probe("leave_centre", reach.leave_centre, (Range(0, 15000), CLOSE, LEG), watch=(CLOSE.array,), fit=_off_centre),
)
