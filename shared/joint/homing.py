"""Homing a joint without an absolute encoder: drive slowly against the stop, then take the stop's known position.

Tick by tick in mode HOMING. It only asks for a rate and lowers the current limit; the cascade does
the rest. The rotor's angle at the stop must fit the stop's position, or homing is refused as ambiguous.
"""

from ..runtime import Ints, hot
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
def homing_start(state: Ints) -> int:
    """Begin to look for the stop: the joint counts as not homed from now on. Return HOME_SEEKING."""
    state[S_HOMED] = 0
    state[S_HOME_TICKS] = 0
    state[S_HOME_STILL] = 0
    state[S_HOME_RESULT] = HOME_SEEKING
    return HOME_SEEKING


@hot
def homing_stop(state: Ints) -> int:
    """Give up looking (torque is gone or the mode changed): a search under way ends as HOME_IDLE. Return it."""
    if state[S_HOME_RESULT] == HOME_SEEKING:
        state[S_HOME_RESULT] = HOME_IDLE
    return state[S_HOME_RESULT]


@hot
def homing_step(cfg: Ints, state: Ints) -> int:
    """Watch for the stop before each tick of the cascade; return S_HOME_RATE, the rate to ask for, 0 when over.

    At the stop: slower than K_STALL_RATE with 3/4 of K_HOME_CURRENT for K_HOME_TICKS. Then
    S_HOME_RESULT is HOME_DONE or HOME_AMBIGUOUS; without a stop in K_HOME_LIMIT_TICKS it is HOME_NO_STOP.
    """
    state[S_HOME_RATE] = 0
    if state[S_HOME_RESULT] != HOME_SEEKING:
        return 0
    if state[S_CURRENT_LIMIT] > cfg[K_HOME_CURRENT]:
        state[S_CURRENT_LIMIT] = cfg[K_HOME_CURRENT]
    state[S_HOME_TICKS] += 1
    if state[S_HOME_TICKS] > cfg[K_HOME_LIMIT_TICKS]:
        state[S_HOME_RESULT] = HOME_NO_STOP
        return 0
    state[S_HOME_STILL] += 1
    if _pushes_at_rest(cfg, state) == 0:
        state[S_HOME_STILL] = 0
    if state[S_HOME_STILL] < cfg[K_HOME_TICKS]:
        state[S_HOME_RATE] = cfg[K_HOME_RATE]
        return state[S_HOME_RATE]
    state[S_HOME_RESULT] = HOME_AMBIGUOUS
    if home_at(cfg, state, cfg[K_STOP]):
        state[S_HOME_RESULT] = HOME_DONE
    return 0


@hot
def _pushes_at_rest(cfg: Ints, state: Ints) -> int:
    rate = state[S_VELOCITY]
    if rate > cfg[K_STALL_RATE] or rate < -cfg[K_STALL_RATE]:
        return 0
    push = state[S_CURRENT_REF]
    if cfg[K_HOME_RATE] < 0:
        push = -push
    if push < cfg[K_HOME_CURRENT] - (cfg[K_HOME_CURRENT] >> 2):
        return 0
    return 1
