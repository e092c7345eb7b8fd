"""The encoders of a joint: turns counted without loss, speed by a tracking loop, homing, disagreement of the encoders.

The rotor angle is kept as whole turns and a fraction, so nothing is lost in any number of turns up to +-(2^30 - 2).
state.position is the same, joint-signed, from the joint's zero, within +-2^29 rc.
"""

from ..num.fixed import saturate
from ..runtime import const, hot
from .layout import CurrentLoop, JointIo, JointSettings, JointState

_TURNS_MOST = const(0x3FFFFFFE)
_TURNS_IN_POSITION = const(32766)
_POSITION_MOST = const(0x1FFFFFFF)
_LAG_MOST = const(0x3FFFF)
_RATE_MOST = const(0x7FFFF)


@hot
def wrap_count(difference: int) -> int:
    """Return a difference of two 14-bit counts wrapped to -8192 .. 8191; any within +-2^29. Exact."""
    return ((difference + 8192) & 16383) - 8192


@hot
def position_of(turns: int, fraction: int, zero: int, sign: int) -> int:
    """Return the joint-signed position in rc of a rotor at ``turns`` and ``fraction``, seen from ``zero``.

    Exact while |turns| <= 32766; beyond, the result stays at +-(2^29 - 1), while turns and
    fraction go on counting. fraction, zero: 0 .. 16383; sign +-1.
    """
    if turns > _TURNS_IN_POSITION:
        return _POSITION_MOST * sign
    if turns < -_TURNS_IN_POSITION:
        return -_POSITION_MOST * sign
    return ((turns << 14) + fraction - zero) * sign


@hot
def encoder_reset(loop: CurrentLoop, settings: JointSettings, state: JointState) -> None:
    """Start at the rotor's angle loop.rotor in turn 0, at rest and not homed."""
    state.turns = 0
    state.fraction = loop.rotor
    state.lag = 0
    state.rate = 0
    state.velocity = 0
    state.homed = 0
    state.range_exceeded = 0
    state.disagree_ticks = 0
    state.position = position_of(0, loop.rotor, settings.zero, settings.joint_sign)


@hot
def encoder_resync(loop: CurrentLoop, state: JointState) -> None:
    """Follow the last rejected reading after the encoder was lost, with the bridge off.

    Turns may have been missed: the joint is no longer homed.
    """
    if loop.rotor_rejected < 0:
        return
    loop.rotor = loop.rotor_rejected
    loop.rotor_rejected = -1
    state.fraction = loop.rotor
    state.lag = 0
    state.rate = 0
    state.homed = 0


@hot
def encoder_step(loop: CurrentLoop, settings: JointSettings, state: JointState) -> int:
    """Take the rotor over once a millisecond: turns, fraction, position, rate, velocity; return state.position.

    Exact for less than half a rotor turn a tick (500 turns/s). At the end of its range state.turns stops at
    +-(2^30 - 2); range_exceeded is 1 from the moment state.position cannot follow any more.
    """
    moved = wrap_count(loop.rotor - state.fraction)
    fraction = state.fraction + moved
    turns = saturate(state.turns + (fraction >> 14), -_TURNS_MOST, _TURNS_MOST)
    state.turns = turns
    state.fraction = fraction & 16383
    if turns > _TURNS_IN_POSITION or turns < -_TURNS_IN_POSITION:
        state.range_exceeded = 1
    state.position = position_of(turns, fraction & 16383, settings.zero, settings.joint_sign)
    state.velocity = track_rate(settings, state, moved) * settings.joint_sign
    return state.position


@hot
def track_rate(settings: JointSettings, state: JointState, moved: int) -> int:
    """Advance the tracking loop by ``moved`` rc, -8192 .. 8191, and return state.rate in rc/256 per tick.

    A second-order loop with both poles at the same place. state.lag is the predicted position less the measured one;
    track_1 of it corrects the position, track_2 the rate (Q12, 0 .. 4095). At a constant rate the only error is the
    encoder's rounding. The lag is limited to +-(2^18 - 1), so products stay below 2^30.
    """
    lag = saturate(state.lag + state.rate - (moved << 8), -_LAG_MOST, _LAG_MOST)
    state.rate = saturate(state.rate - ((lag * settings.track_2 + 2048) >> 12), -_RATE_MOST, _RATE_MOST)
    state.lag = lag - ((lag * settings.track_1 + 2048) >> 12)
    return state.rate


@hot
def joint_count(settings: JointSettings, raw: int) -> int:
    """Return the joint encoder's angle as rc of the rotor, joint-signed, from ``raw`` 0 .. 16383.

    Within half a joint turn of zero. Error at most 1/2 rc plus the gear's. Intermediates: 8192 *
    gear_q8 below 2^30 for gears up to 500:1.
    """
    angle = wrap_count(raw - settings.joint_encoder_zero) * settings.joint_encoder_sign
    return (angle * settings.gear_q8 + 128) >> 8


@hot
def watch_encoders(settings: JointSettings, state: JointState, io: JointIo) -> int:
    """Compare both encoders; return for how many ticks they have disagreed by more than settings.disagree.

    The difference is taken within half a joint turn, so any number of joint turns may have passed.
    settings.disagree is below 8192 rc, half a rotor turn: a lost rotor turn is always seen.
    """
    full = settings.gear_q8 << 6
    if settings.has_joint_encoder == 0 or io.joint_valid == 0 or state.homed == 0 or full <= 0:
        state.disagree_ticks = 0
        return 0
    error = joint_count(settings, io.joint_raw) - state.position
    error = (error + (full >> 1)) % full - (full >> 1)
    state.joint_error = error
    if error > settings.disagree or error < -settings.disagree:
        state.disagree_ticks += 1
    else:
        state.disagree_ticks = 0
    return state.disagree_ticks


@hot
def choose_turn(settings: JointSettings, state: JointState, expected_rc: int) -> int:
    """Set state.turns so that the position is nearest to ``expected_rc``; return the rest, expected minus position.

    expected_rc: joint-signed, within +-2^28. Result -8192 .. 8192: the position is right if the expectation was less
    than half a rotor turn (8.18 deg of a 22:1 joint) off. Exact.
    """
    wanted = expected_rc * settings.joint_sign + settings.zero - state.fraction
    state.turns = (wanted + 8192) >> 14
    state.position = position_of(state.turns, state.fraction, settings.zero, settings.joint_sign)
    state.range_exceeded = 0
    return expected_rc - state.position


@hot
def home_at(settings: JointSettings, state: JointState, expected_rc: int) -> int:
    """Home on a known position (stop, stored pose, joint encoder); return 1, or 0 if it is ambiguous.

    Ambiguous: the nearest position the rotor's angle allows is more than home_tolerance away from
    the expected one, so that a neighbouring turn could be meant. Then state.homed becomes 0.
    """
    left = choose_turn(settings, state, expected_rc)
    state.homed = 0
    if left <= settings.home_tolerance and left >= -settings.home_tolerance:
        state.homed = 1
    return state.homed


@hot
def home_by_encoder(settings: JointSettings, state: JointState, io: JointIo) -> int:
    """Home by the joint encoder; return 1, or 0 if there is none, it is not valid, or it is ambiguous."""
    if settings.has_joint_encoder == 0 or io.joint_valid == 0:
        return 0
    return home_at(settings, state, joint_count(settings, io.joint_raw))
