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
from .runtime import const, hot, ptr32

# Parts of the own weight in Q12; in brackets what that is on Caramelo (21.6 N)
_TOUCH_Q12 = const(569)  # 3 N
_PEAK_Q12 = const(758)  # 4 N
_FAST_Q12 = const(1706)  # 9 N: a foot that still falls fast feels its own braking
_MOST_HITS = const(2)
_RAD_BRAD = const(10430)  # 65536 / 2 pi


@hot
def take_tare(settings, state, leg: int) -> int:
    """Take one tick of the hanging leg's force into its tare; return the tare, Q12 of the own weight."""
    k = ptr32(settings)
    c = ptr32(state)
    force = c[C_FORCE + leg]
    if c[C_TICK] <= k[K_TARE_SKIP] + 1:
        c[C_TARE] = force
    else:
        c[C_TARE] += fraction(force - c[C_TARE], k[K_TARE_IN])
    return c[C_TARE]


@hot
def feel_ground(settings, state, leg: int) -> int:
    """Return 1 when the foot of ``leg``, on its way down, has ground under it, else 0.

    That is more than 3 N above the tare for 60 ms, with more than 4 N once in them (on Caramelo; in parts of
    the weight on others). A hind foot that is still fast over its known print needs 9 N. Without load the
    tare follows.
    """
    k = ptr32(settings)
    c = ptr32(state)
    force = c[C_FORCE + leg] - c[C_TARE]
    least = _TOUCH_Q12
    gain = k[K_TARE_SLOW]
    if leg >= RR and c[C_SPEED] > k[K_V_QUICK]:
        least = _FAST_Q12
        gain = k[K_TARE_FAST]
    if force > least:
        c[C_TOUCHED] += 1
        if force > _PEAK_Q12:
            c[C_PEAK] = 1
    else:
        c[C_TOUCHED] = 0
        c[C_PEAK] = 0
        c[C_TARE] += fraction(force, gain)
    if c[C_TOUCHED] >= k[K_TOUCH_TICKS] and c[C_PEAK]:
        return 1
    return 0


@hot
def corner_lift(settings, state, leg: int) -> int:
    """Return by how much the body's corner over ``leg`` is above its plan, lu: pushed up from below.

    Pitch lowers the front, roll raises the left. Angles limited to +-4096 brad. Largest intermediate
    2 * 32767 * 4096 < 2^29.
    """
    k = ptr32(settings)
    c = ptr32(state)
    nose_up = saturate(c[C_REF + POSE_PITCH] - c[C_BODY + POSE_PITCH] >> LF_BITS, -4096, 4096)
    left_up = saturate(c[C_BODY + POSE_ROLL] - c[C_REF + POSE_ROLL] >> LF_BITS, -4096, 4096)
    lift = nose_up * k[K_ARM_X]
    if leg >= RR:
        lift = -lift
    if leg & 1:
        lift += left_up * k[K_ARM_Y]
    else:
        lift -= left_up * k[K_ARM_Y]
    return lift // _RAD_BRAD


@hot
def keep_past(state) -> int:
    """Keep where the foot was wanted in this tick, for the riser; return its place in the ring."""
    c = ptr32(state)
    at = c[C_PAST_AT] + 1
    if at >= PAST_SIZE:
        at = 0
    c[C_PAST + at] = c[C_POS]
    c[C_PAST_AT] = at
    return at


@hot
def feel_riser(settings, state, leg: int) -> int:
    """Return 1 if the moving foot is held up: farther behind its command of 60 ms ago than its speed explains."""
    k = ptr32(settings)
    c = ptr32(state)
    if c[C_TICK] <= k[K_HIT_AFTER] or c[C_HITS] >= _MOST_HITS or c[C_CLIPPED]:
        return 0
    at = c[C_PAST_AT] - k[K_LATE]
    if at < 0:
        at += PAST_SIZE
    behind = c[C_PAST + at] - c[C_SEEN + leg * 3] >> LF_BITS
    way = c[C_TARGET] - c[C_SOURCE] >> LF_BITS
    if way < 0:
        way = -way
    late = way * k[K_HIT_LAG] // (c[C_MOVE_TICKS] + 1)
    if behind > k[K_HIT] + late:
        return 1
    return 0
