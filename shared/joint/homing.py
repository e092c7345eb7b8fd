"""Homing a joint without an absolute encoder: drive slowly against the stop, then take the stop's known position.

Tick by tick in mode HOMING. It only asks for a rate and lowers the current limit; the cascade does
the rest. The rotor's angle at the stop must fit the stop's position, or homing is refused as ambiguous.
"""

from ..runtime import hot, ptr32
from .encoder import home_at
from .layout import (
    HOME_AMBIGUOUS,
    HOME_DONE,
    HOME_IDLE,
    HOME_NO_STOP,
    HOME_SEEKING,
    K_HOME_CURRENT,
    K_HOME_LIMIT_TICKS,
    K_HOME_RATE,
    K_HOME_TICKS,
    K_STALL_RATE,
    K_STOP,
    S_CURRENT_LIMIT,
    S_CURRENT_REF,
    S_HOME_RATE,
    S_HOME_RESULT,
    S_HOME_STILL,
    S_HOME_TICKS,
    S_HOMED,
    S_VELOCITY,
)


@hot
def homing_start(state) -> int:
    """Begin to look for the stop: the joint counts as not homed from now on. Return HOME_SEEKING."""
    s = ptr32(state)
    s[S_HOMED] = 0
    s[S_HOME_TICKS] = 0
    s[S_HOME_STILL] = 0
    s[S_HOME_RESULT] = HOME_SEEKING
    return HOME_SEEKING


@hot
def homing_stop(state) -> int:
    """Give up looking (torque is gone or the mode changed): a search under way ends as HOME_IDLE. Return it."""
    s = ptr32(state)
    if s[S_HOME_RESULT] == HOME_SEEKING:
        s[S_HOME_RESULT] = HOME_IDLE
    return s[S_HOME_RESULT]


@hot
def homing_step(cfg, state) -> int:
    """Watch for the stop before each tick of the cascade; return S_HOME_RATE, the rate to ask for, 0 when over.

    At the stop: slower than K_STALL_RATE with 3/4 of K_HOME_CURRENT for K_HOME_TICKS. Then
    S_HOME_RESULT is HOME_DONE or HOME_AMBIGUOUS; without a stop in K_HOME_LIMIT_TICKS it is HOME_NO_STOP.
    """
    k = ptr32(cfg)
    s = ptr32(state)
    s[S_HOME_RATE] = 0
    if s[S_HOME_RESULT] != HOME_SEEKING:
        return 0
    if s[S_CURRENT_LIMIT] > k[K_HOME_CURRENT]:
        s[S_CURRENT_LIMIT] = k[K_HOME_CURRENT]
    s[S_HOME_TICKS] += 1
    if s[S_HOME_TICKS] > k[K_HOME_LIMIT_TICKS]:
        s[S_HOME_RESULT] = HOME_NO_STOP
        return 0
    s[S_HOME_STILL] += 1
    if _pushes_at_rest(cfg, state) == 0:
        s[S_HOME_STILL] = 0
    if s[S_HOME_STILL] < k[K_HOME_TICKS]:
        s[S_HOME_RATE] = k[K_HOME_RATE]
        return s[S_HOME_RATE]
    s[S_HOME_RESULT] = HOME_AMBIGUOUS
    if home_at(cfg, state, k[K_STOP]):
        s[S_HOME_RESULT] = HOME_DONE
    return 0


@hot
def _pushes_at_rest(cfg, state) -> int:
    k = ptr32(cfg)
    s = ptr32(state)
    rate = s[S_VELOCITY]
    if rate > k[K_STALL_RATE] or rate < -k[K_STALL_RATE]:
        return 0
    push = s[S_CURRENT_REF]
    if k[K_HOME_RATE] < 0:
        push = -push
    if push < k[K_HOME_CURRENT] - (k[K_HOME_CURRENT] >> 2):
        return 0
    return 1
