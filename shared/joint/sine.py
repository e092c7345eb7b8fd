"""The sine table of the current step: 1024 entries a turn and one quarter more, for the cosine.

Made from sin_q15 when a joint starts. The step turns an entry (s, c) on by the rest r of the angle, at most 32
brad, with s + c r and c - s r: error r^2 / 2 < 5e-6. It lies behind the places of ``loop``, because each further
array handed to a viper function costs it some 110 instructions a call.
"""

from ..num.fixed import sin_q15
from ..runtime import const, hot
from .layout import SINE_SIZE, CurrentLoop

TABLE_HALF_STEP = const(32)  # brad, added to an angle so that its nearest entry is taken
_STEP_SHIFT = const(6)  # brad between entries: 64


@hot
def fill_sine(loop: CurrentLoop) -> int:
    """Write the table, in Q15, to ``loop``; return 0. Error 1 of Q15, from sin_q15."""
    for at in range(SINE_SIZE):
        loop.sine[at] = sin_q15(at << _STEP_SHIFT)
    return 0
