"""Where the feet of the crawl go: every hind foot steps into a foothold of the front foot of its side.

So the hind feet know the height of their ground, but for the first footholds, which are guessed. Each side has a queue
of at most four. A front foot goes half a stride beyond the other front foot. On even ground, where strides are long, a
hind foot may step anywhere: it keeps its distance to the front foot of its side.
"""

from ..body.params import FL, FR, LF_BITS, RR, Params
from ..num.fixed import saturate
from ..runtime import hot
from .ground import expected_rise, long_strides, stride_lf
from .state import MOST_FOOTHOLDS, Crawl, Footholds, Map


@hot
def footholds_start(crawl: Crawl) -> None:
    """Lay the first footholds between hind and front foot of each side, as if the robot had come that way.

    Right: 1/3, 2/3 and 3/3 of the way from the hind to the front foot; left: 1/6, 3/6, 5/6, half a stride on.
    Their heights lie on the line between the two feet.
    """
    map = crawl.map
    for side in range(2):
        queue = crawl.footholds.sides[side]
        front = map.feet[side]
        hind = map.feet[RR + side]
        gap_x = front.x - hind.x
        gap_z = front.z - hind.z
        for place in range(3):
            sixths = 2 * place + 2 - side
            foothold = queue.places[place]
            foothold.x = hind.x + gap_x * sixths // 6
            foothold.y = foothold_line(crawl.params, side)
            foothold.z = hind.z + gap_z * sixths // 6
        queue.waiting = 3
        queue.guessed = 2 + side
        queue.occupied = 1 - side


@hot
def foothold_line(params: Params, side: int) -> int:
    """Return y in lf of a side's footholds (0 right, 1 left): its feet at rest, from the map's x axis."""
    return params.legs[RR + side].rest.y << LF_BITS


@hot
def foothold_add(map: Map, footholds: Footholds, side: int) -> int:
    """Append the place of a side's front foot; return how many footholds the side has now.

    A full queue loses its oldest: the hind foot is then more than a stride behind, and would never use it.
    """
    queue = footholds.sides[side]
    if queue.waiting >= MOST_FOOTHOLDS:
        foothold_drop(footholds, side)
    queue.waiting += 1
    return foothold_keep(map, footholds, side)


@hot
def foothold_keep(map: Map, footholds: Footholds, side: int) -> int:
    """Put the last foothold of a side, which has one, under its front foot; return how many there are."""
    queue = footholds.sides[side]
    last = queue.places[queue.waiting - 1]
    foot = map.feet[side]
    last.x = foot.x
    last.y = foot.y
    last.z = foot.z
    return queue.waiting


@hot
def draw_back(crawl: Crawl, side: int) -> None:
    """Draw the foothold before the last of a side back: its front foot has stepped down from there, maybe off a rim."""
    queue = crawl.footholds.sides[side]
    if queue.waiting > 1:
        queue.places[queue.waiting - 2].x -= crawl.params.crawl.edge_retreat << LF_BITS


@hot
def follow_front_feet(crawl: Crawl) -> None:
    """Let the footholds on which front feet stand follow them in the map."""
    for side in range(2):
        queue = crawl.footholds.sides[side]
        if crawl.support.stance[side] and queue.occupied and queue.waiting:
            foothold_keep(crawl.map, crawl.footholds, side)


@hot
def foothold_drop(footholds: Footholds, side: int) -> None:
    """Forget the oldest foothold of a side."""
    queue = footholds.sides[side]
    older = queue.places[0]
    for place in range(1, queue.waiting):
        newer = queue.places[place]
        older.x = newer.x
        older.y = newer.y
        older.z = newer.z
        older = newer
    if queue.waiting > 0:
        queue.waiting -= 1
    if queue.guessed > 0:
        queue.guessed -= 1


@hot
def aim(crawl: Crawl, leg: int) -> None:
    """Choose the foothold of ``leg``, its expected height and the apex of the swing."""
    if leg < RR:
        aim_front(crawl, leg)
        return
    if long_strides(crawl.ground):
        aim_hind_even(crawl, leg)
    else:
        aim_hind(crawl, leg)
    apex = crawl.map.feet[leg].z
    if crawl.swing.ground > apex:
        apex = crawl.swing.ground
    crawl.swing.apex = apex + (crawl.params.crawl.hind_lift << LF_BITS)


@hot
def aim_front(crawl: Crawl, leg: int) -> None:
    """Aim half a stride beyond the other front foot, 0.5 .. 1.4 strides beyond the own, on the slope.

    The apex is a front foot's lift above the higher of both front feet, the other counting only if it stands before
    or at the target: what it stands on may begin right here.
    """
    params = crawl.params
    map = crawl.map
    swing = crawl.swing
    other = map.feet[FR + FL - leg]
    stride = stride_lf(crawl)
    x = map.feet[leg].x
    z = map.feet[leg].z
    target = saturate(other.x + (stride >> 1), x + (stride >> 1), x + stride * 7 // 5)
    swing.target.x = target
    swing.target.y = foothold_line(params, leg)
    swing.target.z = z
    swing.known = 0
    swing.ground = z + expected_rise(crawl, target - x)
    if other.z > z and other.x <= target + (params.crawl.riser_lag * 5 // 3 << LF_BITS):
        z = other.z
    swing.apex = z + (params.crawl.front_lift << LF_BITS)


@hot
def aim_hind(crawl: Crawl, leg: int) -> None:
    """Aim at the oldest foothold of the side and take it off the queue; without one, a stride ahead."""
    params = crawl.params
    swing = crawl.swing
    foot = crawl.map.feet[leg]
    side = leg - RR
    queue = crawl.footholds.sides[side]
    swing.known = 0
    if queue.waiting > 0:
        if queue.guessed == 0:
            swing.known = 1
        oldest = queue.places[0]
        for axis in range(3):
            swing.target[axis] = oldest[axis]
        foothold_drop(crawl.footholds, side)
    else:
        swing.target.x = foot.x + (params.crawl.stride << LF_BITS)
        swing.target.y = foothold_line(params, side)
        swing.target.z = foot.z
    swing.ground = swing.target.z


@hot
def aim_hind_even(crawl: Crawl, leg: int) -> None:
    """Aim a hind foot on even ground a hip distance behind the next place of its side's front foot.

    0.5 .. 1.4 strides on. Footholds of the front foot are not needed: those that it has left are forgotten.
    """
    params = crawl.params
    swing = crawl.swing
    foot = crawl.map.feet[leg]
    side = leg - RR
    stride = stride_lf(crawl)
    ahead = crawl.map.feet[side].x + stride - (params.crawl.half_length << LF_BITS + 1) - foot.x
    ahead = saturate(ahead, stride >> 1, stride * 7 // 5)
    swing.known = 1
    swing.target.x = foot.x + ahead
    swing.target.y = foothold_line(params, side)
    swing.target.z = foot.z
    swing.ground = foot.z + expected_rise(crawl, ahead)
    crawl.footholds.sides[side].waiting = 0


@hot
def lay_between(crawl: Crawl, leg: int) -> None:
    """Lay two footholds between a hind foot and the only one it has, where strides are no longer long.

    They are a stride apart, a third of the way if that is less, and as high as the foot: that ground was even.
    """
    foot = crawl.map.feet[leg]
    queue = crawl.footholds.sides[leg - RR]
    if queue.waiting != 1:
        return
    for axis in range(3):
        queue.places[2][axis] = queue.places[0][axis]
    step = (queue.places[0].x - foot.x) // 3
    stride = crawl.params.crawl.stride << LF_BITS
    if step > stride:
        step = stride
    for place in range(2):
        queue.places[place].x = foot.x + step * (place + 1)
        queue.places[place].y = queue.places[2].y
        queue.places[place].z = foot.z
    queue.waiting = 3
    queue.guessed = 2


@hot
def steps_down(crawl: Crawl, leg: int) -> int:
    """Return 1 if the next foothold of hind ``leg`` lies more than an edge's height below it, else 0."""
    if leg < RR:
        return 0
    queue = crawl.footholds.sides[leg - RR]
    edge = crawl.params.crawl.edge_height << LF_BITS
    if queue.waiting and crawl.map.feet[leg].z - queue.places[0].z > edge:
        return 1
    return 0


@hot
def next_foothold_x(footholds: Footholds, leg: int) -> int:
    """Return x in lf of the next foothold of hind ``leg``."""
    return footholds.sides[leg - RR].places[0].x
