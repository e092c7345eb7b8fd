"""Whether the ground under the crawl is even: all footholds on one slope along the way, and each step along it.

On such ground the crawl expects its next step on that slope, takes long strides, and at last gives way to the trot.
"""

from ..body.params import FR, LEGS, LF_BITS, RR
from ..num.fixed import saturate
from ..runtime import const, hot
from .map import front_to_hind
from .state import Crawl, Ground, Map

TROT_LANDINGS = const(16)  # landings on even ground: the hind feet are then past where the front feet began
_LONG_STRIDE_LANDINGS = const(8)  # landings on even ground, two of each leg, from which on strides are long
_SLOPE_LANDINGS = const(3)  # landings on a slope until the next is expected there


@hot
def note_landing(crawl: Crawl, leg: int) -> int:
    """Note whether the ground is even where ``leg`` has landed; return for how many landings it has been.

    Even is within a third of a drop's depth (8 mm of a leg of 240 mm) of a slope along the way: the trot's own
    measure.
    """
    ground = crawl.ground
    ground.landings = ground.landings + 1 & 0xFFFFFF
    ground.even_landings += 1
    if unevenness(crawl, leg) > crawl.params.crawl.drop_depth // 3:
        ground.even_landings = 0
    return ground.even_landings


@hot
def unevenness(crawl: Crawl, leg: int) -> int:
    """Return how far the footholds' heights spread about their slope, and a front ``leg``'s step is off it, lu.

    A robot astride an edge stands on a slope too, but its front feet do not go on along it.
    """
    map = crawl.map
    swing = crawl.swing
    dx = feet_length(map)
    dz = feet_rise(map)
    low = 0x1FFFF
    high = -0x1FFFF
    for other in range(LEGS):
        foot = map.feet[other]
        off = off_slope(foot.x - map.feet[FR].x, foot.z - map.feet[FR].z, dx, dz)
        if off < low:
            low = off
        if off > high:
            high = off
    uneven = high - low
    if leg < RR:
        off = off_slope(map.feet[leg].x - swing.departure.x, map.feet[leg].z - swing.target.z, dx, dz)
        if off < 0:
            off = -off
        if off > uneven:
            uneven = off
    return uneven


@hot
def even_for_trot(ground: Ground) -> int:
    """Return 1 when all footholds have been even and found at once for four strides, a body's length; else 0."""
    if ground.even_landings >= TROT_LANDINGS:
        return 1
    return 0


@hot
def long_strides(ground: Ground) -> int:
    """Return 1 where the strides are long and the motions quick: on even ground; else 0."""
    if ground.even_landings >= _LONG_STRIDE_LANDINGS:
        return 1
    return 0


@hot
def stride_lf(crawl: Crawl) -> int:
    """Return the stride, how far each leg steps in a round of all four, lf."""
    if long_strides(crawl.ground):
        return crawl.params.crawl.long_stride << LF_BITS
    return crawl.params.crawl.stride << LF_BITS


@hot
def feet_length(map: Map) -> int:
    """Return how far the middle of the front feet is before that of the hind feet, 4 lu: 1 .. 16383."""
    return saturate(front_to_hind(map, 0) >> LF_BITS + 3, 1, 16383)


@hot
def feet_rise(map: Map) -> int:
    """Return how far the middle of the front feet is above that of the hind feet, lu within +-16383."""
    return saturate(front_to_hind(map, 2) >> LF_BITS + 1, -16383, 16383)


@hot
def off_slope(ahead_lf: int, rise_lf: int, dx: int, dz: int) -> int:
    """Return by how much ``rise`` over ``ahead`` (lf) is off a slope of dz (lu) in dx (4 lu), lu.

    Ahead limited to +-65532 lu, rise to +-16383; dx 1 .. 16383, dz within 16383. Error at most 2 lu and what dz and
    dx were rounded by. Largest intermediate 16383 * 16383.
    """
    ahead = saturate(ahead_lf >> LF_BITS + 2, -16383, 16383)
    rise = saturate(rise_lf >> LF_BITS, -16383, 16383)
    return rise - ahead * dz // dx


@hot
def expected_rise(crawl: Crawl, ahead_lf: int) -> int:
    """Return by how much the ground is expected to rise over ``ahead`` (at most +-65532 lu), lf; 0 unless it slopes.

    It slopes if the last landings were even and the rise is above a sixth of a drop (4 mm of a leg of 240 mm).
    """
    if crawl.ground.even_landings < _SLOPE_LANDINGS:
        return 0
    rise = -off_slope(ahead_lf, 0, feet_length(crawl.map), feet_rise(crawl.map))
    least = crawl.params.crawl.drop_depth // 6
    if rise < least and rise > -least:
        return 0
    return saturate(rise, -16383, 16383) << LF_BITS
