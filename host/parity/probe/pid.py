"""shared/pid.py: a controller whose gains change now and then, its state carried from vector to vector."""


from shared import pid
from shared.runtime import zeros

from .draw import Range
from .probe import Probe

BLOCK = zeros(2 * pid.PID_SIZE)
BASE = Range(0, 1)
SIGNAL = Range(-(1 << 20), 1 << 20)
_GAIN = Range(0, 32767)
_LIMIT = Range(0, 16383)


def _begin():
    for at in range(len(BLOCK)):
        BLOCK[at] = 0


def _retune(values, dice):
    base = values[1] * pid.PID_SIZE
    values[1] = base
    if dice.below(16) == 0:
        for at in range(pid.PID_INTEGRAL_MAX):
            BLOCK[base + at] = _GAIN.any(dice)
        BLOCK[base + pid.PID_INTEGRAL_MAX] = _LIMIT.any(dice)
        BLOCK[base + pid.PID_OUTPUT_MAX] = _LIMIT.any(dice)
        pid.pid_reset(BLOCK, base)


def _soil(values, dice):
    _retune(values, dice)
    BLOCK[values[1] + pid.PID_INTEGRAL_Q12] = dice.bits(20)
    BLOCK[values[1] + pid.PID_STARTED] = 1


PROBES = (
    Probe("pid_reset", pid.pid_reset, (BLOCK, BASE), watch=(BLOCK,), begin=_begin, fit=_soil),
    Probe(
        "pid_step",
        pid.pid_step,
        (BLOCK, BASE, SIGNAL, SIGNAL),
        watch=(BLOCK,),
        begin=_begin,
        fit=_retune,
    ),
)
