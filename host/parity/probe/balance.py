"""shared/balance.py: both controllers of each robot, fed noise."""


from shared import balance
from shared.body import POSE_SIZE
from shared.runtime import zeros

from .draw import Range
from .draws import BRAD, ROBOT
from .probe import Block, Probe
from .robots import PARAMS

BLOCK = zeros(balance.BALANCE_SIZE)
POSE = Block(zeros(POSE_SIZE), (POSE_SIZE, BRAD))
TILT = Range(-32768, 32768)


def _begin():
    balance.balance_setup(PARAMS[0], BLOCK)


def _soil(values, dice):
    for at in range(5, balance.BALANCE_SIZE):
        BLOCK[at] = dice.bits(12)


def _other_robot(values, dice):
    if dice.below(50) == 0:
        balance.balance_setup(PARAMS[dice.below(len(PARAMS))], BLOCK)


PROBES = (
    Probe("balance_setup", balance.balance_setup, (ROBOT, BLOCK), watch=(BLOCK,), fit=_soil),
    Probe("balance_gains", balance.balance_gains, (ROBOT, Range(22, 24), BLOCK), watch=(BLOCK,), begin=_begin),
    Probe("balance_reset", balance.balance_reset, (BLOCK,), watch=(BLOCK,), begin=_begin, fit=_soil),
    Probe("balance_release", balance.balance_release, (BLOCK, Range(0, 1000)), watch=(BLOCK,), begin=_begin, fit=_soil),
    Probe(
        "balance_step",
        balance.balance_step,
        (BLOCK, POSE, TILT, TILT),
        watch=(BLOCK,),
        begin=_begin,
        fit=_other_robot,
        vectors=4,
    ),
)
