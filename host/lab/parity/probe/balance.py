"""shared/body/balance.py: both controllers of each robot, fed noise."""


from shared.body import balance
from shared.body.axes import POSE_AXES, Pose
from shared.body.balance import Balance
from shared.num.pid import Pid

from .draw import BRAD, Range
from .draws import ROBOT
from .probe import Block, probe_with
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
        balance.balance_setup(ROBOT.any(dice), BALANCE)


def _robot(values, dice):
    _soil(values, dice)
    values[1] = BALANCE.roll


_probe = probe_with(watch=STATE, begin=_begin, fit=_soil)

PROBES = (
    _probe(balance, "setup_pid", (ROBOT, 0), fit=_robot),
    _probe(balance, "balance_setup", (ROBOT, BALANCE), begin=None),
    _probe(balance, "balance_reset", (BALANCE,)),
    _probe(balance, "balance_release", (BALANCE, Range(0, 1000))),
    _probe(balance, "balance_step", (BALANCE, POSE, TILT, TILT), fit=_other_robot, vectors=4),
)
