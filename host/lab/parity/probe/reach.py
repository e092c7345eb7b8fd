"""shared/body/reach.py: feet anywhere a 30-bit number can put them."""


from shared.body import reach
from shared.body.feet import Feet
from shared.body.params import Params

from .draw import INT30, LEG, SHARE, UNIT, Range
from .draws import ROBOT
from .probe import Block, Probe

ANYWHERE = Block(Feet(), (12, INT30))
NEARBY = Block(Feet(), (12, Range(-40000, 40000)))
WITHIN = Block(Feet(), (12, Range(-18000, 18000)))
CLOSE = Block(Feet(), (12, Range(-15000, 15000)))
REACHED = Feet()


def _one_leg(values, dice):
    """leg and radius belong to one leg of one robot."""
    params: Params = values[0]
    values[2] = abs(params.legs[values[1]].hip_length)


def _off_centre(values, dice):
    feet: Feet = values[2]
    foot = feet.legs[values[1]]
    if foot.x == 0 and foot.y == 0 and foot.z == 0:
        foot.x = 1


PROBES = (
    Probe(reach, "scale_down", (UNIT, SHARE, INT30)),
    Probe(reach, "reach_foot", (ROBOT, LEG, ANYWHERE, REACHED), watch=(REACHED,)),
    Probe(reach, "reach_foot:near", (ROBOT, LEG, NEARBY, REACHED), watch=(REACHED,)),
    Probe(reach, "leave_hip", (ROBOT, LEG, LEG, WITHIN), watch=(WITHIN.array,), fit=_one_leg),
    Probe(reach, "leave_centre", (Range(0, 15000), LEG, CLOSE), watch=(CLOSE.array,), fit=_off_centre),
)
