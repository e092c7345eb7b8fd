"""shared/body/pose.py: any pose over feet anywhere near; rotations are always ones the core made."""


from shared.body import pose as body
from shared.body.axes import Pose
from shared.body.feet import Feet
from shared.runtime import zeros

from .draw import Range
from .draws import LEG, ROBOT
from .probe import Block, Probe

UNIT = Range(-32767, 32767)
LENGTH = Range(-(1 << 28), 1 << 28)
POSE = Block(Pose(), (3, LENGTH), (3, Range(-(1 << 30), (1 << 30) - 16385)))
FEET = Block(Feet(), (12, LENGTH))
NEAR_POSE = Block(Pose(), (3, Range(-2000, 2000)), (3, Range(-6000, 6000)))
NEAR_FEET = Block(Feet(), (12, Range(-32767, 32767)))
ROTATION = zeros(9)
HIP_FEET = Feet()


def _rotate(values, dice):
    body.body_rotation(values[2], ROTATION)


PROBES = (
    Probe("mul_unit", body.mul_unit, (UNIT, UNIT)),
    Probe("body_rotation", body.body_rotation, (POSE, ROTATION), watch=(ROTATION,)),
    Probe(
        "body_to_hip",
        body.body_to_hip,
        (ROBOT, LEG, POSE, ROTATION, FEET, HIP_FEET),
        watch=(HIP_FEET,),
        fit=_rotate,
    ),
    Probe(
        "body_to_hip:near",
        body.body_to_hip,
        (ROBOT, LEG, NEAR_POSE, ROTATION, NEAR_FEET, HIP_FEET),
        watch=(HIP_FEET,),
        fit=_rotate,
    ),
)
