"""Where the feet of the crawl go: every hind foot steps into a foothold of the front foot of its side.

So the hind feet know the height of their ground, but for the first footholds, which are guessed. Each side has a queue
of at most four. A front foot goes half a stride beyond the other front foot.
"""

from ..body.params import FL, FR, LF_BITS, RR, Params
from ..num.fixed import saturate
from ..runtime import const, hot
from .even import expected_rise
from .state import Crawl, Footholds, Map

MOST_FOOTHOLDS = const(4)
_SIDE = const(12)  # values of a side's queue


@hot
def footholds_start(crawl: Crawl) -> None:
    """Lay the first footholds between hind and front foot of each side, as if the robot had come that way.

    Right: 1/3, 2/3 and 3/3 of the way from the hind to the front foot; left: 1/6, 3/6, 5/6, half a stride on.
    Their heights lie on the line between the two feet.
    """
    map = crawl.map
    footholds = crawl.footholds
    for side in range(2):
        front = side * 3
        hind = front + RR * 3
        gap_x = map.feet[front] - map.feet[hind]
        gap_z = map.feet[front + 2] - map.feet[hind + 2]
        for place in range(3):
            sixths = 2 * place + 2 - side
            at = side * _SIDE + place * 3
            footholds.places[at] = map.feet[hind] + gap_x * sixths // 6
            footholds.places[at + 1] = foothold_line(crawl.params, side)
            footholds.places[at + 2] = map.feet[hind + 2] + gap_z * sixths // 6
        footholds.waiting[side] = 3
        footholds.guessed[side] = 2 + side
        footholds.taken[side] = 1 - side


@hot
def foothold_line(params: Params, side: int) -> int:
    """Return y in lf of a side's footholds (0 right, 1 left): its feet at rest, from the map's x axis."""
    return params.legs[RR + side].rest[1] << LF_BITS


@hot
def foothold_add(map: Map, footholds: Footholds, side: int) -> int:
    """Append the place of a side's front foot; return how many footholds the side has now.

    A full queue loses its oldest: the hind foot is then more than a stride behind, and would never use it.
    """
    if footholds.waiting[side] >= MOST_FOOTHOLDS:
        foothold_drop(footholds, side)
    footholds.waiting[side] += 1
    return foothold_keep(map, footholds, side)


@hot
def foothold_keep(map: Map, footholds: Footholds, side: int) -> int:
    """Put the last foothold of a side, which has one, under its front foot; return how many there are."""
    last = side * _SIDE + (footholds.waiting[side] - 1) * 3
    for axis in range(3):
        footholds.places[last + axis] = map.feet[side * 3 + axis]
    return footholds.waiting[side]


@hot
def follow_front_feet(crawl: Crawl) -> None:
    """Let the footholds on which front feet stand follow them in the map."""
    footholds = crawl.footholds
    for side in range(2):
        if crawl.support.stance[side] and footholds.taken[side] and footholds.waiting[side]:
            foothold_keep(crawl.map, footholds, side)


@hot
def foothold_drop(footholds: Footholds, side: int) -> None:
    """Forget the oldest foothold of a side."""
    for at in range(side * _SIDE, side * _SIDE + _SIDE - 3):
        footholds.places[at] = footholds.places[at + 3]
    if footholds.waiting[side] > 0:
        footholds.waiting[side] -= 1
    if footholds.guessed[side] > 0:
        footholds.guessed[side] -= 1


@hot
def aim(crawl: Crawl, leg: int) -> None:
    """Choose the foothold of ``leg``, its expected height and the top of the swing."""
    if leg < RR:
        aim_front(crawl, leg)
    else:
        aim_hind(crawl, leg)


@hot
def aim_front(crawl: Crawl, leg: int) -> None:
    """Aim half a stride beyond the other front foot, 0.5 .. 1.4 strides beyond the own, on the slope.

    The top is a front foot's lift above the higher of both front feet, the other counting only if it stands before
    or at the target: what it stands on may begin right here.
    """
    params = crawl.params
    map = crawl.map
    swing = crawl.swing
    own = leg * 3
    other = (FR + FL - leg) * 3
    stride = params.crawl.stride << LF_BITS
    x = map.feet[own]
    z = map.feet[own + 2]
    target = saturate(map.feet[other] + (stride >> 1), x + (stride >> 1), x + stride * 7 // 5)
    swing.target[0] = target
    swing.target[1] = foothold_line(params, leg)
    swing.target[2] = z
    swing.known = 0
    swing.ground = z + expected_rise(crawl, target - x)
    if map.feet[other + 2] > z and map.feet[other] <= target + (params.crawl.riser_lag * 5 // 3 << LF_BITS):
        z = map.feet[other + 2]
    swing.top = z + (params.crawl.front_lift << LF_BITS)


@hot
def aim_hind(crawl: Crawl, leg: int) -> None:
    """Aim at the oldest foothold of the side and take it off the queue; without one, a stride ahead."""
    params = crawl.params
    map = crawl.map
    footholds = crawl.footholds
    swing = crawl.swing
    side = leg - RR
    top = map.feet[leg * 3 + 2]
    swing.known = 0
    if footholds.waiting[side] > 0:
        if footholds.guessed[side] == 0:
            swing.known = 1
        for axis in range(3):
            swing.target[axis] = footholds.places[side * _SIDE + axis]
        foothold_drop(footholds, side)
    else:
        swing.target[0] = map.feet[leg * 3] + (params.crawl.stride << LF_BITS)
        swing.target[1] = foothold_line(params, side)
        swing.target[2] = top
    swing.ground = swing.target[2]
    if swing.ground > top:
        top = swing.ground
    swing.top = top + (params.crawl.hind_lift << LF_BITS)


@hot
def steps_down(crawl: Crawl, leg: int) -> int:
    """Return 1 if the next foothold of hind ``leg`` lies more than an edge's height below it, else 0."""
    if leg < RR or crawl.footholds.waiting[leg - RR] < 1:
        return 0
    down = crawl.map.feet[leg * 3 + 2] - crawl.footholds.places[(leg - RR) * _SIDE + 2]
    if down > crawl.params.crawl.edge_height << LF_BITS:
        return 1
    return 0


@hot
def next_foothold_x(footholds: Footholds, leg: int) -> int:
    """Return x in lf of the next foothold of hind ``leg``."""
    return footholds.places[(leg - RR) * _SIDE]
