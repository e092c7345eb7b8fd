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
from .runtime import Ints, const, hot

MOST_PRINTS = const(4)
_SIDE = const(12)  # values of a side's queue


@hot
def prints_start(params: Params, state: Ints) -> int:
    """Lay the first prints between hind and front foot of each side, as if the robot had come that way; return 0.

    Right: 1/3, 2/3 and 3/3 of the way from the hind to the front foot; left: 1/6, 3/6, 5/6, half a stride on.
    Their heights lie on the line between the two feet.
    """
    for side in range(2):
        front = C_FOOT + side * 3
        hind = front + RR * 3
        gap_x = state[front] - state[hind]
        gap_z = state[front + 2] - state[hind + 2]
        for place in range(3):
            sixths = 2 * place + 2 - side
            at = C_PRINT + side * _SIDE + place * 3
            state[at] = state[hind] + gap_x * sixths // 6
            state[at + 1] = print_line(params, side)
            state[at + 2] = state[hind + 2] + gap_z * sixths // 6
        state[C_PRINTS + side] = 3
        state[C_ON_PRINT + side] = 1 - side
    return 0


@hot
def print_line(params: Params, side: int) -> int:
    """Return y in lf of a side's prints (0 right, 1 left): where its feet are at rest, from the map's x axis."""
    return params.legs[RR + side].rest[1] << LF_BITS


@hot
def print_add(state: Ints, side: int, foot_at: int) -> int:
    """Append the point at ``state[foot_at]`` to a side's prints; return how many there are now.

    A full queue loses its oldest: the hind foot is then more than a stride behind, and would never use it.
    """
    if state[C_PRINTS + side] >= MOST_PRINTS:
        print_drop(state, side)
    at = C_PRINT + side * _SIDE + state[C_PRINTS + side] * 3
    for axis in range(3):
        state[at + axis] = state[foot_at + axis]
    state[C_PRINTS + side] += 1
    return state[C_PRINTS + side]


@hot
def print_drop(state: Ints, side: int) -> int:
    """Forget the oldest print of a side; return how many are left."""
    at = C_PRINT + side * _SIDE
    for value in range(_SIDE - 3):
        state[at + value] = state[at + value + 3]
    if state[C_PRINTS + side] > 0:
        state[C_PRINTS + side] -= 1
    return state[C_PRINTS + side]


@hot
def aim(params: Params, settings, state, leg: int) -> int:
    """Choose the foothold and the top of the swing of ``leg``: C_TARGET, C_EXPECT, C_TOP; return 0."""
    if leg < RR:
        return aim_front(params, settings, state, leg)
    return aim_hind(params, settings, state, leg)


@hot
def aim_front(params: Params, settings: Ints, state: Ints, leg: int) -> int:
    """Aim half a stride beyond the other front foot, 0.5 .. 1.4 strides beyond the own, on the slope; return 0.

    The top is K_LIFT_FRONT above the higher of both front feet, the other counting only if it stands before
    or at the target: what it stands on may begin right here.
    """
    own = C_FOOT + leg * 3
    other = C_FOOT + (FR + FL - leg) * 3
    stride = settings[K_STRIDE] << LF_BITS
    x = saturate(state[other] + (stride >> 1), state[own] + (stride >> 1), state[own] + stride * 7 // 5)
    state[C_TARGET] = x
    state[C_TARGET + 1] = print_line(params, leg)
    state[C_TARGET + 2] = state[own + 2]
    state[C_EXPECT] = state[own + 2] + expected_rise(settings, state, x - state[own])
    top = state[own + 2]
    if state[other + 2] > top and state[other] <= x + (settings[K_HIT] * 5 // 3 << LF_BITS):
        top = state[other + 2]
    state[C_TOP] = top + (settings[K_LIFT_FRONT] << LF_BITS)
    return 0


@hot
def aim_hind(params: Params, settings: Ints, state: Ints, leg: int) -> int:
    """Aim at the oldest print of the leg's side and take it off the queue; without one, a stride ahead. Returns 0."""
    side = leg - RR
    own = C_FOOT + leg * 3
    if state[C_PRINTS + side] > 0:
        for axis in range(3):
            state[C_TARGET + axis] = state[C_PRINT + side * _SIDE + axis]
        print_drop(state, side)
    else:
        state[C_TARGET] = state[own] + (settings[K_STRIDE] << LF_BITS)
        state[C_TARGET + 1] = print_line(params, side)
        state[C_TARGET + 2] = state[own + 2]
    state[C_EXPECT] = state[C_TARGET + 2]
    top = state[own + 2]
    if state[C_TARGET + 2] > top:
        top = state[C_TARGET + 2]
    state[C_TOP] = top + (settings[K_LIFT_REAR] << LF_BITS)
    return 0


@hot
def steps_down(settings: Ints, state: Ints, leg: int) -> int:
    """Return 1 if the next print of hind ``leg`` lies more than an edge (K_HIGH) below it, else 0."""
    if leg < RR or state[C_PRINTS + leg - RR] < 1:
        return 0
    if state[C_PRINT + (leg - RR) * _SIDE + 2] < state[C_FOOT + leg * 3 + 2] - (settings[K_HIGH] << LF_BITS):
        return 1
    return 0
