"""The cascade: position -> velocity -> current, entered at the level of the mode; impedance; damping without set-point.

Once a millisecond. The result is S_CURRENT_REF, joint-signed; write_current hands it to the current
step. Every limit that acts sets its LIMIT_* bit in S_LIMITS.
"""

from ..fixed import saturate
from ..runtime import Ints, const, hot
from ..wire.names import (
    LIMIT_ACCELERATION,
    LIMIT_CURRENT,
    LIMIT_OVER_VOLTAGE,
    LIMIT_POSITION,
    LIMIT_UNDER_VOLTAGE,
    LIMIT_VELOCITY,
    MODE_CURRENT,
    MODE_HOMING,
    MODE_IMPEDANCE,
    MODE_POSITION,
    MODE_VELOCITY,
)
from .layout import (
    F_D_REF,
    F_ELEC_GAIN,
    F_Q_REF,
    IO_CURRENT,
    IO_DAMPING,
    IO_POSITION,
    IO_STIFFNESS,
    IO_VELOCITY,
    K_ACCEL,
    K_CURRENT_Q14,
    K_DAMP,
    K_DAMP_CURRENT,
    K_EXTRAPOLATE_TICKS,
    K_GEAR_Q8,
    K_INERTIA,
    K_JOINT_SIGN,
    K_OVER,
    K_OVER_START,
    K_POSITION_MAX,
    K_POSITION_MIN,
    K_POSITION_P,
    K_RATE_MAX,
    K_RATE_Q8,
    K_TURN18_Q14,
    K_UNDER,
    K_UNDER_START,
    K_VELOCITY_I,
    K_VELOCITY_P,
    K_WIRE_RATE_Q16,
    S_ACCEL_FEED,
    S_BUS,
    S_CURRENT_LIMIT,
    S_CURRENT_REF,
    S_GOAL,
    S_HOME_RATE,
    S_LIMITS,
    S_MODE,
    S_POSITION,
    S_PROFILE,
    S_PROFILE_RATE,
    S_RATE_REF,
    S_SEEN_SEQUENCE,
    S_SEQUENCE,
    S_TARGET,
    S_TARGET_AGE,
    S_TARGET_LEFT,
    S_TARGET_RATE,
    S_V_INTEGRAL,
    S_VELOCITY,
)
from .profile import braking_rate, profile_reset, profile_step, slew_rate

_INT16 = const(32767)
_ERROR_MOST = const(0x3FFFF)
_RATE_ERROR_MOST = const(0x1FFFF)
_CURRENT_MOST = const(12288)
_POSITION_MOST = const(0x1FFFFF)
_GLIDE_MOST = const(16)  # ticks
_GLIDE_APART = const(4096)  # rc; farther is a step, not a motion: 0.07 rad of a 22:1 joint


@hot
def position_from_wire(position_brad: int, gear_q8: int) -> int:
    """Return rc for a joint angle within +-2^16 brad and a gear up to 63.99 (Q8). Error at most 1/2 rc."""
    return (position_brad * gear_q8 + 512) >> 10


@hot
def rate_from_wire(velocity: int, rate_q8: int) -> int:
    """Return rate units for 1/4096 turn/s, +-32768, and K_RATE_Q8 0 .. 32767. Error at most 1/2 unit."""
    return (velocity * rate_q8 + 128) >> 8


@hot
def current_from_wire(current: int, current_q14: int) -> int:
    """Return cu for 1/4096 A, +-32768, and K_CURRENT_Q14 0 .. 32767, within +-12288. Error at most 1/2 cu."""
    return saturate((current * current_q14 + 8192) >> 14, -_CURRENT_MOST, _CURRENT_MOST)


@hot
def cascade_reset(cfg: Ints, state: Ints) -> int:
    """Start bumpless: trajectory at the measured position and rate, no integral, no current. Return 0."""
    rate = saturate(state[S_VELOCITY], -cfg[K_RATE_MAX], cfg[K_RATE_MAX])
    position = saturate(state[S_POSITION], -_POSITION_MOST, _POSITION_MOST)
    profile_reset(state, position, rate)
    state[S_TARGET] = position << 8
    state[S_GOAL] = position << 8
    state[S_TARGET_RATE] = 0
    state[S_TARGET_LEFT] = 0
    state[S_HOME_RATE] = 0
    state[S_TARGET_AGE] = cfg[K_EXTRAPOLATE_TICKS]
    state[S_RATE_REF] = rate
    state[S_CURRENT_REF] = 0
    state[S_ACCEL_FEED] = 0
    state[S_V_INTEGRAL] = 0
    state[S_SEEN_SEQUENCE] = state[S_SEQUENCE]
    return 0


@hot
def cascade_step(cfg: Ints, state: Ints, io: Ints) -> int:
    """Do one tick in S_MODE and return S_CURRENT_REF in cu, joint-signed, within +-S_CURRENT_LIMIT.

    Modes without a set-point of their own (off, damping, calibrating) give 0.
    """
    mode = state[S_MODE]
    feed = current_from_wire(io[IO_CURRENT], cfg[K_CURRENT_Q14])
    if mode == MODE_POSITION:
        follow_position(cfg, state, io)
        return velocity_loop(cfg, state, feed)
    if mode == MODE_VELOCITY:
        follow_velocity(cfg, state, rate_from_wire(io[IO_VELOCITY], cfg[K_RATE_Q8]))
        return velocity_loop(cfg, state, feed)
    if mode == MODE_HOMING:
        slew_rate(state, state[S_HOME_RATE], cfg[K_ACCEL])
        state[S_RATE_REF] = state[S_PROFILE_RATE]
        state[S_CURRENT_REF] = 0
        return velocity_loop(cfg, state, 0)
    if mode == MODE_IMPEDANCE:
        return limit_current(cfg, state, guard_position(cfg, state, impedance(cfg, state, io)))
    if mode == MODE_CURRENT:
        return limit_current(cfg, state, guard_position(cfg, state, feed))
    return limit_current(cfg, state, 0)


@hot
def follow_position(cfg: Ints, state: Ints, io) -> int:
    """Move the trajectory towards the position set-point and return S_RATE_REF from the position loop.

    Position error limited to +-(2^18 - 1) rc, K_POSITION_P 0 .. 4095: products below 2^30.
    """
    rate = _move_target(cfg, state, io)
    change = profile_step(state, state[S_TARGET], rate, cfg[K_ACCEL], cfg[K_RATE_MAX])
    _flag_profile(cfg, state, change)
    error = saturate((state[S_PROFILE] >> 8) - state[S_POSITION], -_ERROR_MOST, _ERROR_MOST)
    rate = state[S_PROFILE_RATE] + (error * cfg[K_POSITION_P] >> 6)
    state[S_RATE_REF] = saturate(rate, -cfg[K_RATE_MAX], cfg[K_RATE_MAX])
    feed_acceleration(cfg, state, change)
    return state[S_RATE_REF]


@hot
def glide(state: Ints, feed: int) -> int:
    """Move S_TARGET one tick towards S_GOAL, which moves at ``feed``; return the move, rc/256 a tick.

    In S_TARGET_LEFT ticks it is there and as fast: its rate goes there in equal steps, and what is still missing is
    shared out evenly. So a smooth motion sent 200 times a second stays smooth, as if its acceleration were sent too.
    feed and S_TARGET_RATE within +-2^18, goal and target at most 2^21 rc/256 apart, at most 16 ticks left: below 2^23.
    Meets the goal exactly; on the way within 2 rc/256 a tick of exact arithmetic.
    """
    left = state[S_TARGET_LEFT]
    if left <= 1:
        state[S_TARGET_LEFT] = 0
        state[S_TARGET_RATE] = feed
        state[S_TARGET] = state[S_GOAL]
        return feed
    rate = state[S_TARGET_RATE] + (feed - state[S_TARGET_RATE]) // left
    missing = state[S_GOAL] + feed * (left - 1) - state[S_TARGET] - (left * (rate + feed) >> 1)
    move = rate + missing // left
    state[S_TARGET_LEFT] = left - 1
    state[S_TARGET_RATE] = rate
    state[S_TARGET] += move
    return move


@hot
def follow_velocity(cfg: Ints, state: Ints, wanted: int) -> int:
    """Slew S_RATE_REF towards ``wanted``, slowing down in time before a position limit; return S_RATE_REF.

    wanted: rate units within +-2^24. The trajectory starts anew wherever the joint is.
    """
    top = cfg[K_RATE_MAX]
    if wanted > top or wanted < -top:
        state[S_LIMITS] = state[S_LIMITS] | LIMIT_VELOCITY
        wanted = saturate(wanted, -top, top)
    room = saturate(cfg[K_POSITION_MAX] - state[S_POSITION], -_POSITION_MOST, _POSITION_MOST)
    if wanted > 0:
        wanted = _slow_down(cfg, state, wanted, room)
    room = saturate(state[S_POSITION] - cfg[K_POSITION_MIN], -_POSITION_MOST, _POSITION_MOST)
    if wanted < 0:
        wanted = -_slow_down(cfg, state, 0 - wanted, room)
    change = slew_rate(state, wanted, cfg[K_ACCEL])
    if change == cfg[K_ACCEL] or change == -cfg[K_ACCEL]:
        state[S_LIMITS] = state[S_LIMITS] | LIMIT_ACCELERATION
    state[S_PROFILE] = saturate(state[S_POSITION], -_POSITION_MOST, _POSITION_MOST) << 8
    state[S_RATE_REF] = state[S_PROFILE_RATE]
    feed_acceleration(cfg, state, change)
    return state[S_RATE_REF]


@hot
def feed_acceleration(cfg: Ints, state: Ints, change: int) -> int:
    """Return S_CURRENT_REF: the current that the trajectory's ``change`` of rate needs, smoothed over some four ticks.

    change within +-65535 rate units a tick, K_INERTIA 0 .. 16383 (Q8). Unsmoothed, each correction of the trajectory is
    a blow of up to the acceleration limit. Error 1 cu. Below 2^28.
    """
    fed = state[S_ACCEL_FEED]
    fed += (change * cfg[K_INERTIA] >> 4) - fed >> 2
    state[S_ACCEL_FEED] = fed
    state[S_CURRENT_REF] = fed + 8 >> 4
    return state[S_CURRENT_REF]


@hot
def velocity_loop(cfg: Ints, state: Ints, feed_cu: int) -> int:
    """Return S_CURRENT_REF: PI on the rate, plus the feed-forward and the acceleration's share already there.

    Rate error limited to +-(2^17 - 1), K_VELOCITY_P 0 .. 8191 (Q12), K_VELOCITY_I 0 .. 8191 (Q16). The
    integral does not grow while the current is limited on the same side, and stays within the largest
    current. Error at most 2 cu plus the gains'. Products below 2^30.
    """
    error = saturate(state[S_RATE_REF] - state[S_VELOCITY], -_RATE_ERROR_MOST, _RATE_ERROR_MOST)
    integral = state[S_V_INTEGRAL]
    direct = saturate((error * cfg[K_VELOCITY_P] >> 12) + feed_cu + state[S_CURRENT_REF], -0xFFFFF, 0xFFFFF)
    wanted = direct + (integral >> 12)
    given = limit_current(cfg, state, wanted)
    if given == wanted or (wanted - given ^ error) < 0:
        top = _CURRENT_MOST << 12
        state[S_V_INTEGRAL] = saturate(integral + (error * cfg[K_VELOCITY_I] >> 4), -top, top)
    return given


@hot
def impedance(cfg: Ints, state: Ints, io: Ints) -> int:
    """Return stiffness x position error + damping x velocity error + feed-forward, in cu.

    Stiffness 1/16 A/turn and damping 1/256 A/(turn/s), each 0 .. 32767. The position error acts up to
    45 deg, larger ones as 45 deg; the sum is limited to 8 A. Error at most 4/4096 A plus the factors'.
    """
    wanted = saturate(position_from_wire(io[IO_POSITION], cfg[K_GEAR_Q8]), cfg[K_POSITION_MIN], cfg[K_POSITION_MAX])
    error = saturate(wanted - state[S_POSITION], -0xFFFF, 0xFFFF)
    angle = saturate(error * cfg[K_TURN18_Q14] >> 14, -_INT16, _INT16)
    current = io[IO_STIFFNESS] * angle >> 10
    slip = rate_from_wire(io[IO_VELOCITY], cfg[K_RATE_Q8]) - state[S_VELOCITY]
    slip = saturate(slip, -_ERROR_MOST, _ERROR_MOST) * cfg[K_WIRE_RATE_Q16] >> 16
    current += io[IO_DAMPING] * saturate(slip, -_INT16, _INT16) >> 8
    current = saturate(current + io[IO_CURRENT], -_INT16, _INT16)
    return current_from_wire(current, cfg[K_CURRENT_Q14])


@hot
def guard_position(cfg: Ints, state: Ints, current_cu: int) -> int:
    """Return the current, but none that pushes further out beyond a position limit."""
    room = state[S_POSITION] - cfg[K_POSITION_MIN]
    if current_cu > 0:
        room = cfg[K_POSITION_MAX] - state[S_POSITION]
    if current_cu == 0 or room > 0:
        return current_cu
    state[S_LIMITS] = state[S_LIMITS] | LIMIT_POSITION
    return 0


@hot
def limit_current(cfg: Ints, state: Ints, wanted_cu: int) -> int:
    """Return S_CURRENT_REF: ``wanted_cu``, within +-2^21, limited to S_CURRENT_LIMIT and to what the bus bears.

    Driving current falls linearly to 0 from K_UNDER_START down to K_UNDER, braking current (which
    feeds the bus) from K_OVER_START up to K_OVER. Exact but for 1 cu.
    """
    limit = state[S_CURRENT_LIMIT]
    flag = LIMIT_CURRENT
    if state[S_VELOCITY] != 0 and (wanted_cu ^ state[S_VELOCITY]) < 0:
        share = fall_q15(state[S_BUS], cfg[K_OVER_START], cfg[K_OVER])
        if share < 0x8000:
            flag = LIMIT_OVER_VOLTAGE
    else:
        share = fall_q15(state[S_BUS], cfg[K_UNDER_START], cfg[K_UNDER])
        if share < 0x8000:
            flag = LIMIT_UNDER_VOLTAGE
    limit = limit * share >> 15
    given = saturate(wanted_cu, -limit, limit)
    if given != wanted_cu:
        state[S_LIMITS] = state[S_LIMITS] | flag
    state[S_CURRENT_REF] = given
    return given


@hot
def fall_q15(value: int, start: int, end: int) -> int:
    """Return 32768 at ``start`` and before, 0 at ``end`` and beyond, linear between; falling or rising.

    All within +-32767, start and end at most that far apart. start = end is a step: 0 from there on. Error at most 1.
    """
    span = end - start
    left = end - value
    if span < 0:
        span = -span
        left = -left
    if left <= 0:
        return 0
    if left >= span:
        return 0x8000
    return (left << 15) // span


@hot
def damping_current(cfg: Ints, state: Ints) -> int:
    """Return S_CURRENT_REF that only brakes: K_DAMP x rate against the motion, within K_DAMP_CURRENT. No set-point."""
    rate = saturate(state[S_VELOCITY], -_RATE_ERROR_MOST, _RATE_ERROR_MOST)
    top = cfg[K_DAMP_CURRENT]
    return limit_current(cfg, state, saturate(-(rate * cfg[K_DAMP] >> 12), -top, top))


@hot
def write_current(foc: Ints, cfg: Ints, state: Ints) -> int:
    """Hand S_CURRENT_REF to the current step, with the signs of the joint and the commutation; d stays 0."""
    current = state[S_CURRENT_REF] * cfg[K_JOINT_SIGN]
    if foc[F_ELEC_GAIN] < 0:
        current = -current
    foc[F_D_REF] = 0
    foc[F_Q_REF] = current
    return current


@hot
def _move_target(cfg: Ints, state: Ints, io: Ints) -> int:
    """Take a new set-point or go on at its velocity; move S_TARGET and return its rate.

    Between set-points the goal moves on at the velocity feed-forward, for K_EXTRAPOLATE_TICKS at most, and stays there;
    until the first set-point it is where the joint was.
    """
    top = cfg[K_RATE_MAX]
    feed = saturate(rate_from_wire(io[IO_VELOCITY], cfg[K_RATE_Q8]), -top, top)
    if state[S_SEQUENCE] != state[S_SEEN_SEQUENCE]:
        state[S_SEEN_SEQUENCE] = state[S_SEQUENCE]
        _take_goal(state, position_from_wire(io[IO_POSITION], cfg[K_GEAR_Q8]))
    elif state[S_TARGET_AGE] < cfg[K_EXTRAPOLATE_TICKS]:
        state[S_TARGET_AGE] += 1
        state[S_GOAL] += feed
    else:
        feed = 0
    goal = saturate(state[S_GOAL], cfg[K_POSITION_MIN] << 8, cfg[K_POSITION_MAX] << 8)
    if goal != state[S_GOAL]:
        state[S_GOAL] = goal
        state[S_TARGET_LEFT] = 0
        state[S_LIMITS] = state[S_LIMITS] | LIMIT_POSITION
        feed = 0
    move = glide(state, feed)
    state[S_TARGET] = saturate(state[S_TARGET], cfg[K_POSITION_MIN] << 8, cfg[K_POSITION_MAX] << 8)
    return saturate(move, -top, top)


@hot
def _take_goal(state: Ints, goal_rc: int) -> int:
    """Set the goal and glide there in twice the time since the last; what is far away is gone to at once.

    Twice, because a set-point's position comes in steps of 1/65536 turn: of a swing sent at 200 Hz the full motor model
    needs 0.17 A rms; it draws 0.79 A without glide and smoothing, 0.27 A if the glide takes as long as a set-point
    lasts, 0.19 A if twice as long.
    """
    apart = goal_rc - (state[S_TARGET] >> 8)
    state[S_TARGET_LEFT] = saturate(state[S_TARGET_AGE] + 1 << 1, 1, _GLIDE_MOST)
    if apart > _GLIDE_APART or apart < -_GLIDE_APART:
        state[S_TARGET_LEFT] = 0
    state[S_GOAL] = goal_rc << 8
    state[S_TARGET_AGE] = 0
    return apart


@hot
def _slow_down(cfg: Ints, state: Ints, rate: int, room_rc: int) -> int:
    """Return ``rate`` > 0, or less if only that can be braked away over ``room_rc``; 0 without room."""
    if room_rc <= 0:
        most = 0
    else:
        most = braking_rate(saturate(room_rc << 8, 0, 0x1FFFFFFF), cfg[K_ACCEL], cfg[K_RATE_MAX])
    if most < rate:
        state[S_LIMITS] = state[S_LIMITS] | LIMIT_POSITION
        return most
    return rate


@hot
def _flag_profile(cfg: Ints, state: Ints, change: int) -> int:
    """Flag the trajectory limiter: acceleration or speed at its limit."""
    if change >= cfg[K_ACCEL] or change <= -cfg[K_ACCEL]:
        state[S_LIMITS] = state[S_LIMITS] | LIMIT_ACCELERATION
    top = cfg[K_RATE_MAX]
    if state[S_PROFILE_RATE] >= top or state[S_PROFILE_RATE] <= -top:
        state[S_LIMITS] = state[S_LIMITS] | LIMIT_VELOCITY
    return state[S_LIMITS]
