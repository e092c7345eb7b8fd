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
from .runtime import Ints, const, hot

_PRODUCT_MAX = const(0x3FFFFFFF)


@hot
def enter(state: Ints, phase: int) -> int:
    """Begin a phase of the swing at rest; return it."""
    state[C_PHASE] = phase
    state[C_TICK] = 0
    state[C_SPEED] = 0
    return phase


@hot
def try_again(state: Ints, x_lf: int, top_lf: int) -> int:
    """Lift once more, to ``top``, aim at ``x`` and come down there; return which try that is."""
    state[C_TRIES] += 1
    state[C_TARGET] = x_lf
    state[C_TOP] = top_lf
    enter(state, LIFT)
    return state[C_TRIES]


@hot
def brake_speed(brake: int, way_lu: int) -> int:
    """Return the speed, lf / tick, from which ``brake`` / 2 (lf / tick^2) stops within ``way`` (lu): sqrt(brake * way).

    Range: brake 0 .. 2^29; the way is limited to what keeps the product below 2^30: a lower speed than could
    be. Error at most 16 lf / tick.
    """
    return isqrt(brake * saturate(way_lu, 0, _PRODUCT_MAX // (brake + 1))) << 4


@hot
def lift_foot(settings: Ints, state: Ints) -> int:
    """Take one tick upwards; return 1 at the top. A leg that is folded already has its top where it is."""
    speed = state[C_SPEED] + settings[K_A_UP]
    top_speed = brake_speed(settings[K_BRAKE], state[C_TOP] - state[C_POS + 2] >> LF_BITS) + settings[K_V_TOP]
    if speed > top_speed:
        speed = top_speed
    if speed > settings[K_V_UP]:
        speed = settings[K_V_UP]
    state[C_SPEED] = speed
    z = state[C_POS + 2] + speed
    if z > state[C_TOP]:
        z = state[C_TOP]
    if state[C_LENGTH] < settings[K_NEAR]:
        state[C_TOP] = z
    if state[C_POS + 2] < z:
        state[C_POS + 2] = z
    if z < state[C_TOP]:
        return 0
    return 1


@hot
def start_move(settings: Ints, state: Ints) -> int:
    """Begin the way across to the target from where the foot is; return its ticks. Ways within +-65535 lu."""
    state[C_SOURCE] = state[C_POS]
    state[C_SOURCE + 1] = state[C_POS + 1]
    way = hypot(state[C_TARGET] - state[C_POS] >> LF_BITS, state[C_TARGET + 1] - state[C_POS + 1] >> LF_BITS)
    ticks = (way << LF_BITS) // settings[K_MOVE_PACE]
    if ticks < settings[K_MOVE_TICKS]:
        ticks = settings[K_MOVE_TICKS]
    state[C_MOVE_TICKS] = ticks
    enter(state, MOVE)
    return ticks


@hot
def move_foot(state: Ints) -> int:
    """Take one tick across; return 1 when the foot is there and the body's move has ended too, else 0."""
    share = quintic_q15(state[C_TICK], state[C_MOVE_TICKS])
    state[C_POS] = state[C_SOURCE] + fraction(state[C_TARGET] - state[C_SOURCE], share)
    state[C_POS + 1] = state[C_SOURCE + 1] + fraction(state[C_TARGET + 1] - state[C_SOURCE + 1], share)
    if state[C_TICK] < state[C_MOVE_TICKS] or state[C_BODY_TICK] < state[C_BODY_TICKS]:
        return 0
    return 1


@hot
def fall_speed(settings: Ints, state: Ints, leg: int) -> int:
    """Return the speed, lf / tick, at which the foot may come down here.

    Front: steady. Hind: so that it can slow down, at K_A_DOWN, to K_V_SLOW near its print: v^2 = slow^2 + 2 a h.
    Intermediates: those of brake_speed and hypot.
    """
    if leg < RR:
        return settings[K_V_FRONT]
    above = (state[C_POS + 2] - state[C_EXPECT] >> LF_BITS) - settings[K_NEAR_PRINT]
    speed = hypot(brake_speed(2 * settings[K_A_DOWN], above), settings[K_V_SLOW])
    if above < 0:
        speed = settings[K_V_SLOW]
    if speed > settings[K_V_REAR]:
        speed = settings[K_V_REAR]
    return speed


@hot
def lower_foot(settings: Ints, state: Ints, leg: int) -> int:
    """Take one tick down: the foot, or where the leg is at its longest the body; return the speed, lf / tick."""
    speed = state[C_SPEED] + settings[K_A_DOWN]
    most = fall_speed(settings, state, leg)
    if speed > most:
        speed = most
    state[C_SPEED] = speed
    if state[C_LENGTH] > settings[K_REACH_SWING] and state[C_REF + 2] > state[C_BODY + 2] - settings[K_LIMIT_X]:
        state[C_REF + 2] -= settings[K_BODY_V]
    else:
        state[C_POS + 2] -= speed
    return speed


@hot
def hang_foot(settings: Ints, state: Ints) -> int:
    """Take one tick of creeping down, while the tare is taken; return the speed, lf / tick."""
    state[C_POS + 2] -= settings[K_V_TARE]
    return settings[K_V_TARE]
