"""shared/sense/attitude.py: any int16 readings, half of them near 1 g so that they are believed."""


from shared.record import copy
from shared.runtime import zeros
from shared.sense import attitude
from shared.sense.attitude import Attitude

from .draw import INT16, SHARE, Range
from .probe import Probe, probe_with
from .robots import ATTITUDES

BLOCK = Attitude()
COUNTS = zeros(6)
Q22 = Range(-(1 << 22), 1 << 22)
Q14 = Range(-(1 << 14), 1 << 14)
Q28 = Range(-(1 << 29), 1 << 29)
RATE = Range(-(1 << 15), 1 << 15)


def _settings(dice):
    copy(dice.choose(ATTITUDES), BLOCK)


def _begin():
    copy(ATTITUDES[0], BLOCK)
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
        _settings(dice)
        if dice.bits(1):
            BLOCK.gathered = BLOCK.align_ticks
    _read(values, dice)


def _run_aligning(values, dice):
    """Readings at rest, mostly, so that alignments end."""
    if BLOCK.gathered >= BLOCK.align_ticks:
        _settings(dice)
        BLOCK.align_ticks = 1 + dice.below(8)
    _read(values, dice)
    if dice.bits(3):
        for axis in range(6):
            COUNTS[axis] = dice.bits(9) - 256
        COUNTS[5] += BLOCK.one_g


def _any_gravity(values, dice):
    _settings(dice)
    BLOCK.gathered = BLOCK.align_ticks
    for axis in range(3):
        BLOCK.gravity[axis] = Q22.any(dice)
        BLOCK.rest_ticks = dice.below(BLOCK.align_ticks + 1)
        BLOCK.bias[axis] = dice.bits(30) - (1 << 29)
    _read(values, dice)
    if dice.bits(1):
        for axis in range(6):
            BLOCK.rest_reading[axis] = COUNTS[axis]


def _of_a_vector(values, dice):
    """Two components of a vector of about unit length: not both are 1."""
    if abs(values[0]) + abs(values[1]) > 3 << 21:
        values[1] >>= 1


_probe = probe_with(watch=(BLOCK,), begin=_begin, fit=_any_gravity)

PROBES = (
    _probe(attitude, "attitude_reset", (BLOCK,)),
    _probe(attitude, "attitude_step", (BLOCK, COUNTS), fit=_run, vectors=4),
    _probe(attitude, "align", (BLOCK, COUNTS), fit=_run_aligning),
    Probe(attitude, "size_of", (INT16, INT16, INT16)),
    Probe(attitude, "near_one_g", (BLOCK, Range(0, 56756)), begin=_begin),
    _probe(attitude, "rate_q18", (BLOCK, INT16, Range(0, 2)), watch=()),
    _probe(attitude, "turn", (BLOCK, COUNTS)),
    Probe(attitude, "cross", (Q22, Q22, RATE, RATE), fit=_of_a_vector),
    _probe(attitude, "pull", (BLOCK, COUNTS)),
    _probe(attitude, "count_rest", (BLOCK, COUNTS)),
    _probe(attitude, "pull_axis", (BLOCK, Range(0, 2), Q14, SHARE)),
    _probe(attitude, "learn_bias", (BLOCK, Q14, Q14, Q14)),
    _probe(attitude, "learn_axis", (BLOCK, Range(0, 2), Q28)),
    _probe(attitude, "set_bias", (BLOCK, Range(0, 2), Q28)),
    _probe(attitude, "normalise", (BLOCK,)),
    _probe(attitude, "angles", (BLOCK,)),
)
