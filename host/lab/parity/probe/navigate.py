"""shared/trot/navigate.py: any errors, speeds and ways of a tick."""


from shared.gait.steps import SPEED_SIZE
from shared.runtime import zeros
from shared.trot import navigate
from shared.trot.navigate import Navigation

from .draw import Range
from .draws import HALF30, ROBOT
from .probe import Block, Probe

SOURCES = ("trot.navigate",)

LF = Range(-(1 << 22), 1 << 22)
PLACE = Range(-32767, 32767)
NAV = Block(Navigation(), (2, LF), (1, Range(-91750, 91750)))
SPEED = Block(zeros(SPEED_SIZE), (3, Range(-(1 << 19) + 1, (1 << 19) - 1)))
DRIVE = zeros(SPEED_SIZE)
KNOWN = Range(0, 1)

PROBES = (
    Probe("navigate_reset", navigate.navigate_reset, (NAV,), watch=(NAV.array,)),
    Probe(
        "follow_reference", navigate.follow_reference, (ROBOT, SPEED, LF, LF, HALF30, KNOWN, NAV), watch=(NAV.array,)
    ),
    Probe("hold", navigate.hold, (ROBOT, SPEED, PLACE, NAV, DRIVE), watch=(DRIVE,)),
    Probe("drive_as_told", navigate.drive_as_told, (SPEED, DRIVE), watch=(DRIVE,)),
)
