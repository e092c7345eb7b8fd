"""Learns where the centre of mass is from how the robot tips about its diagonal while two feet carry it.

A robot that tips forward during a swing has its centre of mass in front of the support line. A
small part of what it tipped moves the belief; two diagonals tell x and y. Payload and a wrong
robot file are found within some steps.
"""

from ..body.params import LF_BITS, Params
from ..num.fixed import hypot, saturate
from ..record import field, record
from ..runtime import Ints, const, hot


@record
class Tipping:
    """How the robot tips over its diagonals, and what that told of its centre of mass."""

    roll: int = field("2^-18 rad", "turned about x since the swing began")
    pitch: int = field("2^-18 rad", "turned about y since the swing began")
    com_x: int = field("lf", "learnt offset of the centre of mass, forward")
    com_y: int = field("lf", "learnt offset of the centre of mass, left")
    swings: int = field("", "swings learnt from, up to 8")


_TIP_MAX = const(6863)  # 1.5 deg: more is a push or an obstacle
_QUICK_SWINGS = const(8)  # the first ones count four times: what the robot file does not know is found soon
_SUM_MAX = const(16383)


@hot
def tip_reset(tip: Tipping, forget: int) -> int:
    """Begin a new sum; ``forget`` 1 forgets the learnt centre of mass too. Returns 0."""
    tip.roll = 0
    tip.pitch = 0
    if forget:
        tip.com_x = 0
        tip.com_y = 0
        tip.swings = 0
    return 0


@hot
def tip_add(tip: Tipping, roll_18: int, pitch_18: int) -> int:
    """Add one tick's turn about x and y, 2^-18 rad, within +-2^29; sums are limited to +-3.6 deg. Returns 0."""
    tip.roll = saturate(tip.roll + roll_18, -_SUM_MAX, _SUM_MAX)
    tip.pitch = saturate(tip.pitch + pitch_18, -_SUM_MAX, _SUM_MAX)
    return 0


@hot
def tip_learn(params: Params, feet: Ints, one: int, other: int, tip: Tipping) -> int:
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
    tipped = (tip.roll * along_x + tip.pitch * along_y) // length
    tipped = saturate(tipped, -_TIP_MAX, _TIP_MAX)
    most = params.leg_length // 10
    step = tipped * most >> 18 - LF_BITS
    if tip.swings < _QUICK_SWINGS:
        tip.swings += 1
        step <<= 2
    most = most << LF_BITS
    tip.com_x = saturate(tip.com_x + step, -most, most)
    tip.com_y = saturate(tip.com_y + side * step, -most, most)
    tip.roll = 0
    tip.pitch = 0
    return tipped
