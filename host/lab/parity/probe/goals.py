"""shared/planner/goals.py: any goals and any way to them; sets of readings, near each other and anywhere."""

from shared.planner import goals
from shared.planner.goals import Past
from shared.runtime import zeros

from .draw import Range
from .draws import BRAD, INT30, ROBOT
from .probe import Block, Probe
from .row import Row

COUNT = 3
STEP = Range(1, 32767)
WANTED = Block(zeros(12), (12, BRAD))
JOINTS = Block(zeros(12), (12, BRAD))
READINGS = Block(zeros(12), (12, BRAD))
SET = Block(zeros(COUNT), (COUNT, INT30))
BELIEVED = zeros(COUNT)
PAST = Past()
ROW = Row(BELIEVED, PAST)


def _near_or_not(values, dice):
    """Mostly readings near those believed, so that something is known; sometimes the odd ones of before again."""
    readings, step = values[0], values[2]
    again = dice.bits(2)
    for place in range(COUNT):
        if again == 0:
            readings[place] = PAST.odd[place]
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
    for at in range(len(ROW)):
        ROW[at] = 0


TAKING = (SET, COUNT, STEP, BELIEVED, PAST)
PROBES = (
    Probe("follow_goals", goals.follow_goals, (ROBOT, WANTED, JOINTS), watch=(JOINTS.array,)),
    Probe("follow_leg", goals.follow_leg, (ROBOT, WANTED, JOINTS, Range(0, 3)), watch=(JOINTS.array,), fit=_one_leg),
    Probe("joints_near", goals.joints_near, (ROBOT, READINGS, JOINTS), fit=_joints_close),
    Probe("believe", goals.believe, TAKING, watch=(BELIEVED, PAST), fit=_near_or_not, begin=_begin),
    Probe("believe_again", goals.believe_again, TAKING, watch=(BELIEVED, PAST), fit=_known, begin=_begin),
)
