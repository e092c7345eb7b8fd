"""What a leg in the air feels: ground under the foot, an edge under the shin, a riser in front.

There is no foot switch: the vertical force comes from the joints' errors. A leg that hangs reads its own
weight and its friction; that tare is taken before it goes down and followed while nothing touches.
"""

from .body import POSE_PITCH, POSE_ROLL
from .crawl_layout import (
    C_BODY,
    C_CLIPPED,
    C_FORCE,
    C_HITS,
    C_MOVE_TICKS,
    C_PAST,
    C_PAST_AT,
    C_PEAK,
    C_POS,
    C_REF,
    C_SEEN,
    C_SOURCE,
    C_SPEED,
    C_TARE,
    C_TARGET,
    C_TICK,
    C_TOUCHED,
    K_ARM_X,
    K_ARM_Y,
    K_HIT,
    K_HIT_AFTER,
    K_HIT_LAG,
    K_LATE,
    K_TARE_FAST,
    K_TARE_IN,
    K_TARE_SKIP,
    K_TARE_SLOW,
    K_TOUCH_TICKS,
    K_V_QUICK,
    PAST_SIZE,
)
from .filters import fraction
from .fixed import saturate
from .params import LF_BITS, RR
from .runtime import Ints, const, hot

# Parts of the own weight in Q12; in brackets what that is on Caramelo (21.6 N)
_TOUCH_Q12 = const(569)  # 3 N
_PEAK_Q12 = const(758)  # 4 N
_FAST_Q12 = const(1706)  # 9 N: a foot that still falls fast feels its own braking
_MOST_HITS = const(2)
_RAD_BRAD = const(10430)  # 65536 / 2 pi


@hot
def take_tare(settings: Ints, state: Ints, leg: int) -> int:
    """Take one tick of the hanging leg's force into its tare; return the tare, Q12 of the own weight."""
    force = state[C_FORCE + leg]
    if state[C_TICK] <= settings[K_TARE_SKIP] + 1:
        state[C_TARE] = force
    else:
        state[C_TARE] += fraction(force - state[C_TARE], settings[K_TARE_IN])
    return state[C_TARE]


@hot
def feel_ground(settings: Ints, state: Ints, leg: int) -> int:
    """Return 1 when the foot of ``leg``, on its way down, has ground under it, else 0.

    That is more than 3 N above the tare for 60 ms, with more than 4 N once in them (on Caramelo; in parts of
    the weight on others). A hind foot that is still fast over its known print needs 9 N. Without load the
    tare follows.
    """
    force = state[C_FORCE + leg] - state[C_TARE]
    least = _TOUCH_Q12
    gain = settings[K_TARE_SLOW]
    if leg >= RR and state[C_SPEED] > settings[K_V_QUICK]:
        least = _FAST_Q12
        gain = settings[K_TARE_FAST]
    if force > least:
        state[C_TOUCHED] += 1
        if force > _PEAK_Q12:
            state[C_PEAK] = 1
    else:
        state[C_TOUCHED] = 0
        state[C_PEAK] = 0
        state[C_TARE] += fraction(force, gain)
    if state[C_TOUCHED] >= settings[K_TOUCH_TICKS] and state[C_PEAK]:
        return 1
    return 0


@hot
def corner_lift(settings: Ints, state: Ints, leg: int) -> int:
    """Return by how much the body's corner over ``leg`` is above its plan, lu: pushed up from below.

    Pitch lowers the front, roll raises the left. Angles limited to +-4096 brad. Largest intermediate
    2 * 32767 * 4096 < 2^29.
    """
    nose_up = saturate(state[C_REF + POSE_PITCH] - state[C_BODY + POSE_PITCH] >> LF_BITS, -4096, 4096)
    left_up = saturate(state[C_BODY + POSE_ROLL] - state[C_REF + POSE_ROLL] >> LF_BITS, -4096, 4096)
    lift = nose_up * settings[K_ARM_X]
    if leg >= RR:
        lift = -lift
    if leg & 1:
        lift += left_up * settings[K_ARM_Y]
    else:
        lift -= left_up * settings[K_ARM_Y]
    return lift // _RAD_BRAD


@hot
def keep_past(state: Ints) -> int:
    """Keep where the foot was wanted in this tick, for the riser; return its place in the ring."""
    at = state[C_PAST_AT] + 1
    if at >= PAST_SIZE:
        at = 0
    state[C_PAST + at] = state[C_POS]
    state[C_PAST_AT] = at
    return at


@hot
def feel_riser(settings: Ints, state: Ints, leg: int) -> int:
    """Return 1 if the moving foot is held up: farther behind its command of 60 ms ago than its speed explains."""
    if state[C_TICK] <= settings[K_HIT_AFTER] or state[C_HITS] >= _MOST_HITS or state[C_CLIPPED]:
        return 0
    at = state[C_PAST_AT] - settings[K_LATE]
    if at < 0:
        at += PAST_SIZE
    behind = state[C_PAST + at] - state[C_SEEN + leg * 3] >> LF_BITS
    way = state[C_TARGET] - state[C_SOURCE] >> LF_BITS
    if way < 0:
        way = -way
    late = way * settings[K_HIT_LAG] // (state[C_MOVE_TICKS] + 1)
    if behind > settings[K_HIT] + late:
        return 1
    return 0
