"""The cascade: position -> velocity -> current, entered at the level of the mode; impedance; damping without set-point.

Once a millisecond. The result is S_CURRENT_REF, joint-signed; write_current hands it to the current
step. Every limit that acts sets its LIMIT_* bit in S_LIMITS.
"""

from ..fixed import saturate
from ..runtime import const, hot, ptr32
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
def cascade_reset(cfg, state) -> int:
    """Start bumpless: trajectory at the measured position and rate, no integral, no current. Return 0."""
    k = ptr32(cfg)
    s = ptr32(state)
    rate = saturate(s[S_VELOCITY], -k[K_RATE_MAX], k[K_RATE_MAX])
    position = saturate(s[S_POSITION], -_POSITION_MOST, _POSITION_MOST)
    profile_reset(state, position, rate)
    s[S_TARGET] = position << 8
    s[S_GOAL] = position << 8
    s[S_TARGET_RATE] = 0
    s[S_TARGET_LEFT] = 0
    s[S_HOME_RATE] = 0
    s[S_TARGET_AGE] = k[K_EXTRAPOLATE_TICKS]
    s[S_RATE_REF] = rate
    s[S_CURRENT_REF] = 0
    s[S_ACCEL_FEED] = 0
    s[S_V_INTEGRAL] = 0
    s[S_SEEN_SEQUENCE] = s[S_SEQUENCE]
    return 0


@hot
def cascade_step(cfg, state, io) -> int:
    """Do one tick in S_MODE and return S_CURRENT_REF in cu, joint-signed, within +-S_CURRENT_LIMIT.

    Modes without a set-point of their own (off, damping, calibrating) give 0.
    """
    k = ptr32(cfg)
    s = ptr32(state)
    b = ptr32(io)
    mode = s[S_MODE]
    feed = current_from_wire(b[IO_CURRENT], k[K_CURRENT_Q14])
    if mode == MODE_POSITION:
        follow_position(cfg, state, io)
        return velocity_loop(cfg, state, feed)
    if mode == MODE_VELOCITY:
        follow_velocity(cfg, state, rate_from_wire(b[IO_VELOCITY], k[K_RATE_Q8]))
        return velocity_loop(cfg, state, feed)
    if mode == MODE_HOMING:
        slew_rate(state, s[S_HOME_RATE], k[K_ACCEL])
        s[S_RATE_REF] = s[S_PROFILE_RATE]
        s[S_CURRENT_REF] = 0
        return velocity_loop(cfg, state, 0)
    if mode == MODE_IMPEDANCE:
        return limit_current(cfg, state, guard_position(cfg, state, impedance(cfg, state, io)))
    if mode == MODE_CURRENT:
        return limit_current(cfg, state, guard_position(cfg, state, feed))
    return limit_current(cfg, state, 0)


@hot
def follow_position(cfg, state, io) -> int:
    """Move the trajectory towards the position set-point and return S_RATE_REF from the position loop.

    Position error limited to +-(2^18 - 1) rc, K_POSITION_P 0 .. 4095: products below 2^30.
    """
    k = ptr32(cfg)
    s = ptr32(state)
    rate = _move_target(cfg, state, io)
    change = profile_step(state, s[S_TARGET], rate, k[K_ACCEL], k[K_RATE_MAX])
    _flag_profile(cfg, state, change)
    error = saturate((s[S_PROFILE] >> 8) - s[S_POSITION], -_ERROR_MOST, _ERROR_MOST)
    rate = s[S_PROFILE_RATE] + (error * k[K_POSITION_P] >> 6)
    s[S_RATE_REF] = saturate(rate, -k[K_RATE_MAX], k[K_RATE_MAX])
    feed_acceleration(cfg, state, change)
    return s[S_RATE_REF]


@hot
def glide(state, feed: int) -> int:
    """Move S_TARGET one tick towards S_GOAL, which moves at ``feed``; return the move, rc/256 a tick.

    In S_TARGET_LEFT ticks it is there and as fast: its rate goes there in equal steps, and what is still missing is
    shared out evenly. So a smooth motion sent 200 times a second stays smooth, as if its acceleration were sent too.
    feed and S_TARGET_RATE within +-2^18, goal and target at most 2^21 rc/256 apart, at most 16 ticks left: below 2^23.
    Meets the goal exactly; on the way within 2 rc/256 a tick of exact arithmetic.
    """
    s = ptr32(state)
    left = s[S_TARGET_LEFT]
    if left <= 1:
        s[S_TARGET_LEFT] = 0
        s[S_TARGET_RATE] = feed
        s[S_TARGET] = s[S_GOAL]
        return feed
    rate = s[S_TARGET_RATE] + (feed - s[S_TARGET_RATE]) // left
    missing = s[S_GOAL] + feed * (left - 1) - s[S_TARGET] - (left * (rate + feed) >> 1)
    move = rate + missing // left
    s[S_TARGET_LEFT] = left - 1
    s[S_TARGET_RATE] = rate
    s[S_TARGET] += move
    return move


@hot
def follow_velocity(cfg, state, wanted: int) -> int:
    """Slew S_RATE_REF towards ``wanted``, slowing down in time before a position limit; return S_RATE_REF.

    wanted: rate units within +-2^24. The trajectory starts anew wherever the joint is.
    """
    k = ptr32(cfg)
    s = ptr32(state)
    top = k[K_RATE_MAX]
    if wanted > top or wanted < -top:
        s[S_LIMITS] = s[S_LIMITS] | LIMIT_VELOCITY
        wanted = saturate(wanted, -top, top)
    room = saturate(k[K_POSITION_MAX] - s[S_POSITION], -_POSITION_MOST, _POSITION_MOST)
    if wanted > 0:
        wanted = _slow_down(cfg, state, wanted, room)
    room = saturate(s[S_POSITION] - k[K_POSITION_MIN], -_POSITION_MOST, _POSITION_MOST)
    if wanted < 0:
        wanted = -_slow_down(cfg, state, 0 - wanted, room)
    change = slew_rate(state, wanted, k[K_ACCEL])
    if change == k[K_ACCEL] or change == -k[K_ACCEL]:
        s[S_LIMITS] = s[S_LIMITS] | LIMIT_ACCELERATION
    s[S_PROFILE] = saturate(s[S_POSITION], -_POSITION_MOST, _POSITION_MOST) << 8
    s[S_RATE_REF] = s[S_PROFILE_RATE]
    feed_acceleration(cfg, state, change)
    return s[S_RATE_REF]


@hot
def feed_acceleration(cfg, state, change: int) -> int:
    """Return S_CURRENT_REF: the current that the trajectory's ``change`` of rate needs, smoothed over some four ticks.

    change within +-65535 rate units a tick, K_INERTIA 0 .. 16383 (Q8). Unsmoothed, each correction of the trajectory is
    a blow of up to the acceleration limit. Error 1 cu. Below 2^28.
    """
    k = ptr32(cfg)
    s = ptr32(state)
    fed = s[S_ACCEL_FEED]
    fed += (change * k[K_INERTIA] >> 4) - fed >> 2
    s[S_ACCEL_FEED] = fed
    s[S_CURRENT_REF] = fed + 8 >> 4
    return s[S_CURRENT_REF]


@hot
def velocity_loop(cfg, state, feed_cu: int) -> int:
    """Return S_CURRENT_REF: PI on the rate, plus the feed-forward and the acceleration's share already there.

    Rate error limited to +-(2^17 - 1), K_VELOCITY_P 0 .. 8191 (Q12), K_VELOCITY_I 0 .. 8191 (Q16). The
    integral does not grow while the current is limited on the same side, and stays within the largest
    current. Error at most 2 cu plus the gains'. Products below 2^30.
    """
    k = ptr32(cfg)
    s = ptr32(state)
    error = saturate(s[S_RATE_REF] - s[S_VELOCITY], -_RATE_ERROR_MOST, _RATE_ERROR_MOST)
    integral = s[S_V_INTEGRAL]
    direct = saturate((error * k[K_VELOCITY_P] >> 12) + feed_cu + s[S_CURRENT_REF], -0xFFFFF, 0xFFFFF)
    wanted = direct + (integral >> 12)
    given = limit_current(cfg, state, wanted)
    if given == wanted or (wanted - given ^ error) < 0:
        top = _CURRENT_MOST << 12
        s[S_V_INTEGRAL] = saturate(integral + (error * k[K_VELOCITY_I] >> 4), -top, top)
    return given


@hot
def impedance(cfg, state, io) -> int:
    """Return stiffness x position error + damping x velocity error + feed-forward, in cu.

    Stiffness 1/16 A/turn and damping 1/256 A/(turn/s), each 0 .. 32767. The position error acts up to
    45 deg, larger ones as 45 deg; the sum is limited to 8 A. Error at most 4/4096 A plus the factors'.
    """
    k = ptr32(cfg)
    s = ptr32(state)
    b = ptr32(io)
    wanted = saturate(position_from_wire(b[IO_POSITION], k[K_GEAR_Q8]), k[K_POSITION_MIN], k[K_POSITION_MAX])
    error = saturate(wanted - s[S_POSITION], -0xFFFF, 0xFFFF)
    angle = saturate(error * k[K_TURN18_Q14] >> 14, -_INT16, _INT16)
    current = b[IO_STIFFNESS] * angle >> 10
    slip = rate_from_wire(b[IO_VELOCITY], k[K_RATE_Q8]) - s[S_VELOCITY]
    slip = saturate(slip, -_ERROR_MOST, _ERROR_MOST) * k[K_WIRE_RATE_Q16] >> 16
    current += b[IO_DAMPING] * saturate(slip, -_INT16, _INT16) >> 8
    current = saturate(current + b[IO_CURRENT], -_INT16, _INT16)
    return current_from_wire(current, k[K_CURRENT_Q14])


@hot
def guard_position(cfg, state, current_cu: int) -> int:
    """Return the current, but none that pushes further out beyond a position limit."""
    k = ptr32(cfg)
    s = ptr32(state)
    room = s[S_POSITION] - k[K_POSITION_MIN]
    if current_cu > 0:
        room = k[K_POSITION_MAX] - s[S_POSITION]
    if current_cu == 0 or room > 0:
        return current_cu
    s[S_LIMITS] = s[S_LIMITS] | LIMIT_POSITION
    return 0


@hot
def limit_current(cfg, state, wanted_cu: int) -> int:
    """Return S_CURRENT_REF: ``wanted_cu``, within +-2^21, limited to S_CURRENT_LIMIT and to what the bus bears.

    Driving current falls linearly to 0 from K_UNDER_START down to K_UNDER, braking current (which
    feeds the bus) from K_OVER_START up to K_OVER. Exact but for 1 cu.
    """
    k = ptr32(cfg)
    s = ptr32(state)
    limit = s[S_CURRENT_LIMIT]
    flag = LIMIT_CURRENT
    if s[S_VELOCITY] != 0 and (wanted_cu ^ s[S_VELOCITY]) < 0:
        share = fall_q15(s[S_BUS], k[K_OVER_START], k[K_OVER])
        if share < 0x8000:
            flag = LIMIT_OVER_VOLTAGE
    else:
        share = fall_q15(s[S_BUS], k[K_UNDER_START], k[K_UNDER])
        if share < 0x8000:
            flag = LIMIT_UNDER_VOLTAGE
    limit = limit * share >> 15
    given = saturate(wanted_cu, -limit, limit)
    if given != wanted_cu:
        s[S_LIMITS] = s[S_LIMITS] | flag
    s[S_CURRENT_REF] = given
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
def damping_current(cfg, state) -> int:
    """Return S_CURRENT_REF that only brakes: K_DAMP x rate against the motion, within K_DAMP_CURRENT. No set-point."""
    k = ptr32(cfg)
    s = ptr32(state)
    rate = saturate(s[S_VELOCITY], -_RATE_ERROR_MOST, _RATE_ERROR_MOST)
    top = k[K_DAMP_CURRENT]
    return limit_current(cfg, state, saturate(-(rate * k[K_DAMP] >> 12), -top, top))


@hot
def write_current(foc, cfg, state) -> int:
    """Hand S_CURRENT_REF to the current step, with the signs of the joint and the commutation; d stays 0."""
    block = ptr32(foc)
    k = ptr32(cfg)
    s = ptr32(state)
    current = s[S_CURRENT_REF] * k[K_JOINT_SIGN]
    if block[F_ELEC_GAIN] < 0:
        current = -current
    block[F_D_REF] = 0
    block[F_Q_REF] = current
    return current


@hot
def _move_target(cfg, state, io) -> int:
    """Take a new set-point or go on at its velocity; move S_TARGET and return its rate.

    Between set-points the goal moves on at the velocity feed-forward, for K_EXTRAPOLATE_TICKS at most, and stays there;
    until the first set-point it is where the joint was.
    """
    k = ptr32(cfg)
    s = ptr32(state)
    b = ptr32(io)
    top = k[K_RATE_MAX]
    feed = saturate(rate_from_wire(b[IO_VELOCITY], k[K_RATE_Q8]), -top, top)
    if s[S_SEQUENCE] != s[S_SEEN_SEQUENCE]:
        s[S_SEEN_SEQUENCE] = s[S_SEQUENCE]
        _take_goal(state, position_from_wire(b[IO_POSITION], k[K_GEAR_Q8]))
    elif s[S_TARGET_AGE] < k[K_EXTRAPOLATE_TICKS]:
        s[S_TARGET_AGE] += 1
        s[S_GOAL] += feed
    else:
        feed = 0
    goal = saturate(s[S_GOAL], k[K_POSITION_MIN] << 8, k[K_POSITION_MAX] << 8)
    if goal != s[S_GOAL]:
        s[S_GOAL] = goal
        s[S_TARGET_LEFT] = 0
        s[S_LIMITS] = s[S_LIMITS] | LIMIT_POSITION
        feed = 0
    move = glide(state, feed)
    s[S_TARGET] = saturate(s[S_TARGET], k[K_POSITION_MIN] << 8, k[K_POSITION_MAX] << 8)
    return saturate(move, -top, top)


@hot
def _take_goal(state, goal_rc: int) -> int:
    """Set the goal and glide there in twice the time since the last; what is far away is gone to at once.

    Twice, because a set-point's position comes in steps of 1/65536 turn: of a swing sent at 200 Hz the full motor model
    needs 0.17 A rms; it draws 0.79 A without glide and smoothing, 0.27 A if the glide takes as long as a set-point
    lasts, 0.19 A if twice as long.
    """
    s = ptr32(state)
    apart = goal_rc - (s[S_TARGET] >> 8)
    s[S_TARGET_LEFT] = saturate(s[S_TARGET_AGE] + 1 << 1, 1, _GLIDE_MOST)
    if apart > _GLIDE_APART or apart < -_GLIDE_APART:
        s[S_TARGET_LEFT] = 0
    s[S_GOAL] = goal_rc << 8
    s[S_TARGET_AGE] = 0
    return apart


@hot
def _slow_down(cfg, state, rate: int, room_rc: int) -> int:
    """Return ``rate`` > 0, or less if only that can be braked away over ``room_rc``; 0 without room."""
    k = ptr32(cfg)
    s = ptr32(state)
    if room_rc <= 0:
        most = 0
    else:
        most = braking_rate(saturate(room_rc << 8, 0, 0x1FFFFFFF), k[K_ACCEL], k[K_RATE_MAX])
    if most < rate:
        s[S_LIMITS] = s[S_LIMITS] | LIMIT_POSITION
        return most
    return rate


@hot
def _flag_profile(cfg, state, change: int) -> int:
    """Flag the trajectory limiter: acceleration or speed at its limit."""
    k = ptr32(cfg)
    s = ptr32(state)
    if change >= k[K_ACCEL] or change <= -k[K_ACCEL]:
        s[S_LIMITS] = s[S_LIMITS] | LIMIT_ACCELERATION
    top = k[K_RATE_MAX]
    if s[S_PROFILE_RATE] >= top or s[S_PROFILE_RATE] <= -top:
        s[S_LIMITS] = s[S_LIMITS] | LIMIT_VELOCITY
    return s[S_LIMITS]
