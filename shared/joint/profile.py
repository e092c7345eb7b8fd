"""The trajectory limiter: a position follows a target, which may move, within limits of speed and acceleration.

Each tick the wanted speed is the target's own plus the speed that can still be braked away over the distance left,
sqrt(2 a d), no more than the limit; the speed changes towards it by at most the acceleration.
"""

from ..num.fixed import isqrt, saturate
from ..runtime import const, hot
from .layout import JointState

_DISTANCE_MOST = const(0x1FFFFFFF)  # rc/256


@hot
def braking_rate(distance_rc256: int, accel: int, rate_max: int) -> int:
    """Return the rate from which ``accel`` per tick stops within the distance, at most rate_max.

    distance 0 .. 2^29 - 1 rc/256, accel 1 .. 65535 and rate_max 1 .. 2^18 - 1 in rate units. In whole
    ticks a rate v needs v (v + a) / 2a: v = sqrt(a^2/4 + 2 a d) - a/2. Rounded down to 1/16 rc, so at
    most 48 rate units short. A distance that is long enough is not multiplied; squares below 2^29.
    """
    if accel < 1:
        return 0
    d = distance_rc256 >> 8
    fraction = distance_rc256 & 255
    half = accel >> 1
    enough = (rate_max + half >> 4) + 1
    enough = (enough * enough >> 1) // accel + 1
    if d >= enough:
        return rate_max
    square = (d * accel << 1) + (accel * fraction >> 7) + (half * half >> 8)
    rate = (isqrt(square) << 4) - half
    if rate < 1 and distance_rc256 > 0:
        return 1
    if rate < 0:
        return 0
    if rate > rate_max:
        return rate_max
    return rate


@hot
def profile_reset(state: JointState, position_rc: int, rate: int) -> None:
    """Start at a position within +-2^21 rc with a rate."""
    state.profile = position_rc << 8
    state.profile_rate = rate


@hot
def profile_step(state: JointState, target_rc256: int, target_rate: int, accel: int, rate_max: int) -> int:
    """Advance state.profile and profile_rate one tick towards the target; return the change of rate.

    target_rc256 within +-2^29 rc/256, where the target will be after this tick, target_rate its own
    rate within +-rate_max; accel, rate_max as braking_rate. The result is the acceleration used, within
    +-accel. The target is met exactly when it can be reached by this tick's move and held by the
    next, each a change of at most ``accel``; profile_rate is then already the target's.
    """
    rate = state.profile_rate
    left = target_rc256 - state.profile
    change = left - rate
    follow = target_rate - left
    near = saturate(left, -rate_max, rate_max) == left
    if near and change <= accel and change >= -accel and follow <= accel and follow >= -accel:
        state.profile = target_rc256
        state.profile_rate = target_rate
        return saturate(target_rate - rate, -accel, accel)
    ahead = left - target_rate
    if ahead >= 0:
        wanted = target_rate + braking_rate(saturate(ahead, 0, _DISTANCE_MOST), accel, rate_max)
    else:
        wanted = target_rate - braking_rate(saturate(-ahead, 0, _DISTANCE_MOST), accel, rate_max)
    wanted = saturate(wanted, -rate_max, rate_max)
    change = saturate(wanted - rate, -accel, accel)
    state.profile_rate = rate + change
    state.profile += rate + change
    return change


@hot
def slew_rate(state: JointState, wanted: int, accel: int) -> int:
    """Move profile_rate towards ``wanted`` by at most ``accel``; return the change. All within +-2^19."""
    change = saturate(wanted - state.profile_rate, 0 - accel, accel)
    state.profile_rate += change
    return change
