"""The encoders of a joint: turns counted without loss, speed by a tracking loop, the rotor's turn, disagreement.

The rotor angle is kept as whole turns and a fraction, so nothing is lost in any number of turns up
to +-(2^30 - 2). S_POSITION is the same, joint-signed, from the joint's zero, within +-2^29 rc.
"""

from ..fixed import saturate
from ..runtime import Ints, const, hot
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
def encoder_reset(foc: Ints, cfg: Ints, state: Ints) -> int:
    """Start at the rotor's angle F_ROTOR in turn 0, at rest and not homed; return S_POSITION."""
    state[S_TURNS] = 0
    state[S_FRACTION] = foc[F_ROTOR]
    state[S_LAG] = 0
    state[S_RATE] = 0
    state[S_VELOCITY] = 0
    state[S_HOMED] = 0
    state[S_SHIFTED] = 0
    state[S_DISAGREE_TICKS] = 0
    state[S_POSITION] = position_of(0, foc[F_ROTOR], cfg[K_ZERO], cfg[K_JOINT_SIGN])
    return state[S_POSITION]


@hot
def encoder_resync(foc: Ints, state: Ints) -> int:
    """Follow the last rejected reading after the encoder was lost, with the bridge off; return 1 if there was one.

    Turns may have been missed: the joint is no longer homed.
    """
    if foc[F_ROTOR_SEEN] < 0:
        return 0
    foc[F_ROTOR] = foc[F_ROTOR_SEEN]
    foc[F_ROTOR_SEEN] = -1
    state[S_FRACTION] = foc[F_ROTOR]
    state[S_LAG] = 0
    state[S_RATE] = 0
    state[S_HOMED] = 0
    return 1


@hot
def encoder_step(foc: Ints, cfg: Ints, state: Ints) -> int:
    """Take F_ROTOR over once a millisecond: S_TURNS, S_FRACTION, S_POSITION, S_RATE, S_VELOCITY; return S_POSITION.

    Exact for less than half a rotor turn a tick (500 turns/s). At the end of its range S_TURNS
    stops at +-(2^30 - 2); S_SHIFTED is 1 from the moment S_POSITION cannot follow any more.
    """
    moved = wrap_count(foc[F_ROTOR] - state[S_FRACTION])
    fraction = state[S_FRACTION] + moved
    turns = saturate(state[S_TURNS] + (fraction >> 14), -_TURNS_MOST, _TURNS_MOST)
    state[S_TURNS] = turns
    state[S_FRACTION] = fraction & 16383
    if turns > _TURNS_IN_POSITION or turns < -_TURNS_IN_POSITION:
        state[S_SHIFTED] = 1
    state[S_POSITION] = position_of(turns, fraction & 16383, cfg[K_ZERO], cfg[K_JOINT_SIGN])
    state[S_VELOCITY] = track_rate(cfg, state, moved) * cfg[K_JOINT_SIGN]
    return state[S_POSITION]


@hot
def track_rate(cfg: Ints, state: Ints, moved: int) -> int:
    """Advance the tracking loop by ``moved`` rc, -8192 .. 8191, and return S_RATE in rc/256 per tick.

    A second-order loop with both poles at the same place: the predicted position lags by S_LAG; K_TRACK_1
    of the lag corrects the position, K_TRACK_2 the rate (Q12, 0 .. 4095). No error at constant rate
    but the encoder's rounding. The lag is limited to +-(2^18 - 1), so products stay below 2^30.
    """
    lag = saturate(state[S_LAG] + state[S_RATE] - (moved << 8), -_LAG_MOST, _LAG_MOST)
    state[S_RATE] = saturate(state[S_RATE] - ((lag * cfg[K_TRACK_2] + 2048) >> 12), -_RATE_MOST, _RATE_MOST)
    state[S_LAG] = lag - ((lag * cfg[K_TRACK_1] + 2048) >> 12)
    return state[S_RATE]


@hot
def joint_count(cfg: Ints, raw: int) -> int:
    """Return the joint encoder's angle as rc of the rotor, joint-signed, from ``raw`` 0 .. 16383.

    Within half a joint turn of zero. Error at most 1/2 rc plus the gear's. Intermediates: 8192 *
    K_GEAR_Q8 below 2^30 for gears up to 500:1.
    """
    angle = wrap_count(raw - cfg[K_JOINT_ENCODER_ZERO]) * cfg[K_JOINT_ENCODER_SIGN]
    return (angle * cfg[K_GEAR_Q8] + 128) >> 8


@hot
def watch_encoders(cfg: Ints, state: Ints, io: Ints) -> int:
    """Compare both encoders; return for how many ticks they have disagreed by more than K_DISAGREE.

    The difference is taken within half a joint turn, so any number of joint turns may have passed.
    K_DISAGREE is below 8192 rc, half a rotor turn: a lost rotor turn is always seen.
    """
    full = cfg[K_GEAR_Q8] << 6
    if cfg[K_HAS_JOINT_ENCODER] == 0 or io[IO_JOINT_VALID] == 0 or state[S_HOMED] == 0 or full <= 0:
        state[S_DISAGREE_TICKS] = 0
        return 0
    error = joint_count(cfg, io[IO_JOINT_RAW]) - state[S_POSITION]
    error = (error + (full >> 1)) % full - (full >> 1)
    state[S_JOINT_ERROR] = error
    if error > cfg[K_DISAGREE] or error < -cfg[K_DISAGREE]:
        state[S_DISAGREE_TICKS] += 1
    else:
        state[S_DISAGREE_TICKS] = 0
    return state[S_DISAGREE_TICKS]


@hot
def choose_turn(cfg: Ints, state: Ints, expected_rc: int) -> int:
    """Set S_TURNS so that S_POSITION is nearest to ``expected_rc``; return what is left, expected minus position.

    expected_rc: joint-signed, within +-2^28. Result -8192 .. 8192: the position is right if the
    expectation was less than half a rotor turn (8.18 deg of a 22:1 joint) off. Exact.
    """
    wanted = expected_rc * cfg[K_JOINT_SIGN] + cfg[K_ZERO] - state[S_FRACTION]
    state[S_TURNS] = (wanted + 8192) >> 14
    state[S_POSITION] = position_of(state[S_TURNS], state[S_FRACTION], cfg[K_ZERO], cfg[K_JOINT_SIGN])
    state[S_SHIFTED] = 0
    return expected_rc - state[S_POSITION]


@hot
def home_at(cfg: Ints, state: Ints, expected_rc: int) -> int:
    """Home on a known position (stop, stored pose, joint encoder); return 1, or 0 if it is ambiguous.

    Ambiguous: the nearest position the rotor's angle allows is more than K_HOME_TOLERANCE away from
    the expected one, so that a neighbouring turn could be meant. Then S_HOMED becomes 0.
    """
    left = choose_turn(cfg, state, expected_rc)
    state[S_HOMED] = 0
    if left <= cfg[K_HOME_TOLERANCE] and left >= -cfg[K_HOME_TOLERANCE]:
        state[S_HOMED] = 1
    return state[S_HOMED]


@hot
def home_by_encoder(cfg: Ints, state, io: Ints) -> int:
    """Home by the joint encoder; return 1, or 0 if there is none, it is not valid, or it is ambiguous."""
    if cfg[K_HAS_JOINT_ENCODER] == 0 or io[IO_JOINT_VALID] == 0:
        return 0
    return home_at(cfg, state, joint_count(cfg, io[IO_JOINT_RAW]))
