"""The cascade position -> velocity -> current, entered where the mode says; impedance; damping without a set-point.

Once a millisecond. The result is current_reference, joint-signed; write_current hands it to the current step. Every
limit that acts sets its LIMIT_* bit in state.limits.
"""

from ..num.fixed import fall_q15, saturate
from ..runtime import const, hot
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
from .layout import CurrentLoop, JointIo, JointSettings, JointState
from .profile import braking_rate, profile_reset, profile_step, slew_rate

_INT16 = const(32767)
_ERROR_MOST = const(0x3FFFF)
_RATE_ERROR_MOST = const(0x1FFFF)
_CURRENT_MOST = const(12288)
_POSITION_MOST = const(0x1FFFFF)
_GLIDE_MOST = const(16)  # ticks
_GLIDE_APART = const(4096)  # rc; a goal farther away is a step, not a motion: 0.07 rad of a 22:1 joint


@hot
def position_from_wire(position_brad: int, gear_q8: int) -> int:
    """Return rc for a joint angle within +-2^16 brad and a gear up to 63.99 (Q8). Error at most 1/2 rc."""
    return (position_brad * gear_q8 + 512) >> 10


@hot
def rate_from_wire(velocity: int, rate_q8: int) -> int:
    """Return rate units for 1/4096 turn/s, +-32768, and rate_q8 0 .. 32767. Error at most 1/2 unit."""
    return (velocity * rate_q8 + 128) >> 8


@hot
def current_from_wire(current: int, current_q14: int) -> int:
    """Return cu for 1/4096 A, +-32768, and current_q14 0 .. 32767, within +-12288. Error at most 1/2 cu."""
    return saturate((current * current_q14 + 8192) >> 14, -_CURRENT_MOST, _CURRENT_MOST)


@hot
def cascade_reset(settings: JointSettings, state: JointState) -> None:
    """Start bumpless: trajectory at the measured position and rate, no integral, no current."""
    rate = saturate(state.velocity, -settings.rate_max, settings.rate_max)
    position = saturate(state.position, -_POSITION_MOST, _POSITION_MOST)
    profile_reset(state, position, rate)
    state.target = position << 8
    state.goal_position = position << 8
    state.target_rate = 0
    state.target_ticks_left = 0
    state.home_rate = 0
    state.target_age = settings.extrapolate_ticks
    state.rate_reference = rate
    state.current_reference = 0
    state.acceleration_feed = 0
    state.velocity_integral = 0
    state.seen_sequence = state.sequence


@hot
def cascade_step(settings: JointSettings, state: JointState, io: JointIo) -> int:
    """Do one tick in state.mode and return current_reference in cu, joint-signed, within +-current_limit.

    Modes without a set-point of their own (off, damping, commissioning) give 0.
    """
    mode = state.mode
    feed = current_from_wire(io.current, settings.current_q14)
    if mode == MODE_POSITION:
        follow_position(settings, state, io)
        return velocity_loop(settings, state, feed)
    if mode == MODE_VELOCITY:
        follow_velocity(settings, state, rate_from_wire(io.velocity, settings.rate_q8))
        return velocity_loop(settings, state, feed)
    if mode == MODE_HOMING:
        slew_rate(state, state.home_rate, settings.accel)
        state.rate_reference = state.profile_rate
        state.current_reference = 0
        return velocity_loop(settings, state, 0)
    if mode == MODE_IMPEDANCE:
        return limit_current(settings, state, guard_position(settings, state, impedance(settings, state, io)))
    if mode == MODE_CURRENT:
        return limit_current(settings, state, guard_position(settings, state, feed))
    return limit_current(settings, state, 0)


@hot
def follow_position(settings: JointSettings, state: JointState, io: JointIo) -> int:
    """Move the trajectory towards the position set-point and return rate_reference from the position loop.

    Position error limited to +-(2^18 - 1) rc, position_p 0 .. 4095: products below 2^30.
    """
    rate = _move_target(settings, state, io)
    change = profile_step(state, state.target, rate, settings.accel, settings.rate_max)
    _flag_profile(settings, state, change)
    error = saturate((state.profile >> 8) - state.position, -_ERROR_MOST, _ERROR_MOST)
    rate = state.profile_rate + (error * settings.position_p >> 6)
    state.rate_reference = saturate(rate, -settings.rate_max, settings.rate_max)
    feed_acceleration(settings, state, change)
    return state.rate_reference


@hot
def glide(state: JointState, feed: int) -> int:
    """Move state.target one tick towards state.goal_position, which moves at ``feed``; return the move, rc/256 a tick.

    After target_ticks_left ticks it has the goal's position and rate: its rate changes in equal steps, and the distance
    still missing is spread evenly. So a smooth motion sent 200 times a second stays smooth, as if its acceleration were
    sent too. feed and target_rate within +-2^18, goal and target at most 2^21 rc/256 apart, at most 16 ticks left:
    below 2^23. Meets the goal exactly; on the way within 2 rc/256 a tick of exact arithmetic.
    """
    left = state.target_ticks_left
    if left <= 1:
        state.target_ticks_left = 0
        state.target_rate = feed
        state.target = state.goal_position
        return feed
    rate = state.target_rate + (feed - state.target_rate) // left
    missing = state.goal_position + feed * (left - 1) - state.target - (left * (rate + feed) >> 1)
    move = rate + missing // left
    state.target_ticks_left = left - 1
    state.target_rate = rate
    state.target += move
    return move


@hot
def follow_velocity(settings: JointSettings, state: JointState, wanted: int) -> None:
    """Slew rate_reference towards ``wanted``, slowing down in time before a position limit.

    wanted: rate units within +-2^24. The trajectory starts anew wherever the joint is.
    """
    top = settings.rate_max
    if wanted > top or wanted < -top:
        state.limits = state.limits | LIMIT_VELOCITY
        wanted = saturate(wanted, -top, top)
    room = saturate(settings.position_max - state.position, -_POSITION_MOST, _POSITION_MOST)
    if wanted > 0:
        wanted = _slow_down(settings, state, wanted, room)
    room = saturate(state.position - settings.position_min, -_POSITION_MOST, _POSITION_MOST)
    if wanted < 0:
        wanted = -_slow_down(settings, state, 0 - wanted, room)
    change = slew_rate(state, wanted, settings.accel)
    if change == settings.accel or change == -settings.accel:
        state.limits = state.limits | LIMIT_ACCELERATION
    state.profile = saturate(state.position, -_POSITION_MOST, _POSITION_MOST) << 8
    state.rate_reference = state.profile_rate
    feed_acceleration(settings, state, change)


@hot
def feed_acceleration(settings: JointSettings, state: JointState, change: int) -> int:
    """Return current_reference: the current for the trajectory's ``change`` of rate, smoothed over some four ticks.

    change within +-65535 rate units a tick, inertia 0 .. 16383 (Q8). Without smoothing, each correction of the
    trajectory is a jolt of up to the acceleration limit. Error 1 cu. Below 2^28.
    """
    fed = state.acceleration_feed
    fed += (change * settings.inertia >> 4) - fed >> 2
    state.acceleration_feed = fed
    state.current_reference = fed + 8 >> 4
    return state.current_reference


@hot
def velocity_loop(settings: JointSettings, state: JointState, feed_cu: int) -> int:
    """Return current_reference: PI on the rate, plus feed-forward, plus the acceleration's share that it already holds.

    Rate error limited to +-(2^17 - 1), velocity_p 0 .. 8191 (Q12), velocity_i 0 .. 8191 (Q16). The integral does not
    grow while the current is limited on the same side, and stays within the largest current. Error at most 2 cu plus
    the gains'. Products below 2^30.
    """
    error = saturate(state.rate_reference - state.velocity, -_RATE_ERROR_MOST, _RATE_ERROR_MOST)
    integral = state.velocity_integral
    direct = saturate((error * settings.velocity_p >> 12) + feed_cu + state.current_reference, -0xFFFFF, 0xFFFFF)
    wanted = direct + (integral >> 12)
    given = limit_current(settings, state, wanted)
    if given == wanted or (wanted - given ^ error) < 0:
        top = _CURRENT_MOST << 12
        state.velocity_integral = saturate(integral + (error * settings.velocity_i >> 4), -top, top)
    return given


@hot
def impedance(settings: JointSettings, state: JointState, io: JointIo) -> int:
    """Return stiffness x position error + damping x velocity error + feed-forward, in cu.

    Stiffness 1/16 A/turn and damping 1/256 A/(turn/s), each 0 .. 32767. The position error acts up to
    45 deg, larger ones as 45 deg; the sum is limited to 8 A. Error at most 4/4096 A plus the factors'.
    """
    wanted = saturate(position_from_wire(io.position, settings.gear_q8), settings.position_min, settings.position_max)
    error = saturate(wanted - state.position, -0xFFFF, 0xFFFF)
    angle = saturate(error * settings.turn18_q14 >> 14, -_INT16, _INT16)
    current = io.stiffness * angle >> 10
    slip = rate_from_wire(io.velocity, settings.rate_q8) - state.velocity
    slip = saturate(slip, -_ERROR_MOST, _ERROR_MOST) * settings.wire_rate_q16 >> 16
    current += io.damping * saturate(slip, -_INT16, _INT16) >> 8
    current = saturate(current + io.current, -_INT16, _INT16)
    return current_from_wire(current, settings.current_q14)


@hot
def guard_position(settings: JointSettings, state: JointState, current_cu: int) -> int:
    """Return the current, or 0 if it would push the joint further beyond a position limit."""
    room = state.position - settings.position_min
    if current_cu > 0:
        room = settings.position_max - state.position
    if current_cu == 0 or room > 0:
        return current_cu
    state.limits = state.limits | LIMIT_POSITION
    return 0


@hot
def limit_current(settings: JointSettings, state: JointState, wanted_cu: int) -> int:
    """Return current_reference: ``wanted_cu``, within +-2^21, limited to current_limit and to what the supply allows.

    Driving current falls linearly to 0 from under_start down to settings.under, braking current (which feeds the bus)
    from over_start up to settings.over. Exact but for 1 cu.
    """
    limit = state.current_limit
    flag = LIMIT_CURRENT
    if state.velocity != 0 and (wanted_cu ^ state.velocity) < 0:
        share = fall_q15(state.bus, settings.over_start, settings.over)
        if share < 0x8000:
            flag = LIMIT_OVER_VOLTAGE
    else:
        share = fall_q15(state.bus, settings.under_start, settings.under)
        if share < 0x8000:
            flag = LIMIT_UNDER_VOLTAGE
    limit = limit * share >> 15
    given = saturate(wanted_cu, -limit, limit)
    if given != wanted_cu:
        state.limits = state.limits | flag
    state.current_reference = given
    return given


@hot
def damping_current(settings: JointSettings, state: JointState) -> int:
    """Return current_reference that only brakes: damp x rate against the motion, within damp_current. No set-point."""
    rate = saturate(state.velocity, -_RATE_ERROR_MOST, _RATE_ERROR_MOST)
    top = settings.damp_current
    return limit_current(settings, state, saturate(-(rate * settings.damp >> 12), -top, top))


@hot
def write_current(loop: CurrentLoop, settings: JointSettings, state: JointState) -> int:
    """Hand current_reference to the current step, with the signs of the joint and the commutation; d stays 0."""
    current = state.current_reference * settings.joint_sign
    if loop.electrical_gain < 0:
        current = -current
    loop.reference_d = 0
    loop.reference_q = current
    return current


@hot
def _move_target(settings: JointSettings, state: JointState, io: JointIo) -> int:
    """Take a new set-point, or move on at the velocity of the last; move state.target and return its rate.

    Between set-points the goal moves on at the velocity feed-forward, for extrapolate_ticks at most, and then stays
    there; until the first set-point it is where the joint was.
    """
    top = settings.rate_max
    feed = saturate(rate_from_wire(io.velocity, settings.rate_q8), -top, top)
    if state.sequence != state.seen_sequence:
        state.seen_sequence = state.sequence
        _take_goal(state, position_from_wire(io.position, settings.gear_q8))
    elif state.target_age < settings.extrapolate_ticks:
        state.target_age += 1
        state.goal_position += feed
    else:
        feed = 0
    goal = saturate(state.goal_position, settings.position_min << 8, settings.position_max << 8)
    if goal != state.goal_position:
        state.goal_position = goal
        state.target_ticks_left = 0
        state.limits = state.limits | LIMIT_POSITION
        feed = 0
    move = glide(state, feed)
    state.target = saturate(state.target, settings.position_min << 8, settings.position_max << 8)
    return saturate(move, -top, top)


@hot
def _take_goal(state: JointState, goal_rc: int) -> None:
    """Set the goal; glide there in twice the time since the last one, or go there at once if it is far away.

    Twice, because a set-point's position comes in steps of 1/65536 turn. A swing sent at 200 Hz needs 0.17 A rms in the
    full motor model; it draws 0.79 A without glide and smoothing, 0.27 A if the glide takes as long as a set-point
    lasts, 0.19 A if twice as long.
    """
    apart = goal_rc - (state.target >> 8)
    state.target_ticks_left = saturate(state.target_age + 1 << 1, 1, _GLIDE_MOST)
    if apart > _GLIDE_APART or apart < -_GLIDE_APART:
        state.target_ticks_left = 0
    state.goal_position = goal_rc << 8
    state.target_age = 0


@hot
def _slow_down(settings: JointSettings, state: JointState, rate: int, room_rc: int) -> int:
    """Return ``rate`` > 0, or less if only that can be braked away over ``room_rc``; 0 without room."""
    if room_rc <= 0:
        most = 0
    else:
        most = braking_rate(saturate(room_rc << 8, 0, 0x1FFFFFFF), settings.accel, settings.rate_max)
    if most < rate:
        state.limits = state.limits | LIMIT_POSITION
        return most
    return rate


@hot
def _flag_profile(settings: JointSettings, state: JointState, change: int) -> None:
    """Flag the trajectory limiter: acceleration or speed at its limit."""
    if change >= settings.accel or change <= -settings.accel:
        state.limits = state.limits | LIMIT_ACCELERATION
    top = settings.rate_max
    if state.profile_rate >= top or state.profile_rate <= -top:
        state.limits = state.limits | LIMIT_VELOCITY
