"""Where the feet of the crawl go: every hind foot steps into a print of the front foot of its side.

So only the front feet meet unknown ground, and the hind feet know its height. Each side has a queue
of at most four prints. A front foot goes half a stride beyond the other front foot.
"""

from .crawl_even import expected_rise
from .crawl_layout import (
    C_EXPECT,
    C_FOOT,
    C_ON_PRINT,
    C_PRINT,
    C_PRINTS,
    C_TARGET,
    C_TOP,
    K_HIGH,
    K_HIT,
    K_LIFT_FRONT,
    K_LIFT_REAR,
    K_STRIDE,
)
from .fixed import saturate
from .params import FL, FR, LF_BITS, RR, Params
from .runtime import const, hot, ptr32

MOST_PRINTS = const(4)
_SIDE = const(12)  # values of a side's queue


@hot
def prints_start(params: Params, state) -> int:
    """Lay the first prints between hind and front foot of each side, as if the robot had come that way; return 0.

    Right: 1/3, 2/3 and 3/3 of the way from the hind to the front foot; left: 1/6, 3/6, 5/6, half a stride on.
    Their heights lie on the line between the two feet.
    """
    c = ptr32(state)
    for side in range(2):
        front = C_FOOT + side * 3
        hind = front + RR * 3
        gap_x = c[front] - c[hind]
        gap_z = c[front + 2] - c[hind + 2]
        for place in range(3):
            sixths = 2 * place + 2 - side
            at = C_PRINT + side * _SIDE + place * 3
            c[at] = c[hind] + gap_x * sixths // 6
            c[at + 1] = print_line(params, side)
            c[at + 2] = c[hind + 2] + gap_z * sixths // 6
        c[C_PRINTS + side] = 3
        c[C_ON_PRINT + side] = 1 - side
    return 0


@hot
def print_line(params: Params, side: int) -> int:
    """Return y in lf of a side's prints (0 right, 1 left): where its feet are at rest, from the map's x axis."""
    return params.legs[RR + side].rest[1] << LF_BITS


@hot
def print_add(state, side: int, foot_at: int) -> int:
    """Append the point at ``state[foot_at]`` to a side's prints; return how many there are now.

    A full queue loses its oldest: the hind foot is then more than a stride behind, and would never use it.
    """
    c = ptr32(state)
    if c[C_PRINTS + side] >= MOST_PRINTS:
        print_drop(state, side)
    at = C_PRINT + side * _SIDE + c[C_PRINTS + side] * 3
    for axis in range(3):
        c[at + axis] = c[foot_at + axis]
    c[C_PRINTS + side] += 1
    return c[C_PRINTS + side]


@hot
def print_drop(state, side: int) -> int:
    """Forget the oldest print of a side; return how many are left."""
    c = ptr32(state)
    at = C_PRINT + side * _SIDE
    for value in range(_SIDE - 3):
        c[at + value] = c[at + value + 3]
    if c[C_PRINTS + side] > 0:
        c[C_PRINTS + side] -= 1
    return c[C_PRINTS + side]


@hot
def aim(params: Params, settings, state, leg: int) -> int:
    """Choose the foothold and the top of the swing of ``leg``: C_TARGET, C_EXPECT, C_TOP; return 0."""
    if leg < RR:
        return aim_front(params, settings, state, leg)
    return aim_hind(params, settings, state, leg)


@hot
def aim_front(params: Params, settings, state, leg: int) -> int:
    """Aim half a stride beyond the other front foot, 0.5 .. 1.4 strides beyond the own, on the slope; return 0.

    The top is K_LIFT_FRONT above the higher of both front feet, the other counting only if it stands before
    or at the target: what it stands on may begin right here.
    """
    k = ptr32(settings)
    c = ptr32(state)
    own = C_FOOT + leg * 3
    other = C_FOOT + (FR + FL - leg) * 3
    stride = k[K_STRIDE] << LF_BITS
    x = saturate(c[other] + (stride >> 1), c[own] + (stride >> 1), c[own] + stride * 7 // 5)
    c[C_TARGET] = x
    c[C_TARGET + 1] = print_line(params, leg)
    c[C_TARGET + 2] = c[own + 2]
    c[C_EXPECT] = c[own + 2] + expected_rise(settings, state, x - c[own])
    top = c[own + 2]
    if c[other + 2] > top and c[other] <= x + (k[K_HIT] * 5 // 3 << LF_BITS):
        top = c[other + 2]
    c[C_TOP] = top + (k[K_LIFT_FRONT] << LF_BITS)
    return 0


@hot
def aim_hind(params: Params, settings, state, leg: int) -> int:
    """Aim at the oldest print of the leg's side and take it off the queue; without one, a stride ahead. Returns 0."""
    k = ptr32(settings)
    c = ptr32(state)
    side = leg - RR
    own = C_FOOT + leg * 3
    if c[C_PRINTS + side] > 0:
        for axis in range(3):
            c[C_TARGET + axis] = c[C_PRINT + side * _SIDE + axis]
        print_drop(state, side)
    else:
        c[C_TARGET] = c[own] + (k[K_STRIDE] << LF_BITS)
        c[C_TARGET + 1] = print_line(params, side)
        c[C_TARGET + 2] = c[own + 2]
    c[C_EXPECT] = c[C_TARGET + 2]
    top = c[own + 2]
    if c[C_TARGET + 2] > top:
        top = c[C_TARGET + 2]
    c[C_TOP] = top + (k[K_LIFT_REAR] << LF_BITS)
    return 0


@hot
def steps_down(settings, state, leg: int) -> int:
    """Return 1 if the next print of hind ``leg`` lies more than an edge (K_HIGH) below it, else 0."""
    c = ptr32(state)
    k = ptr32(settings)
    if leg < RR or c[C_PRINTS + leg - RR] < 1:
        return 0
    if c[C_PRINT + (leg - RR) * _SIDE + 2] < c[C_FOOT + leg * 3 + 2] - (k[K_HIGH] << LF_BITS):
        return 1
    return 0
