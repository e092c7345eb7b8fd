"""shared/sense/attitude.py: any int16 readings, half of them near 1 g so that they are believed."""


from shared.record import copy
from shared.runtime import zeros
from shared.sense import attitude
from shared.sense.attitude import Attitude

from .draw import Range
from .probe import Probe
from .robots import ATTITUDES

BLOCK = Attitude()
COUNTS = zeros(6)
INT16 = Range(-32768, 32767)
UNIT = Range(-(1 << 22), 1 << 22)
Q14 = Range(-(1 << 14), 1 << 14)
Q28 = Range(-(1 << 29), 1 << 29)
RATE = Range(-(1 << 15), 1 << 15)


def _settings(source):
    copy(source, BLOCK)


def _begin():
    _settings(ATTITUDES[0])
    BLOCK.align_ticks = 4


def _read(values, dice):
    """A reading: any numbers, or a gentle turn with about 1 g."""
    wild = dice.bits(1)
    for axis in range(6):
        COUNTS[axis] = INT16.any(dice) if wild else dice.bits(11) - 1024
    if not wild:
        COUNTS[3 + dice.below(3)] = BLOCK.one_g * (1 if dice.bits(2) else -1)


def _run(values, dice):
    """Now and then another robot or rate, already aligned or not."""
    if dice.below(40) == 0:
        _settings(ATTITUDES[dice.below(len(ATTITUDES))])
        if dice.bits(1):
            BLOCK.gathered = BLOCK.align_ticks
    _read(values, dice)


def _run_aligning(values, dice):
    """Readings at rest, mostly, so that alignments end."""
    if BLOCK.gathered >= BLOCK.align_ticks:
        _settings(ATTITUDES[dice.below(len(ATTITUDES))])
        BLOCK.align_ticks = 1 + dice.below(8)
    _read(values, dice)
    if dice.bits(3):
        for axis in range(6):
            COUNTS[axis] = dice.bits(9) - 256
        COUNTS[5] += BLOCK.one_g


def _any_gravity(values, dice):
    _settings(ATTITUDES[dice.below(len(ATTITUDES))])
    BLOCK.gathered = BLOCK.align_ticks
    for axis in range(3):
        BLOCK.gravity[axis] = UNIT.any(dice)
        BLOCK.still = dice.below(BLOCK.align_ticks + 1)
        BLOCK.bias[axis] = dice.bits(30) - (1 << 29)
    _read(values, dice)
    if dice.bits(1):
        for axis in range(6):
            BLOCK.steady[axis] = COUNTS[axis]


def _of_a_vector(values, dice):
    """Two components of a vector of about unit length: not both are 1."""
    if abs(values[0]) + abs(values[1]) > 3 << 21:
        values[1] >>= 1


def _bias(values, dice):
    _any_gravity(values, dice)


def _moving(name, function, given=()):
    """The probe of a function of the filter whose gravity and bias are anything; ``given``: its other arguments."""
    return Probe(name, function, (BLOCK,) + given, watch=(BLOCK,), begin=_begin, fit=_any_gravity)


PROBES = (
    Probe("attitude_reset", attitude.attitude_reset, (BLOCK,), watch=(BLOCK,), begin=_begin, fit=_any_gravity),
    Probe("attitude_step", attitude.attitude_step, (BLOCK, COUNTS), watch=(BLOCK,), begin=_begin, fit=_run, vectors=4),
    Probe("align", attitude.align, (BLOCK, COUNTS), watch=(BLOCK,), begin=_begin, fit=_run_aligning),
    Probe("size_of", attitude.size_of, (INT16, INT16, INT16)),
    Probe("believed", attitude.believed, (BLOCK, Range(0, 56756)), begin=_begin),
    Probe("rate_q18", attitude.rate_q18, (BLOCK, INT16, Range(0, 2)), begin=_begin, fit=_bias),
    _moving("turn", attitude.turn, (COUNTS,)),
    Probe("cross", attitude.cross, (UNIT, UNIT, RATE, RATE), fit=_of_a_vector),
    _moving("pull", attitude.pull, (COUNTS,)),
    _moving("rests", attitude.rests, (COUNTS,)),
    _moving("pull_axis", attitude.pull_axis, (Range(0, 2), Q14, Range(0, 32767))),
    _moving("learn_bias", attitude.learn_bias, (Q14, Q14, Q14)),
    _moving("learn_axis", attitude.learn_axis, (Range(0, 2), Q28)),
    _moving("set_bias", attitude.set_bias, (Range(0, 2), Q28)),
    _moving("normalise", attitude.normalise),
    _moving("angles", attitude.angles),
)
