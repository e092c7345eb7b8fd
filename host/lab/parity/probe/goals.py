"""shared/planner/goals.py: any goals and any way to them; sets of readings, near each other and anywhere."""

from shared.planner import goals
from shared.planner.goals import ReadingHistory
from shared.runtime import zeros

from .draw import BRAD, INT30, LEG, Range
from .draws import ROBOT
from .probe import Block, Probe, probe_with
from .row import clear

COUNT = 3
STEP = Range(1, 32767)
WANTED = Block(zeros(12), (12, BRAD))
JOINTS = Block(zeros(12), (12, BRAD))
READINGS = Block(zeros(12), (12, BRAD))
SET = Block(zeros(COUNT), (COUNT, INT30))
BELIEVED = zeros(COUNT)
PAST = ReadingHistory()


def _near_or_not(values, dice):
    """Mostly readings near those believed, so that something is known; sometimes the odd ones of before again."""
    readings, step = values[0], values[2]
    again = dice.bits(2)
    for place in range(COUNT):
        if again == 0:
            readings[place] = PAST.last_odd[place]
        elif dice.bits(3):
            readings[place] = BELIEVED[place] + dice.below(step + 1) - (step >> 1)


def _known(values, dice):
    """Odd readings after some that were sure or odd."""
    _near_or_not(values, dice)
    PAST.state = goals.READ_SURE + dice.bits(1)


def _joints_close(values, dice):
    """Half of the time every joint within its reading's reach, or just beyond."""
    if dice.bits(1):
        for joint in range(12):
            values[2][joint] = values[1][joint] + dice.bits(7) - 64


def _one_leg(values, dice):
    values[3] *= 3


def _begin():
    clear(BELIEVED)
    clear(PAST)


_taking = probe_with(watch=(BELIEVED, PAST), begin=_begin)

PROBES = (
    Probe(goals, "follow_goals", (ROBOT, WANTED, JOINTS), watch=(JOINTS.array,)),
    Probe(goals, "follow_leg", (ROBOT, WANTED, JOINTS, LEG), watch=(JOINTS.array,), fit=_one_leg),
    Probe(goals, "joints_near", (ROBOT, READINGS, JOINTS), fit=_joints_close),
    _taking(goals, "believe", (SET, COUNT, STEP, BELIEVED, PAST), fit=_near_or_not),
    _taking(goals, "believe_repeated", (SET, COUNT, STEP, BELIEVED, PAST), fit=_known),
)
