"""The way of one foot through the air: up, across, hang a moment, down until something is felt.

The positions are map places in lf, so the path does not depend on what the body does meanwhile.
Profiles: up with a braked top, a quintic across, down at a steady speed that hind feet, whose
ground is known, only take up shortly above their print.
"""

from .crawl_layout import (
    C_BODY,
    C_BODY_TICK,
    C_BODY_TICKS,
    C_EXPECT,
    C_LENGTH,
    C_MOVE_TICKS,
    C_PHASE,
    C_POS,
    C_REF,
    C_SOURCE,
    C_SPEED,
    C_TARGET,
    C_TICK,
    C_TOP,
    C_TRIES,
    K_A_DOWN,
    K_A_UP,
    K_BODY_V,
    K_BRAKE,
    K_LIMIT_X,
    K_MOVE_PACE,
    K_MOVE_TICKS,
    K_NEAR,
    K_NEAR_PRINT,
    K_REACH_SWING,
    K_V_FRONT,
    K_V_REAR,
    K_V_SLOW,
    K_V_TARE,
    K_V_TOP,
    K_V_UP,
    LIFT,
    MOVE,
)
from .filters import fraction, quintic_q15
from .fixed import hypot, isqrt, saturate
from .params import LF_BITS, RR
from .runtime import const, hot, ptr32

_PRODUCT_MAX = const(0x3FFFFFFF)


@hot
def enter(state, phase: int) -> int:
    """Begin a phase of the swing at rest; return it."""
    c = ptr32(state)
    c[C_PHASE] = phase
    c[C_TICK] = 0
    c[C_SPEED] = 0
    return phase


@hot
def try_again(state, x_lf: int, top_lf: int) -> int:
    """Lift once more, to ``top``, aim at ``x`` and come down there; return which try that is."""
    c = ptr32(state)
    c[C_TRIES] += 1
    c[C_TARGET] = x_lf
    c[C_TOP] = top_lf
    enter(state, LIFT)
    return c[C_TRIES]


@hot
def brake_speed(brake: int, way_lu: int) -> int:
    """Return the speed, lf / tick, from which ``brake`` / 2 (lf / tick^2) stops within ``way`` (lu): sqrt(brake * way).

    Range: brake 0 .. 2^29; the way is limited to what keeps the product below 2^30: a lower speed than could
    be. Error at most 16 lf / tick.
    """
    return isqrt(brake * saturate(way_lu, 0, _PRODUCT_MAX // (brake + 1))) << 4


@hot
def lift_foot(settings, state) -> int:
    """Take one tick upwards; return 1 at the top. A leg that is folded already has its top where it is."""
    k = ptr32(settings)
    c = ptr32(state)
    speed = c[C_SPEED] + k[K_A_UP]
    top_speed = brake_speed(k[K_BRAKE], c[C_TOP] - c[C_POS + 2] >> LF_BITS) + k[K_V_TOP]
    if speed > top_speed:
        speed = top_speed
    if speed > k[K_V_UP]:
        speed = k[K_V_UP]
    c[C_SPEED] = speed
    z = c[C_POS + 2] + speed
    if z > c[C_TOP]:
        z = c[C_TOP]
    if c[C_LENGTH] < k[K_NEAR]:
        c[C_TOP] = z
    if c[C_POS + 2] < z:
        c[C_POS + 2] = z
    if z < c[C_TOP]:
        return 0
    return 1


@hot
def start_move(settings, state) -> int:
    """Begin the way across to the target from where the foot is; return its ticks. Ways within +-65535 lu."""
    k = ptr32(settings)
    c = ptr32(state)
    c[C_SOURCE] = c[C_POS]
    c[C_SOURCE + 1] = c[C_POS + 1]
    way = hypot(c[C_TARGET] - c[C_POS] >> LF_BITS, c[C_TARGET + 1] - c[C_POS + 1] >> LF_BITS)
    ticks = (way << LF_BITS) // k[K_MOVE_PACE]
    if ticks < k[K_MOVE_TICKS]:
        ticks = k[K_MOVE_TICKS]
    c[C_MOVE_TICKS] = ticks
    enter(state, MOVE)
    return ticks


@hot
def move_foot(state) -> int:
    """Take one tick across; return 1 when the foot is there and the body's move has ended too, else 0."""
    c = ptr32(state)
    share = quintic_q15(c[C_TICK], c[C_MOVE_TICKS])
    c[C_POS] = c[C_SOURCE] + fraction(c[C_TARGET] - c[C_SOURCE], share)
    c[C_POS + 1] = c[C_SOURCE + 1] + fraction(c[C_TARGET + 1] - c[C_SOURCE + 1], share)
    if c[C_TICK] < c[C_MOVE_TICKS] or c[C_BODY_TICK] < c[C_BODY_TICKS]:
        return 0
    return 1


@hot
def fall_speed(settings, state, leg: int) -> int:
    """Return the speed, lf / tick, at which the foot may come down here.

    Front: steady. Hind: so that it can slow down, at K_A_DOWN, to K_V_SLOW near its print: v^2 = slow^2 + 2 a h.
    Intermediates: those of brake_speed and hypot.
    """
    k = ptr32(settings)
    c = ptr32(state)
    if leg < RR:
        return k[K_V_FRONT]
    above = (c[C_POS + 2] - c[C_EXPECT] >> LF_BITS) - k[K_NEAR_PRINT]
    speed = hypot(brake_speed(2 * k[K_A_DOWN], above), k[K_V_SLOW])
    if above < 0:
        speed = k[K_V_SLOW]
    if speed > k[K_V_REAR]:
        speed = k[K_V_REAR]
    return speed


@hot
def lower_foot(settings, state, leg: int) -> int:
    """Take one tick down: the foot, or where the leg is at its longest the body; return the speed, lf / tick."""
    k = ptr32(settings)
    c = ptr32(state)
    speed = c[C_SPEED] + k[K_A_DOWN]
    most = fall_speed(settings, state, leg)
    if speed > most:
        speed = most
    c[C_SPEED] = speed
    if c[C_LENGTH] > k[K_REACH_SWING] and c[C_REF + 2] > c[C_BODY + 2] - k[K_LIMIT_X]:
        c[C_REF + 2] -= k[K_BODY_V]
    else:
        c[C_POS + 2] -= speed
    return speed


@hot
def hang_foot(settings, state) -> int:
    """Take one tick of creeping down, while the tare is taken; return the speed, lf / tick."""
    k = ptr32(settings)
    c = ptr32(state)
    c[C_POS + 2] -= k[K_V_TARE]
    return k[K_V_TARE]
