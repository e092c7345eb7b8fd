"""Sways the body sideways so that the centre of mass comes over the diagonal that is about to carry it.

With two feet down a robot tips about the line between them unless its centre of mass is above
that line. The line is taken at the centre's own x, half a swing ahead of now.
"""

from ..body.params import Params
from ..num.fixed import saturate
from ..runtime import Ints, const, hot

_SMOOTH_ONE_Q12 = const(4096)


@hot
def smooth_q12(part: int, whole: int) -> int:
    """Return u^2 (3 - 2 u) in Q12 for u = part / whole, 0 .. 1: no speed at either end.

    Range: whole 1 .. 262143, part limited to 0 .. whole; whole below 1 gives 1. Error at most 6 LSB.
    """
    if whole < 1 or part >= whole:
        return _SMOOTH_ONE_Q12
    if part <= 0:
        return 0
    u = (part << 12) // whole
    return (u * u >> 12) * (3 * _SMOOTH_ONE_Q12 - 2 * u) >> 12


@hot
def diagonal_y(feet: Ints, one: int, other: int, ahead_lu: int, x: int) -> int:
    """Return y of the line between two feet at ``x``, after both went back by ``ahead``; lu, within +-65535.

    feet: 12 lu in the body; all within +-32767. A line along y has no one answer: the first foot's y.
    Error at most 16 lu. Intermediates: 65535 * 8191 and 65535 * 2^13.
    """
    from_x = feet[one * 3] - ahead_lu
    along_x = feet[other * 3] - feet[one * 3]
    share_q12 = 0
    if along_x:
        share_q12 = saturate((saturate(x - from_x, -65535, 65535) << 13) // along_x, -8191 * 2, 8191 * 2)
    rise = saturate(feet[other * 3 + 1] - feet[one * 3 + 1], -65535, 65535)
    return saturate(feet[one * 3 + 1] + (rise * share_q12 >> 13), -65535, 65535)


@hot
def next_sway(params: Params, now_lu: int, line_y: int, com_y: int) -> int:
    """Return the sway that puts the centre of mass on the line, limited to 3/16 of the leg's length, lu.

    now: the present sway; line_y, com_y: in the body, lu, within +-65535. The robot's lateral share scales the
    move; 0 (a robot in the plane) keeps 0. Intermediates: 131070 * 6144.
    """
    most = params.leg_length * 3 >> 4
    return saturate(now_lu + ((line_y - com_y) * params.lateral_q12 >> 12), -most, most)
