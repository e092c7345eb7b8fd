"""shared/num/pid.py: a controller whose gains change now and then, its state carried from vector to vector."""


from shared.num import pid
from shared.num.pid import Pid
from shared.record import unpack

from .draw import Range
from .probe import Probe

FIRST = Pid()
SECOND = Pid()
SIGNAL = Range(-(1 << 20), 1 << 20)
_GAIN = Range(0, 32767)
_LIMIT = Range(0, 16383)
_ONE = Range(0, 1)


def _begin():
    for one in (FIRST, SECOND):
        unpack(one, [0] * 8)


def _retune(values, dice):
    made: Pid = FIRST
    if values[0]:
        made = SECOND
    values[0] = made
    if dice.below(16) == 0:
        made.kp_q12 = _GAIN.any(dice)
        made.ki_q16 = _GAIN.any(dice)
        made.kd_q10 = _GAIN.any(dice)
        made.integral_max = _LIMIT.any(dice)
        made.output_max = _LIMIT.any(dice)
        pid.pid_reset(made)


def _soil(values, dice):
    _retune(values, dice)
    made: Pid = values[0]
    made.integral_q12 = dice.bits(20)
    made.started = 1


PROBES = (
    Probe("pid_reset", pid.pid_reset, (_ONE,), watch=(FIRST, SECOND), begin=_begin, fit=_soil),
    Probe("pid_step", pid.pid_step, (_ONE, SIGNAL, SIGNAL), watch=(FIRST, SECOND), begin=_begin, fit=_retune),
)
