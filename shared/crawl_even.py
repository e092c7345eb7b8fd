"""Whether the ground under the crawl is even: all footholds on one slope along the way, and each step along it.

On such ground the crawl gives way to the trot, and meanwhile expects its next step on that slope.
"""

from .crawl_layout import (
    C_EVEN,
    C_FOOT,
    C_LANDED,
    C_SOURCE,
    C_STEPS_EVEN,
    C_TARGET,
    K_VOID,
)
from .fixed import saturate
from .params import LEGS, LF_BITS, RR
from .runtime import Ints, const, hot

_SURE = const(3)  # landings on a slope until the next is expected there


@hot
def count_even(settings: Ints, state: Ints, leg: int) -> int:
    """Note how uneven the ground is where ``leg`` has landed, and for how many landings it was even; return that.

    Even is within K_VOID / 3 (8 mm of a leg of 240 mm) of a slope along the way: the trot's own measure. A robot
    astride an edge stands on a slope too, but its front feet do not go on along it.
    """
    dx = feet_length(state)
    dz = feet_rise(state)
    low = 0x1FFFF
    high = -0x1FFFF
    for other in range(LEGS):
        at = C_FOOT + other * 3
        off = off_slope(state[at] - state[C_FOOT], state[at + 2] - state[C_FOOT + 2], dx, dz)
        if off < low:
            low = off
        if off > high:
            high = off
    uneven = high - low
    if leg < RR:
        at = C_FOOT + leg * 3
        off = off_slope(state[at] - state[C_SOURCE], state[at + 2] - state[C_TARGET + 2], dx, dz)
        if off < 0:
            off = -off
        if off > uneven:
            uneven = off
    state[C_EVEN] = uneven
    state[C_LANDED] = state[C_LANDED] + 1 & 0xFFFFFF
    state[C_STEPS_EVEN] += 1
    if uneven > settings[K_VOID] // 3:
        state[C_STEPS_EVEN] = 0
    return state[C_STEPS_EVEN]


@hot
def feet_length(state: Ints) -> int:
    """Return how far the middle of the front feet is before that of the hind feet, 4 lu: 1 .. 16383."""
    return saturate(state[C_FOOT] + state[C_FOOT + 3] - state[C_FOOT + 6] - state[C_FOOT + 9] >> LF_BITS + 3, 1, 16383)


@hot
def feet_rise(state: Ints) -> int:
    """Return how far the middle of the front feet is above that of the hind feet, lu within +-16383."""
    rise = state[C_FOOT + 2] + state[C_FOOT + 5] - state[C_FOOT + 8] - state[C_FOOT + 11] >> LF_BITS + 1
    return saturate(rise, -16383, 16383)


@hot
def off_slope(way_lf: int, rise_lf: int, dx: int, dz: int) -> int:
    """Return by how much ``rise`` over ``way`` (lf) is off a slope of dz (lu) in dx (4 lu), lu.

    Way limited to +-65532 lu, rise to +-16383; dx 1 .. 16383, dz within 16383. Error at most 2 lu and what dz and
    dx were rounded by. Largest intermediate 16383 * 16383.
    """
    way = saturate(way_lf >> LF_BITS + 2, -16383, 16383)
    rise = saturate(rise_lf >> LF_BITS, -16383, 16383)
    return rise - way * dz // dx


@hot
def expected_rise(settings: Ints, state: Ints, way_lf: int) -> int:
    """Return by how much the ground is expected to rise over ``way`` (lf, at most +-65532 lu), lf; 0 unless it slopes.

    It slopes if the last landings were even and the rise is above K_VOID / 6 (4 mm of a leg of 240 mm).
    """
    if state[C_STEPS_EVEN] < _SURE:
        return 0
    rise = -off_slope(way_lf, 0, feet_length(state), feet_rise(state))
    if rise < settings[K_VOID] // 6 and rise > -(settings[K_VOID] // 6):
        return 0
    return saturate(rise, -16383, 16383) << LF_BITS
