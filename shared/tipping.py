"""Learns where the centre of mass is from how the robot tips about its diagonal while two feet carry it.

A robot that tips forward during a swing has its centre of mass in front of the support line. A
small part of what it tipped moves the belief; two diagonals tell x and y. Payload and a wrong
robot file are found within some steps.
"""

from .fixed import hypot, saturate
from .params import LF_BITS, Params
from .runtime import Ints, const, hot

TIP_ROLL = const(0)  # 2^-18 rad, turned since the swing began, about x
TIP_PITCH = const(1)
TIP_COM_X = const(2)  # lf, learnt offset of the centre of mass
TIP_COM_Y = const(3)
TIP_COUNT = const(4)  # swings learnt from, up to 8
TIP_SIZE = const(5)

_TIP_MAX = const(6863)  # 1.5 deg: more is a push or an obstacle
_QUICK_SWINGS = const(8)  # the first ones count four times: what the robot file does not know is found soon
_SUM_MAX = const(16383)


@hot
def tip_reset(tip: Ints, forget: int) -> int:
    """Begin a new sum; ``forget`` 1 forgets the learnt centre of mass too. Returns 0."""
    tip[TIP_ROLL] = 0
    tip[TIP_PITCH] = 0
    if forget:
        tip[TIP_COM_X] = 0
        tip[TIP_COM_Y] = 0
        tip[TIP_COUNT] = 0
    return 0


@hot
def tip_add(tip: Ints, roll_18: int, pitch_18: int) -> int:
    """Add one tick's turn about x and y, 2^-18 rad, within +-2^29; sums are limited to +-3.6 deg. Returns 0."""
    tip[TIP_ROLL] = saturate(tip[TIP_ROLL] + roll_18, -_SUM_MAX, _SUM_MAX)
    tip[TIP_PITCH] = saturate(tip[TIP_PITCH] + pitch_18, -_SUM_MAX, _SUM_MAX)
    return 0


@hot
def tip_learn(params: Params, feet: Ints, one: int, other: int, tip: Ints) -> int:
    """Learn from a swing over the feet ``one`` (a front one) and ``other``; return how it tipped, + forward.

    feet: 12 lu in the body, within +-32767. The tip about the line is limited to 1.5 deg; a tenth of the leg's
    length times it (four tenths in the first 8 swings) moves the centre along x and, by the side the line leans
    to, along y; both are limited to a tenth of the leg's length. Begins a new sum. Intermediates:
    16383 * 16383 * 2, 6863 * 3276.
    """
    along_x = feet[other * 3] - feet[one * 3] >> 2
    along_y = feet[other * 3 + 1] - feet[one * 3 + 1] >> 2
    side = 1
    if along_y < 0:
        along_x = -along_x
        along_y = -along_y
        side = -1
    length = hypot(along_x, along_y) + 1
    tipped = (tip[TIP_ROLL] * along_x + tip[TIP_PITCH] * along_y) // length
    tipped = saturate(tipped, -_TIP_MAX, _TIP_MAX)
    most = params.leg_length // 10
    step = tipped * most >> 18 - LF_BITS
    if tip[TIP_COUNT] < _QUICK_SWINGS:
        tip[TIP_COUNT] += 1
        step <<= 2
    most = most << LF_BITS
    tip[TIP_COM_X] = saturate(tip[TIP_COM_X] + step, -most, most)
    tip[TIP_COM_Y] = saturate(tip[TIP_COM_Y] + side * step, -most, most)
    tip[TIP_ROLL] = 0
    tip[TIP_PITCH] = 0
    return tipped
