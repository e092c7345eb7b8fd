"""The encoders of a joint: turns counted without loss, speed by a tracking loop, the rotor's turn, disagreement.

The rotor angle is kept as whole turns and a fraction, so nothing is lost in any number of turns up
to +-(2^30 - 2). S_POSITION is the same, joint-signed, from the joint's zero, within +-2^29 rc.
"""

from ..fixed import saturate
from ..runtime import const, hot, ptr32
from .layout import (
    F_ROTOR,
    F_ROTOR_SEEN,
    IO_JOINT_RAW,
    IO_JOINT_VALID,
    K_DISAGREE,
    K_GEAR_Q8,
    K_HAS_JOINT_ENCODER,
    K_HOME_TOLERANCE,
    K_JOINT_ENCODER_SIGN,
    K_JOINT_ENCODER_ZERO,
    K_JOINT_SIGN,
    K_TRACK_1,
    K_TRACK_2,
    K_ZERO,
    S_DISAGREE_TICKS,
    S_FRACTION,
    S_HOMED,
    S_JOINT_ERROR,
    S_LAG,
    S_POSITION,
    S_RATE,
    S_SHIFTED,
    S_TURNS,
    S_VELOCITY,
)

_TURN = const(16384)
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
def encoder_reset(foc, cfg, state) -> int:
    """Start at the rotor's angle F_ROTOR in turn 0, at rest and not homed; return S_POSITION."""
    block = ptr32(foc)
    k = ptr32(cfg)
    s = ptr32(state)
    s[S_TURNS] = 0
    s[S_FRACTION] = block[F_ROTOR]
    s[S_LAG] = 0
    s[S_RATE] = 0
    s[S_VELOCITY] = 0
    s[S_HOMED] = 0
    s[S_SHIFTED] = 0
    s[S_DISAGREE_TICKS] = 0
    s[S_POSITION] = position_of(0, block[F_ROTOR], k[K_ZERO], k[K_JOINT_SIGN])
    return s[S_POSITION]


@hot
def encoder_resync(foc, state) -> int:
    """Follow the last rejected reading after the encoder was lost, with the bridge off; return 1 if there was one.

    Turns may have been missed: the joint is no longer homed.
    """
    block = ptr32(foc)
    s = ptr32(state)
    if block[F_ROTOR_SEEN] < 0:
        return 0
    block[F_ROTOR] = block[F_ROTOR_SEEN]
    block[F_ROTOR_SEEN] = -1
    s[S_FRACTION] = block[F_ROTOR]
    s[S_LAG] = 0
    s[S_RATE] = 0
    s[S_HOMED] = 0
    return 1


@hot
def encoder_step(foc, cfg, state) -> int:
    """Take F_ROTOR over once a millisecond: S_TURNS, S_FRACTION, S_POSITION, S_RATE, S_VELOCITY; return S_POSITION.

    Exact for less than half a rotor turn a tick (500 turns/s). At the end of its range S_TURNS
    stops at +-(2^30 - 2); S_SHIFTED is 1 from the moment S_POSITION cannot follow any more.
    """
    block = ptr32(foc)
    k = ptr32(cfg)
    s = ptr32(state)
    moved = wrap_count(block[F_ROTOR] - s[S_FRACTION])
    fraction = s[S_FRACTION] + moved
    turns = saturate(s[S_TURNS] + (fraction >> 14), -_TURNS_MOST, _TURNS_MOST)
    s[S_TURNS] = turns
    s[S_FRACTION] = fraction & 16383
    if turns > _TURNS_IN_POSITION or turns < -_TURNS_IN_POSITION:
        s[S_SHIFTED] = 1
    s[S_POSITION] = position_of(turns, fraction & 16383, k[K_ZERO], k[K_JOINT_SIGN])
    s[S_VELOCITY] = track_rate(cfg, state, moved) * k[K_JOINT_SIGN]
    return s[S_POSITION]


@hot
def track_rate(cfg, state, moved: int) -> int:
    """Advance the tracking loop by ``moved`` rc, -8192 .. 8191, and return S_RATE in rc/256 per tick.

    A second-order loop with both poles at the same place: the predicted position lags by S_LAG; K_TRACK_1
    of the lag corrects the position, K_TRACK_2 the rate (Q12, 0 .. 4095). No error at constant rate
    but the encoder's rounding. The lag is limited to +-(2^18 - 1), so products stay below 2^30.
    """
    k = ptr32(cfg)
    s = ptr32(state)
    lag = saturate(s[S_LAG] + s[S_RATE] - (moved << 8), -_LAG_MOST, _LAG_MOST)
    s[S_RATE] = saturate(s[S_RATE] - ((lag * k[K_TRACK_2] + 2048) >> 12), -_RATE_MOST, _RATE_MOST)
    s[S_LAG] = lag - ((lag * k[K_TRACK_1] + 2048) >> 12)
    return s[S_RATE]


@hot
def joint_count(cfg, raw: int) -> int:
    """Return the joint encoder's angle as rc of the rotor, joint-signed, from ``raw`` 0 .. 16383.

    Within half a joint turn of zero. Error at most 1/2 rc plus the gear's. Intermediates: 8192 *
    K_GEAR_Q8 below 2^30 for gears up to 500:1.
    """
    k = ptr32(cfg)
    angle = wrap_count(raw - k[K_JOINT_ENCODER_ZERO]) * k[K_JOINT_ENCODER_SIGN]
    return (angle * k[K_GEAR_Q8] + 128) >> 8


@hot
def watch_encoders(cfg, state, io) -> int:
    """Compare both encoders; return for how many ticks they have disagreed by more than K_DISAGREE.

    The difference is taken within half a joint turn, so any number of joint turns may have passed.
    K_DISAGREE is below 8192 rc, half a rotor turn: a lost rotor turn is always seen.
    """
    k = ptr32(cfg)
    s = ptr32(state)
    b = ptr32(io)
    full = k[K_GEAR_Q8] << 6
    if k[K_HAS_JOINT_ENCODER] == 0 or b[IO_JOINT_VALID] == 0 or s[S_HOMED] == 0 or full <= 0:
        s[S_DISAGREE_TICKS] = 0
        return 0
    error = joint_count(cfg, b[IO_JOINT_RAW]) - s[S_POSITION]
    error = (error + (full >> 1)) % full - (full >> 1)
    s[S_JOINT_ERROR] = error
    if error > k[K_DISAGREE] or error < -k[K_DISAGREE]:
        s[S_DISAGREE_TICKS] += 1
    else:
        s[S_DISAGREE_TICKS] = 0
    return s[S_DISAGREE_TICKS]


@hot
def choose_turn(cfg, state, expected_rc: int) -> int:
    """Set S_TURNS so that S_POSITION is nearest to ``expected_rc``; return what is left, expected minus position.

    expected_rc: joint-signed, within +-2^28. Result -8192 .. 8192: the position is right if the
    expectation was less than half a rotor turn (8.18 deg of a 22:1 joint) off. Exact.
    """
    k = ptr32(cfg)
    s = ptr32(state)
    wanted = expected_rc * k[K_JOINT_SIGN] + k[K_ZERO] - s[S_FRACTION]
    s[S_TURNS] = (wanted + 8192) >> 14
    s[S_POSITION] = position_of(s[S_TURNS], s[S_FRACTION], k[K_ZERO], k[K_JOINT_SIGN])
    s[S_SHIFTED] = 0
    return expected_rc - s[S_POSITION]


@hot
def home_at(cfg, state, expected_rc: int) -> int:
    """Home on a known position (stop, stored pose, joint encoder); return 1, or 0 if it is ambiguous.

    Ambiguous: the nearest position the rotor's angle allows is more than K_HOME_TOLERANCE away from
    the expected one, so that a neighbouring turn could be meant. Then S_HOMED becomes 0.
    """
    k = ptr32(cfg)
    s = ptr32(state)
    left = choose_turn(cfg, state, expected_rc)
    s[S_HOMED] = 0
    if left <= k[K_HOME_TOLERANCE] and left >= -k[K_HOME_TOLERANCE]:
        s[S_HOMED] = 1
    return s[S_HOMED]


@hot
def home_by_encoder(cfg, state, io) -> int:
    """Home by the joint encoder; return 1, or 0 if there is none, it is not valid, or it is ambiguous."""
    k = ptr32(cfg)
    b = ptr32(io)
    if k[K_HAS_JOINT_ENCODER] == 0 or b[IO_JOINT_VALID] == 0:
        return 0
    return home_at(cfg, state, joint_count(cfg, b[IO_JOINT_RAW]))
