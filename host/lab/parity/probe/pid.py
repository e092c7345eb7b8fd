"""shared/num/pid.py: a controller whose gains change now and then, its state carried from vector to vector."""


from shared.num import pid
from shared.num.pid import Pid

from .draw import FLAG, SHARE, Range
from .probe import probe_with
from .row import clear

FIRST = Pid()
SECOND = Pid()
SIGNAL = Range(-(1 << 20), 1 << 20)
_LIMIT = Range(0, 16383)


def _begin():
    clear(FIRST)
    clear(SECOND)


def _retune(values, dice):
    made: Pid = (FIRST, SECOND)[values[0]]
    values[0] = made
    if dice.below(16) == 0:
        made.kp_q12 = SHARE.any(dice)
        made.ki_q16 = SHARE.any(dice)
        made.kd_q10 = SHARE.any(dice)
        made.integral_max = _LIMIT.any(dice)
        made.output_max = _LIMIT.any(dice)
        pid.pid_reset(made)


def _soil(values, dice):
    _retune(values, dice)
    made: Pid = values[0]
    made.integral_q12 = dice.bits(20)
    made.started = 1


_probe = probe_with(watch=(FIRST, SECOND), begin=_begin)

PROBES = (
    _probe(pid, "pid_reset", (FLAG,), fit=_soil),
    _probe(pid, "pid_step", (FLAG, SIGNAL, SIGNAL), fit=_retune),
)
