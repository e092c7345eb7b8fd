"""The sine table of the current step: 1024 entries a turn and one quarter more, for the cosine.

Built once from sin_q15. The step turns an entry (s, c) on by the rest r of the angle, at most 32
brad, with s + c r and c - s r: error r^2 / 2 < 5e-6. Entries are unsigned: sine in Q15 plus 32768,
so that one pointer type reads them.
"""

from array import array

from ..fixed import sin_q15
from ..runtime import const

SINE_BIAS = const(32768)
_SIZE = const(1280)


def _table():
    table = array("H", bytes(2 * _SIZE))
    for i in range(_SIZE):
        table[i] = sin_q15(i << 6) + SINE_BIAS
    return table


SINE = _table()
