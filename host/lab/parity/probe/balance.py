"""shared/body/balance.py: both controllers of each robot, fed noise."""


from shared.body import balance
from shared.body.axes import POSE_AXES, Pose
from shared.body.balance import Balance
from shared.num.pid import Pid

from .draw import Range
from .draws import BRAD, ROBOT
from .probe import Block, Probe
from .robots import PARAMS

BALANCE = Balance()
STATE = (BALANCE.roll, BALANCE.pitch, BALANCE.correction)
POSE = Block(Pose(), (POSE_AXES, BRAD))
TILT = Range(-32768, 32768)


def _begin():
    balance.balance_setup(PARAMS[0], BALANCE)


def _soil_pid(pid: Pid, dice):
    pid.integral_q12 = dice.bits(12)
    pid.previous = dice.bits(12)
    pid.started = dice.bits(12)


def _soil(values, dice):
    _soil_pid(BALANCE.roll, dice)
    _soil_pid(BALANCE.pitch, dice)
    BALANCE.correction.roll = dice.bits(12)
    BALANCE.correction.pitch = dice.bits(12)


def _other_robot(values, dice):
    if dice.below(50) == 0:
        balance.balance_setup(PARAMS[dice.below(len(PARAMS))], BALANCE)


def _robot(values, dice):
    _soil(values, dice)
    values[1] = BALANCE.roll


PROBES = (
    Probe("setup_pid", balance.setup_pid, (ROBOT, 0), watch=STATE, begin=_begin, fit=_robot),
    Probe("balance_setup", balance.balance_setup, (ROBOT, BALANCE), watch=STATE, fit=_soil),
    Probe("balance_reset", balance.balance_reset, (BALANCE,), watch=STATE, begin=_begin, fit=_soil),
    Probe("balance_release", balance.balance_release, (BALANCE, Range(0, 1000)), watch=STATE, begin=_begin, fit=_soil),
    Probe(
        "balance_step",
        balance.balance_step,
        (BALANCE, POSE, TILT, TILT),
        watch=STATE,
        begin=_begin,
        fit=_other_robot,
        vectors=4,
    ),
)
