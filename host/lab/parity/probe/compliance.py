"""shared/body/compliance.py: any lever, force and angle."""


from shared.body import compliance
from shared.body.feet import Feet
from shared.runtime import zeros

from .draw import BRAD, FORCE, INT30, LEG, SHARE, UNIT, Range
from .draws import ROBOT
from .probe import Block, Probe

FOOT = Block(Feet(), (12, UNIT))
JOINTS = Block(zeros(12), (12, BRAD))

PROBES = (
    Probe(compliance, "torque", (UNIT, FORCE)),
    Probe(compliance, "sag", (Range(-262143, 262143), SHARE)),
    Probe(compliance, "sag_leg", (ROBOT, LEG, FOOT, INT30, INT30, INT30, JOINTS), watch=(JOINTS.array,), vectors=2),
)
