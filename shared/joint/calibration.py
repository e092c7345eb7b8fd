"""Calibration: current offsets, rotor offset, direction, pole pairs and the joint encoder's sign, found tick by tick.

    rest (bridge off) -> ramp and settle on d current -> turn the field forward and back -> again -> done

At rest it checks current offsets and noise, bus voltage, encoder noise, no motion; on the field the
current reached, the sum of the phases and that the rotor follows. The first way forward and back
gives direction, pole pairs and the joint encoder's sign, the second the offset as the mean of both
ways, in which friction cancels. What is found is written only when everything is. Reasons are FAULT_CAL_*.

Kinds: full turns the field four electrical turns; small, for an assembled leg, half a turn with the
pole pairs known (1.2 deg at a 22:1 joint with 7); verify is small, changes nothing and compares.
"""

from ..runtime import const, hot, ptr32
from .current import current_relax, current_sum, set_offsets
from .encoder import wrap_count
from .faults import (
    FAULT_CAL_BUS,
    FAULT_CAL_ENCODER,
    FAULT_CAL_JOINT_ENCODER,
    FAULT_CAL_MOVING,
    FAULT_CAL_NO_CURRENT,
    FAULT_CAL_NOISE,
    FAULT_CAL_NOT_FREE,
    FAULT_CAL_OFFSET,
    FAULT_CAL_OFFSET_CHANGED,
    FAULT_CAL_PHASE_ORDER,
    FAULT_CAL_POLE_PAIRS,
    FAULT_CAL_SPREAD,
    FAULT_CAL_SUM,
    FAULT_NONE,
)
from .layout import (
    F_D_REF,
    F_ELEC_GAIN,
    F_ELEC_OFFSET,
    F_FEED_D,
    F_FEED_Q,
    F_I_D,
    F_Q_REF,
    F_RAW_A,
    F_ROTOR,
    IO_JOINT_RAW,
    IO_JOINT_VALID,
    K_CAL_BUS_LEAST,
    K_CAL_BUS_MOST,
    K_CAL_CURRENT,
    K_CALIBRATED,
    K_DIRECTION,
    K_ELEC_OFFSET,
    K_GEAR_Q8,
    K_HAS_JOINT_ENCODER,
    K_JOINT_ENCODER_SIGN,
    K_JOINT_ENCODER_ZERO,
    K_JOINT_SIGN,
    K_OFFSET_SPREAD,
    K_POLE_PAIRS,
    K_STALL_RATE,
    K_SUM_LIMIT,
    K_VERIFY,
    K_ZERO,
    S_BUS,
    S_RATE,
)
from .sine import TABLE_HALF_STEP

CAL_FULL = const(1)
CAL_SMALL = const(2)
CAL_VERIFY = const(3)

# Places in the calibration block
C_KIND = const(0)  # CAL_*, 0 while none is running
C_PHASE = const(1)  # PHASE_*
C_TICKS = const(2)  # in this phase
C_REASON = const(3)  # FAULT_CAL_* of the last one, 0 if it succeeded
C_VALUE = const(4)
C_ANGLE = const(5)  # brad, angle of the field, not wrapped
C_MOVED = const(6)  # rc since the settled position
C_LAST = const(7)  # rc, rotor in the tick before
C_JOINT_MOVED = const(8)  # 1/16384 joint turn
C_JOINT_LAST = const(9)
C_FORWARD = const(10)  # rc moved on the first way forward
C_JOINT_FORWARD = const(11)
C_DIRECTION = const(12)  # found
C_POLE_PAIRS = const(13)
C_REFERENCE = const(14)  # brad, first offset seen
C_SUM = const(15)  # brad, of the offsets relative to it
C_COUNT = const(16)
C_LOW = const(17)
C_HIGH = const(18)
C_RAW_SUM = const(19)  # 3 values
C_RAW_LOW = const(22)  # 3 values, before the encoder's
C_ROTOR_LOW = const(25)
C_RAW_HIGH = const(26)  # 3 values, before the encoder's
C_ROTOR_HIGH = const(29)
C_POSE_GIVEN = const(30)  # 1: the joint stands at C_POSE when calibration starts
C_POSE = const(31)  # rc, joint-signed
C_REST_ROTOR = const(32)
C_REST_JOINT = const(33)
C_OFFSET = const(34)  # brad, electrical offset found
CAL_SIZE = const(35)

PHASE_IDLE = const(0)
PHASE_REST = const(1)
PHASE_RAMP = const(2)
PHASE_SETTLE = const(3)
PHASE_FORWARD = const(4)
PHASE_BACK = const(5)
PHASE_AGAIN = const(6)
PHASE_RETURN = const(7)

_REST_SHIFT = const(8)  # 256 ticks at rest
_RAMP_SHIFT = const(8)
_SETTLE_TICKS = const(512)
_NOISE_MOST = const(24)  # counts peak to peak: 0.1 A
_ENCODER_NOISE_MOST = const(8)  # rc peak to peak
_FULL_TRAVEL = const(262144)  # brad of the field: 4 electrical turns
_SMALL_TRAVEL = const(32768)
_FULL_STEP = const(128)  # brad a tick: 2 electrical turns a second
_SMALL_STEP = const(32)
_SPREAD_MOST = const(10923)  # brad: 60 electrical degrees between both ways
_POLE_PAIRS_MOST = const(40)


@hot
def set_commutation(foc, cfg) -> int:
    """Hand the stored direction, pole pairs and offset to the current step; return F_ELEC_GAIN."""
    block = ptr32(foc)
    k = ptr32(cfg)
    block[F_ELEC_OFFSET] = k[K_ELEC_OFFSET] + TABLE_HALF_STEP
    block[F_ELEC_GAIN] = 4 * k[K_POLE_PAIRS] * k[K_DIRECTION]
    return block[F_ELEC_GAIN]


@hot
def calibration_start(cal, kind: int) -> int:
    """Begin a calibration of ``kind`` with the next tick; return PHASE_REST. C_POSE_GIVEN, C_POSE are the caller's."""
    c = ptr32(cal)
    for i in range(C_TICKS, C_POSE_GIVEN):
        c[i] = 0
    for i in range(4):
        c[C_RAW_LOW + i] = 0xFFFF
        c[C_RAW_HIGH + i] = -0xFFFF
    c[C_KIND] = kind
    c[C_PHASE] = PHASE_REST
    return PHASE_REST


@hot
def calibration_abort(foc, cfg, cal) -> int:
    """End a calibration without a result, restore the commutation and the references; return PHASE_IDLE."""
    block = ptr32(foc)
    c = ptr32(cal)
    c[C_PHASE] = PHASE_IDLE
    c[C_KIND] = 0
    block[F_D_REF] = 0
    block[F_Q_REF] = 0
    set_commutation(foc, cfg)
    return PHASE_IDLE


@hot
def calibration_needs_bridge(cal) -> int:
    """Return 1 while the field is on, 0 at rest and when idle: the bridge is off then."""
    c = ptr32(cal)
    if c[C_PHASE] > PHASE_REST:
        return 1
    return 0


@hot
def calibration_step(foc, cfg, state, io, cal) -> int:
    """Do one tick; return C_PHASE, PHASE_IDLE when over. Then C_REASON is 0 or says what stood against it.

    About 18 s for a full one, 5 s for a small one.
    """
    c = ptr32(cal)
    phase = c[C_PHASE]
    if phase == PHASE_IDLE:
        return PHASE_IDLE
    c[C_TICKS] += 1
    if phase == PHASE_REST:
        _rest(foc, cfg, state, io, cal)
    elif phase == PHASE_RAMP:
        _ramp(foc, cfg, cal)
    elif phase == PHASE_SETTLE:
        _settle(foc, cfg, io, cal)
    else:
        _turn(foc, cfg, io, cal)
    if c[C_PHASE] == PHASE_IDLE:
        calibration_abort(foc, cfg, cal)
    return c[C_PHASE]


@hot
def _refuse(cal, reason: int, value: int) -> int:
    """End with a reason, unless there is one already."""
    c = ptr32(cal)
    if c[C_REASON] == FAULT_NONE:
        c[C_REASON] = reason
        c[C_VALUE] = value
    c[C_PHASE] = PHASE_IDLE
    return reason


@hot
def _next(cal, phase: int) -> int:
    c = ptr32(cal)
    c[C_PHASE] = phase
    c[C_TICKS] = 0
    return phase


@hot
def _extremes(cal, place: int, value: int) -> int:
    c = ptr32(cal)
    if value < c[C_RAW_LOW + place]:
        c[C_RAW_LOW + place] = value
    if value > c[C_RAW_HIGH + place]:
        c[C_RAW_HIGH + place] = value
    return c[C_RAW_HIGH + place] - c[C_RAW_LOW + place]


@hot
def _rest(foc, cfg, state, io, cal) -> int:
    """Collect 256 readings with the bridge off, then check them and set the current offsets."""
    block = ptr32(foc)
    c = ptr32(cal)
    b = ptr32(io)
    if c[C_TICKS] == 1:
        c[C_REST_ROTOR] = block[F_ROTOR]
        c[C_REST_JOINT] = b[IO_JOINT_RAW]
    for phase in range(3):
        raw = block[F_RAW_A + phase]
        c[C_RAW_SUM + phase] = c[C_RAW_SUM + phase] + raw
        _extremes(cal, phase, raw)
    _extremes(cal, 3, wrap_count(block[F_ROTOR] - c[C_REST_ROTOR]))
    if c[C_TICKS] >> _REST_SHIFT == 0:
        return PHASE_REST
    _check_rest(cfg, state, cal)
    if c[C_PHASE] == PHASE_IDLE:
        return PHASE_IDLE
    shift = _REST_SHIFT - 4
    set_offsets(foc, c[C_RAW_SUM] >> shift, c[C_RAW_SUM + 1] >> shift, c[C_RAW_SUM + 2] >> shift)
    current_relax(foc)
    return _next(cal, PHASE_RAMP)


@hot
def _check_rest(cfg, state, cal) -> int:
    k = ptr32(cfg)
    s = ptr32(state)
    c = ptr32(cal)
    for phase in range(3):
        offset = c[C_RAW_SUM + phase] >> _REST_SHIFT
        if offset > 2048 + k[K_OFFSET_SPREAD] or offset < 2048 - k[K_OFFSET_SPREAD]:
            return _refuse(cal, FAULT_CAL_OFFSET, offset)
        noise = c[C_RAW_HIGH + phase] - c[C_RAW_LOW + phase]
        if noise > _NOISE_MOST:
            return _refuse(cal, FAULT_CAL_NOISE, noise)
    if s[S_BUS] < k[K_CAL_BUS_LEAST] or s[S_BUS] > k[K_CAL_BUS_MOST]:
        return _refuse(cal, FAULT_CAL_BUS, s[S_BUS])
    if s[S_RATE] > k[K_STALL_RATE] or s[S_RATE] < -k[K_STALL_RATE]:
        return _refuse(cal, FAULT_CAL_MOVING, s[S_RATE])
    noise = c[C_ROTOR_HIGH] - c[C_ROTOR_LOW]
    if noise > _ENCODER_NOISE_MOST:
        return _refuse(cal, FAULT_CAL_ENCODER, noise)
    return FAULT_NONE


@hot
def _force(foc, cal, current: int) -> int:
    """Point the field at C_ANGLE with ``current`` on d, whatever the encoder says."""
    block = ptr32(foc)
    c = ptr32(cal)
    block[F_ELEC_GAIN] = 0
    block[F_ELEC_OFFSET] = (c[C_ANGLE] & 0xFFFF) + TABLE_HALF_STEP
    block[F_FEED_D] = 0
    block[F_FEED_Q] = 0
    block[F_Q_REF] = 0
    block[F_D_REF] = current
    return current


@hot
def _ramp(foc, cfg, cal) -> int:
    """Let the current grow while the field comes from a quarter turn back: no rotor stands exactly against both."""
    k = ptr32(cfg)
    c = ptr32(cal)
    c[C_ANGLE] = (c[C_TICKS] << 6) - 16384
    _force(foc, cal, k[K_CAL_CURRENT] * c[C_TICKS] >> _RAMP_SHIFT)
    if c[C_TICKS] >> _RAMP_SHIFT:
        _next(cal, PHASE_SETTLE)
    return c[C_PHASE]


@hot
def _settle(foc, cfg, io, cal) -> int:
    """Wait until the rotor has found the field, then check the current and start to turn."""
    block = ptr32(foc)
    k = ptr32(cfg)
    c = ptr32(cal)
    b = ptr32(io)
    wanted = _force(foc, cal, k[K_CAL_CURRENT])
    if c[C_TICKS] < _SETTLE_TICKS:
        return PHASE_SETTLE
    missing = wanted - block[F_I_D]
    if missing > wanted >> 2 or missing < -(wanted >> 2):
        return _refuse(cal, FAULT_CAL_NO_CURRENT, block[F_I_D])
    wrong = current_sum(foc)
    if wrong > k[K_SUM_LIMIT] or wrong < -k[K_SUM_LIMIT]:
        return _refuse(cal, FAULT_CAL_SUM, wrong)
    c[C_LAST] = block[F_ROTOR]
    c[C_JOINT_LAST] = b[IO_JOINT_RAW]
    return _next(cal, PHASE_FORWARD)


@hot
def _turn(foc, cfg, io, cal) -> int:
    """Turn the field by one step, follow the encoders, and close the way when its end is reached."""
    block = ptr32(foc)
    k = ptr32(cfg)
    c = ptr32(cal)
    b = ptr32(io)
    c[C_MOVED] += wrap_count(block[F_ROTOR] - c[C_LAST])
    c[C_LAST] = block[F_ROTOR]
    c[C_JOINT_MOVED] += wrap_count(b[IO_JOINT_RAW] - c[C_JOINT_LAST])
    c[C_JOINT_LAST] = b[IO_JOINT_RAW]
    if c[C_PHASE] >= PHASE_AGAIN:
        _sample_offset(foc, cal)
    travel = _SMALL_TRAVEL
    step = _SMALL_STEP
    if c[C_KIND] == CAL_FULL:
        travel = _FULL_TRAVEL
        step = _FULL_STEP
    if c[C_PHASE] == PHASE_BACK or c[C_PHASE] == PHASE_RETURN:
        step = -step
    if c[C_ANGLE] + step < 0 or c[C_ANGLE] + step > travel:
        return _end_way(foc, cfg, io, cal, travel)
    c[C_ANGLE] += step
    return _force(foc, cal, k[K_CAL_CURRENT])


@hot
def _end_way(foc, cfg, io, cal, travel: int) -> int:
    c = ptr32(cal)
    phase = c[C_PHASE]
    if phase == PHASE_FORWARD:
        c[C_FORWARD] = c[C_MOVED]
        c[C_JOINT_FORWARD] = c[C_JOINT_MOVED]
    if phase == PHASE_BACK:
        _find_direction(cfg, cal, travel)
        _check_joint_encoder(cfg, io, cal)
        if c[C_PHASE] == PHASE_IDLE:
            return PHASE_IDLE
    if phase == PHASE_RETURN:
        return _finish(foc, cfg, io, cal)
    return _next(cal, phase + 1)


@hot
def _find_direction(cfg, cal, travel: int) -> int:
    """Direction and pole pairs from the first way, which must have come back to where it began."""
    k = ptr32(cfg)
    c = ptr32(cal)
    moved = c[C_FORWARD]
    c[C_DIRECTION] = 1
    if moved < 0:
        c[C_DIRECTION] = -1
        moved = -moved
    left = c[C_MOVED]
    if moved < 64 or left > moved >> 2 or left < -(moved >> 2):
        return _refuse(cal, FAULT_CAL_NOT_FREE, c[C_FORWARD])
    pairs = (travel + moved + moved) // (moved << 2)
    if c[C_KIND] == CAL_FULL:
        rest = travel - 4 * pairs * moved
        if rest > moved or rest < -moved or pairs < 1 or pairs > _POLE_PAIRS_MOST:
            return _refuse(cal, FAULT_CAL_POLE_PAIRS, pairs)
        if k[K_POLE_PAIRS] != 0 and k[K_POLE_PAIRS] != pairs:
            return _refuse(cal, FAULT_CAL_POLE_PAIRS, pairs)
    else:
        pairs = k[K_POLE_PAIRS]
        rest = travel - 4 * pairs * moved
        if rest > travel >> 2 or rest < -(travel >> 2):
            return _refuse(cal, FAULT_CAL_NOT_FREE, c[C_FORWARD])
    c[C_POLE_PAIRS] = pairs
    if c[C_KIND] == CAL_VERIFY and c[C_DIRECTION] != k[K_DIRECTION]:
        return _refuse(cal, FAULT_CAL_PHASE_ORDER, c[C_DIRECTION])
    return FAULT_NONE


@hot
def _check_joint_encoder(cfg, io, cal) -> int:
    """The joint must have moved by the rotor's way through the gear, within a quarter and 8 counts."""
    k = ptr32(cfg)
    c = ptr32(cal)
    b = ptr32(io)
    if k[K_HAS_JOINT_ENCODER] == 0 or k[K_GEAR_Q8] < 1:
        return 0
    moved = c[C_JOINT_FORWARD]
    if moved < 0:
        moved = -moved
    expected = (c[C_FORWARD] * c[C_DIRECTION] << 8) // k[K_GEAR_Q8]
    error = moved - expected
    if b[IO_JOINT_VALID] == 0 or error > (expected >> 2) + 8 or error < -(expected >> 2) - 8:
        return _refuse(cal, FAULT_CAL_JOINT_ENCODER, c[C_JOINT_FORWARD])
    return 0


@hot
def _sample_offset(foc, cal) -> int:
    """Add one sample of field angle minus rotor angle, relative to the first."""
    block = ptr32(foc)
    c = ptr32(cal)
    offset = c[C_ANGLE] - 4 * c[C_POLE_PAIRS] * c[C_DIRECTION] * block[F_ROTOR]
    if c[C_COUNT] == 0:
        c[C_REFERENCE] = offset & 0xFFFF
    offset = ((offset - c[C_REFERENCE] + 0x8000) & 0xFFFF) - 0x8000
    c[C_SUM] += offset
    c[C_COUNT] += 1
    if offset < c[C_LOW]:
        c[C_LOW] = offset
    if offset > c[C_HIGH]:
        c[C_HIGH] = offset
    return offset


@hot
def _finish(foc, cfg, io, cal) -> int:
    """Check the offsets' spread, then write everything found, or compare it."""
    k = ptr32(cfg)
    c = ptr32(cal)
    spread = c[C_HIGH] - c[C_LOW]
    if spread > _SPREAD_MOST or c[C_COUNT] < 1:
        return _refuse(cal, FAULT_CAL_SPREAD, spread)
    c[C_OFFSET] = (c[C_REFERENCE] + c[C_SUM] // c[C_COUNT]) & 0xFFFF
    if c[C_KIND] == CAL_VERIFY:
        change = ((c[C_OFFSET] - k[K_ELEC_OFFSET] + 0x8000) & 0xFFFF) - 0x8000
        if change > k[K_VERIFY] or change < -k[K_VERIFY]:
            return _refuse(cal, FAULT_CAL_OFFSET_CHANGED, change)
        return _next(cal, PHASE_IDLE)
    k[K_ELEC_OFFSET] = c[C_OFFSET]
    k[K_DIRECTION] = c[C_DIRECTION]
    k[K_POLE_PAIRS] = c[C_POLE_PAIRS]
    k[K_CALIBRATED] = 1
    if k[K_HAS_JOINT_ENCODER]:
        same = c[C_FORWARD] ^ c[C_JOINT_FORWARD]
        k[K_JOINT_ENCODER_SIGN] = k[K_JOINT_SIGN]
        if same < 0:
            k[K_JOINT_ENCODER_SIGN] = -k[K_JOINT_SIGN]
    if c[C_POSE_GIVEN]:
        set_zeros(cfg, cal)
    return _next(cal, PHASE_IDLE)


@hot
def set_zeros(cfg, cal) -> int:
    """Set both encoders' zeros from the pose C_POSE at which they read C_REST_ROTOR and C_REST_JOINT; return K_ZERO.

    The joint encoder's zero is rounded to its count: the rotor's is exact.
    """
    k = ptr32(cfg)
    c = ptr32(cal)
    k[K_ZERO] = (c[C_REST_ROTOR] - c[C_POSE] * k[K_JOINT_SIGN]) & 16383
    if k[K_HAS_JOINT_ENCODER] and k[K_GEAR_Q8] > 0:
        half = k[K_GEAR_Q8] >> 1
        angle = ((c[C_POSE] << 8) + half) // k[K_GEAR_Q8]
        k[K_JOINT_ENCODER_ZERO] = (c[C_REST_JOINT] - angle * k[K_JOINT_ENCODER_SIGN]) & 16383
    return k[K_ZERO]
