"""shared/trot/sway.py: any feet, any centre of mass."""


from shared.runtime import zeros
from shared.trot import sway

from .draw import Range
from .draws import LEG, ROBOT
from .probe import Block, Probe

SOURCES = ("trot.sway",)

PLACE = Range(-32767, 32767)
FAR = Range(-65535, 65535)
FEET = Block(zeros(12), (12, PLACE))

PROBES = (
    Probe("smooth_q12", sway.smooth_q12, (Range(-100, 262143), Range(0, 262143))),
    Probe("diagonal_y", sway.diagonal_y, (FEET, LEG, LEG, PLACE, PLACE)),
    Probe("next_sway", sway.next_sway, (ROBOT, PLACE, FAR, FAR)),
)
