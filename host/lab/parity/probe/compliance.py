"""shared/body/compliance.py: any lever, force and angle."""


from shared.body import compliance
from shared.body.feet import Feet
from shared.runtime import zeros

from .draw import Range
from .draws import BRAD, LEG, ROBOT
from .probe import Block, Probe

LEVER = Range(-32767, 32767)
FORCE = Range(-16383, 16383)
ANY_FORCE = Range(-(1 << 30), (1 << 30) - 1)
FOOT = Block(Feet(), (12, LEVER))
JOINTS = Block(zeros(12), (12, BRAD))

PROBES = (
    Probe("torque", compliance.torque, (LEVER, FORCE)),
    Probe("sag", compliance.sag, (Range(-262143, 262143), Range(0, 32767))),
    Probe(
        "sag_leg",
        compliance.sag_leg,
        (ROBOT, LEG, FOOT, ANY_FORCE, ANY_FORCE, ANY_FORCE, JOINTS),
        watch=(JOINTS.array,),
        vectors=2,
    ),
)
