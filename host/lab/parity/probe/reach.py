"""shared/body/reach.py: feet anywhere a 30-bit number can put them."""


from shared.body import reach
from shared.body.feet import Feet
from shared.body.params import Params

from .draw import Range
from .draws import INT30, LEG, ROBOT
from .probe import Block, Probe

ANYWHERE = Block(Feet(), (12, INT30))
NEARBY = Block(Feet(), (12, Range(-40000, 40000)))
WITHIN = Block(Feet(), (12, Range(-18000, 18000)))
CLOSE = Block(Feet(), (12, Range(-15000, 15000)))
REACHED = Feet()
SIDE = Range(-32767, 32767)


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
    Probe("scale_down", reach.scale_down, (SIDE, Range(0, 32767), INT30)),
    Probe("reach_foot", reach.reach_foot, (ROBOT, LEG, ANYWHERE, REACHED), watch=(REACHED,)),
    Probe("reach_foot:near", reach.reach_foot, (ROBOT, LEG, NEARBY, REACHED), watch=(REACHED,)),
    Probe(
        "leave_hip",
        reach.leave_hip,
        (ROBOT, LEG, LEG, WITHIN),
        watch=(WITHIN.array,),
        fit=_one_leg,
    ),
    Probe("leave_centre", reach.leave_centre, (Range(0, 15000), LEG, CLOSE), watch=(CLOSE.array,), fit=_off_centre),
)
