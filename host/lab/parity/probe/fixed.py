"""shared/num/fixed.py: the primitives, each over its whole stated range."""

from shared.num import fixed
from shared.runtime import zeros

from .draw import INT30, UNIT, Range
from .probe import Block, Probe

ANGLE = Range(-(1 << 30), (1 << 30) - 16385)
SIDE = Range(1 - (1 << 30), (1 << 30) - 1)
SIDES = Block(zeros(4), (4, SIDE))
OTHERS = Block(zeros(4), (4, SIDE))
SQUARES = Block(zeros(4), (4, INT30))
RESULTS = zeros(4)


def _order(values, dice) -> None:
    if values[1] > values[2]:
        values[1], values[2] = values[2], values[1]


def _keep_product(values, dice) -> None:
    a, b = values
    while a * b > 32767 * 32768 or a * b < -32767 * 32768:
        if -32768 < a < 32768:
            b >>= 1
        else:
            a >>= 1
    values[0] = a
    values[1] = b


def _near_enough(values, dice) -> None:
    while abs(values[2] - values[1]) > 32767:
        values[2] //= 2
        values[1] //= 2


PROBES = (
    Probe(fixed, "saturate", (INT30, INT30, INT30), fit=_order),
    Probe(fixed, "mul_q15", (INT30, Range(-32768, 32768)), fit=_keep_product),
    Probe(fixed, "sin_q15", (ANGLE,), vectors=8),
    Probe(fixed, "cos_q15", (ANGLE,), vectors=8),
    Probe(fixed, "atan2_brad18", (SIDE, SIDE), vectors=8),
    Probe(fixed, "round_brad", (Range(4 - (1 << 30), (1 << 30) - 4),)),
    Probe(fixed, "wrap_brad", (Range(-(1 << 29), 1 << 29),)),
    Probe(fixed, "atan2_brad", (SIDE, SIDE), vectors=2),
    Probe(fixed, "isqrt", (INT30,), vectors=8),
    Probe(fixed, "round_sqrt", (INT30,), vectors=2),
    Probe(fixed, "hypot", (Range(1 - (1 << 29), (1 << 29) - 1), Range(1 - (1 << 29), (1 << 29) - 1)), vectors=4),
    Probe(fixed, "ratio", (Range(0, (1 << 30) - 1), Range(1, 1 << 29), Range(0, 30))),
    Probe(fixed, "fall_q15", (UNIT, UNIT, UNIT), fit=_near_enough),
    Probe(fixed, "round_roots", (SQUARES, RESULTS, 4), watch=(RESULTS,), vectors=2),
    Probe(fixed, "arctans_brad18", (SIDES, OTHERS, RESULTS, 4), watch=(RESULTS,), vectors=2),
)
