"""shared/trot/ground.py: any feet as measured, any tilt and lag."""


from shared.gait.steps import Steps
from shared.sense.legs import Sensing
from shared.trot import ground

from .draw import Range
from .draws import BRAD, ROBOT
from .probe import Block, Probe

SOURCES = ("trot.ground",)

LF = Range(-(1 << 22), 1 << 22)
LENGTH = Range(-65535, 65535)
SENSING = Block(Sensing(), (12, LENGTH))
STEPS = Block(Steps(), *([(2, LF), (1, LENGTH), (5, Range(0, 1000))] * 4))

PROBES = (
    Probe("twist", ground.twist, (SENSING, BRAD, BRAD)),
    Probe("follow_twist", ground.follow_twist, (ROBOT, LF, Range(-(1 << 20), 1 << 20))),
    Probe("press_feet", ground.press_feet, (ROBOT, STEPS, LENGTH), watch=(STEPS.array,)),
    Probe("roughness", ground.roughness, (ROBOT, Range(0, 1 << 19), BRAD, BRAD)),
    Probe("extra_lift", ground.extra_lift, (ROBOT, Range(0, 1 << 19), LF, Range(-(1 << 19) + 1, (1 << 19) - 1))),
)
