"""shared/sense/legs.py: any joints and attitude after any goals; some of the blocks are of ticks that went before."""


from shared.body.feet import Feet
from shared.body.legs import legs_forward
from shared.runtime import zeros
from shared.sense import legs as sensing
from shared.sense.legs import MeasuredFeet, Sensing

from .draw import BRAD, SHARE, Range
from .draws import ROBOT
from .probe import Block, Probe, probe_with
from .robots import PARAMS
from .row import Row

ANGLES = Block(zeros(12), (12, BRAD))
GOALS = Block(zeros(12), (12, BRAD))
FEET = MeasuredFeet()
BLOCK = Sensing()
ROW = Row(BLOCK)
ANGLE18 = Range(-131072, 131071)
PLACES = Block(Feet(), (12, Range(-65534, 65534)))


def _some_ticks(values, dice):
    """Keep goals near the joints to come now and then, so that some errors are small."""
    for _ in range(1 + dice.below(2)):
        for joint in range(12):
            GOALS.array[joint] = BRAD.any(dice) if dice.bits(2) == 0 else ANGLES.array[joint] + dice.bits(8) - 128
        sensing.keep_sent(BLOCK, GOALS.array)


def _forward(values, dice):
    """The same with the feet of these joints."""
    _some_ticks(values, dice)
    legs_forward(values[0], ANGLES.array, FEET.waves, FEET.now)


def _begin():
    sensing.sensing_reset(BLOCK)
    BLOCK.known = 90
    sensing.sense_legs(PARAMS[0], ANGLES.array, 2000, -1000, FEET, BLOCK)  # what is the same for all legs


def _soil(values, dice):
    ROW[dice.below(len(ROW))] = 7


_probe = probe_with(watch=(BLOCK,), begin=_begin)

PROBES = (
    _probe(sensing, "sensing_reset", (BLOCK,), begin=None, fit=_soil),
    _probe(sensing, "keep_sent", (BLOCK, GOALS)),
    _probe(sensing, "sense_legs", (ROBOT, ANGLES, BRAD, BRAD, FEET, BLOCK), fit=_some_ticks, vectors=2),
    _probe(sensing, "foot_forces", (ROBOT, ANGLES, FEET.waves, BLOCK), fit=_forward),
    Probe(sensing, "joint_torque", (SHARE, SHARE, ANGLE18, ANGLE18)),
    _probe(sensing, "level_feet", (ANGLES, PLACES, BLOCK)),
)
