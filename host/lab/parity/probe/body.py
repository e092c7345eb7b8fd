"""shared/body/pose.py: any pose over feet anywhere near; rotations are always ones the core made."""


from shared.body import pose as body
from shared.body.axes import Pose
from shared.body.feet import Feet
from shared.runtime import zeros

from .draw import LEG, UNIT, Range
from .draws import ROBOT
from .probe import Block, Probe

LENGTH = Range(-(1 << 28), 1 << 28)
POSE = Block(Pose(), (3, LENGTH), (3, Range(-(1 << 30), (1 << 30) - 16385)))
FEET = Block(Feet(), (12, LENGTH))
NEAR_POSE = Block(Pose(), (3, Range(-2000, 2000)), (3, Range(-6000, 6000)))
NEAR_FEET = Block(Feet(), (12, UNIT))
ROTATION = zeros(9)
HIP_FEET = Feet()


def _rotate(values, dice):
    body.body_rotation(values[2], ROTATION)


def _to_hip(name, pose, feet):
    return Probe(body, name, (ROBOT, LEG, pose, ROTATION, feet, HIP_FEET), watch=(HIP_FEET,), fit=_rotate)


PROBES = (
    Probe(body, "mul_unit", (UNIT, UNIT)),
    Probe(body, "body_rotation", (POSE, ROTATION), watch=(ROTATION,)),
    _to_hip("body_to_hip", POSE, FEET),
    _to_hip("body_to_hip:near", NEAR_POSE, NEAR_FEET),
)
