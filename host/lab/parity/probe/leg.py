"""shared/body/leg.py: kinematics of one leg, on feet brought into reach first as the planner does."""


from shared.body import leg
from shared.body.feet import Feet
from shared.body.reach import reach_foot
from shared.runtime import zeros

from .draw import BRAD, LEG, Range
from .draws import ROBOT
from .probe import Block, Probe
from .row import clear

ANY_ANGLES = Block(zeros(12), (12, Range(-(1 << 28), 1 << 28)))
ANGLES = Block(zeros(12), (12, BRAD))
ANY_FEET = Block(Feet(), (12, Range(-40000, 40000)))
FEET = Feet()
JOINTS = zeros(12)
FLAGS = zeros(4)


def _bring_into_reach(values, dice):
    reach_foot(values[0], values[1], values[2], values[2])


def _begin():
    clear(FLAGS)


PROBES = (
    Probe(leg, "leg_forward", (ROBOT, LEG, ANY_ANGLES, FEET), watch=(FEET,)),
    Probe(leg, "leg_inverse", (ROBOT, LEG, ANY_FEET, JOINTS), watch=(JOINTS,), fit=_bring_into_reach, vectors=4),
    Probe(leg, "plane_length", (ROBOT, LEG, ANY_FEET)),
    Probe(leg, "limit_legs", (ROBOT, ANGLES, FLAGS), watch=(ANGLES.array, FLAGS), begin=_begin),
    Probe(leg, "limit_leg", (ROBOT, LEG, ANGLES), watch=(ANGLES.array,)),
)
