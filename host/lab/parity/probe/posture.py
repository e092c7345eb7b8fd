"""shared/planner/posture.py: slow moves between any two poses."""


from shared.planner import posture
from shared.planner.posture import Move
from shared.runtime import zeros

from .draw import BRAD, Range
from .draws import ROBOT
from .probe import Block, Probe

JOINTS = Block(zeros(12), (12, BRAD))
GOAL = Block(zeros(12), (12, BRAD))
MOVE = Move()
OUT = zeros(12)
TICKS = Range(1, 1 << 28)


def _under_way(values, dice):
    """Any pair of poses, any length, any tick of it."""
    for joint in range(12):
        MOVE.start[joint] = BRAD.any(dice)
    for joint in range(12):
        MOVE.goal[joint] = BRAD.any(dice)
    MOVE.ticks = TICKS.any(dice)
    MOVE.tick = dice.below(MOVE.ticks)


def _order(values, dice):
    if values[0] > values[1]:
        values[0], values[1] = values[1], values[0]


PROBES = (
    Probe(posture, "posture_start", (ROBOT, MOVE, JOINTS, GOAL), watch=(MOVE,)),
    Probe(posture, "posture_step", (MOVE, OUT), watch=(MOVE, OUT), fit=_under_way),
    Probe(posture, "phase_of", (Range(0, 1 << 28), TICKS), fit=_order),
)
