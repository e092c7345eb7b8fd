"""The static stability margin: how far the centre of mass is inside the support polygon (paper B, section IV).

The polygon's corners are the stance feet, in the level plane. Two feet have a line, whose margin is never above 0. The
same code handles four, three and two feet.
"""

from ..num.fixed import hypot, isqrt, saturate
from ..runtime import Ints, const, hot
from .axes import Spot
from .feet import Feet
from .params import LEGS

NO_SUPPORT = const(-32768)  # no foot stands
_AROUND = const(0x2310)  # FR, FL, RL, RR: the feet anticlockwise, seen from above, from the lowest four bits on


@hot
def around(place: int) -> int:
    """Return the leg at place 0 .. 3 (any number, taken modulo 4) of the way round the body: FR, FL, RL, RR."""
    return _AROUND >> ((place & 3) << 2) & 3


@hot
def next_standing(weights: Ints, place: int) -> int:
    """Return the next place after ``place`` (0 .. 3) whose foot stands (weight above 0), or ``place`` itself."""
    for ahead in range(1, 4):
        if weights[around(place + ahead)] > 0:
            return place + ahead & 3
    return place


@hot
def edge_margin(feet: Feet, one: int, other: int, x: int, y: int) -> int:
    """Return how far (x, y) lies to the left of the line from foot ``one`` to foot ``other``, lu.

    Feet and point within +-32767 lu. Two feet in one place: minus the distance to them. Error at most 8 lu.
    Intermediates: 16383 * 16383 * 2 < 2^30.
    """
    first = feet.legs[one]
    then = feet.legs[other]
    from_x = first.x
    from_y = first.y
    along_x = then.x - from_x >> 2
    along_y = then.y - from_y >> 2
    length = isqrt(along_x * along_x + along_y * along_y)
    if length == 0:
        return -hypot(x - from_x, y - from_y)
    side = along_x * (y - from_y >> 2) - along_y * (x - from_x >> 2)
    return (side // length) << 2


@hot
def support_margin(feet: Feet, weights: Ints, x: int, y: int) -> int:
    """Return the margin in lu of the point (x, y) in the polygon of the standing feet; above 0 is inside.

    feet: lu in a level frame; weights: 4 values, above 0 for a foot that stands; all within +-32767 lu.
    NO_SUPPORT without a foot; with one, minus the distance to it. Error at most 8 lu.
    """
    margin = 0x1FFFF
    first = -1
    before = -1
    for place in range(0, 16, 4):
        leg = _AROUND >> place & 3
        if weights[leg] > 0:
            if before < 0:
                first = leg
            else:
                along = edge_margin(feet, before, leg, x, y)
                if along < margin:
                    margin = along
            before = leg
    if before < 0:
        return NO_SUPPORT
    along = edge_margin(feet, before, first, x, y)
    if along < margin:
        return along
    return margin


@hot
def point_inside(feet: Feet, weights: Ints, margin: int, point: Spot) -> None:
    """Move ``point`` (lu) until it is ``margin`` inside every edge of the support.

    Moves square to the most violated edge, at most 8 times: near the closest such point, or, where the
    polygon has no room for the margin, near its middle. Feet and point within +-32767 lu, margin 0 .. 32767.
    Intermediates: 2 * 32767 * 8191 in the move.
    """
    for _ in range(8):
        least = 0x1FFFF
        one = 0
        other = 0
        for place in range(LEGS):
            leg = around(place)
            if weights[leg] > 0:
                then = around(next_standing(weights, place))
                along = edge_margin(feet, leg, then, point.x, point.y)
                if along < least:
                    least = along
                    one = leg
                    other = then
        if least >= margin - 4 or one == other:
            return
        start = feet.legs[one]
        end = feet.legs[other]
        along_x = end.x - start.x >> 3
        along_y = end.y - start.y >> 3
        length = hypot(along_x, along_y) + 1
        short = saturate(margin - least + 3, 0, 32767)
        point.x = saturate(point.x - along_y * short // length, -32767, 32767)
        point.y = saturate(point.y + along_x * short // length, -32767, 32767)
