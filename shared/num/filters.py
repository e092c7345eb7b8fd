"""Smoothing in integers: a share of a value that may be large, and a quintic for smooth moves.

The quintic u^3 (10 - 15 u + 6 u^2) has no speed and no acceleration at either end (Flash and Hogan's minimum jerk).
"""

from ..runtime import const, hot

_ONE_Q15 = const(32768)


@hot
def fraction(value: int, share_q15: int) -> int:
    """Return value * share / 2^15 for a share of 0 .. 32768 (1).

    Range: value within +-(2^25 - 1). Error at most 1 unit of ``value``. The value's lower ten bits are taken
    apart: the largest intermediate is 2^15 * 2^15 - 1 in size.
    """
    return (value >> 10) * share_q15 + ((value & 1023) * share_q15 >> 10) + 16 >> 5


@hot
def quintic_q15(tick: int, ticks: int) -> int:
    """Return the share of a smooth move made at ``tick`` of ``ticks``, 0 .. 32768 in Q15.

    Range: any; before the start 0, from the end on 32768. Error at most 64 LSB (0.002), ends exact.
    Largest intermediate 32768 * 15360 < 2^29.
    """
    if tick >= ticks:
        return _ONE_Q15
    if tick <= 0:
        return 0
    while ticks > 16383:
        ticks >>= 1
        tick >>= 1
    u = (tick << 15) // ticks
    cube = (u * u >> 15) * u >> 15
    inner_q10 = 10240 - (u * (15 * _ONE_Q15 - 6 * u >> 5) >> 15)
    return cube * inner_q10 >> 10
