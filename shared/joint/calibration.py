"""Calibration: current offsets, rotor offset, direction, pole pairs and the joint encoder's sign, found tick by tick.

    rest (bridge off) -> ramp and settle on d current -> turn the field forward and back -> again -> done

At rest it checks current offsets and noise, bus voltage, encoder noise, no motion; on the field the
current reached, the sum of the phases and that the rotor follows. The first way forward and back
gives direction, pole pairs and the joint encoder's sign, the second the offset as the mean of both
ways, in which friction cancels. What is found is written only when everything is. Reasons are FAULT_CAL_*.

Kinds: full turns the field four electrical turns; small, for an assembled leg, half a turn with the
pole pairs known (1.2 deg at a 22:1 joint with 7); verify is small, changes nothing and compares.
"""

from ..runtime import Ints, const, hot
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
def set_commutation(foc: Ints, cfg: Ints) -> int:
    """Hand the stored direction, pole pairs and offset to the current step; return F_ELEC_GAIN."""
    foc[F_ELEC_OFFSET] = cfg[K_ELEC_OFFSET] + TABLE_HALF_STEP
    foc[F_ELEC_GAIN] = 4 * cfg[K_POLE_PAIRS] * cfg[K_DIRECTION]
    return foc[F_ELEC_GAIN]


@hot
def calibration_start(cal: Ints, kind: int) -> int:
    """Begin a calibration of ``kind`` with the next tick; return PHASE_REST. C_POSE_GIVEN, C_POSE are the caller's."""
    for i in range(C_TICKS, C_POSE_GIVEN):
        cal[i] = 0
    for i in range(4):
        cal[C_RAW_LOW + i] = 0xFFFF
        cal[C_RAW_HIGH + i] = -0xFFFF
    cal[C_KIND] = kind
    cal[C_PHASE] = PHASE_REST
    return PHASE_REST


@hot
def calibration_abort(foc: Ints, cfg, cal: Ints) -> int:
    """End a calibration without a result, restore the commutation and the references; return PHASE_IDLE."""
    cal[C_PHASE] = PHASE_IDLE
    cal[C_KIND] = 0
    foc[F_D_REF] = 0
    foc[F_Q_REF] = 0
    set_commutation(foc, cfg)
    return PHASE_IDLE


@hot
def calibration_needs_bridge(cal: Ints) -> int:
    """Return 1 while the field is on, 0 at rest and when idle: the bridge is off then."""
    if cal[C_PHASE] > PHASE_REST:
        return 1
    return 0


@hot
def calibration_step(foc, cfg, state, io, cal: Ints) -> int:
    """Do one tick; return C_PHASE, PHASE_IDLE when over. Then C_REASON is 0 or says what stood against it.

    About 18 s for a full one, 5 s for a small one.
    """
    phase = cal[C_PHASE]
    if phase == PHASE_IDLE:
        return PHASE_IDLE
    cal[C_TICKS] += 1
    if phase == PHASE_REST:
        _rest(foc, cfg, state, io, cal)
    elif phase == PHASE_RAMP:
        _ramp(foc, cfg, cal)
    elif phase == PHASE_SETTLE:
        _settle(foc, cfg, io, cal)
    else:
        _turn(foc, cfg, io, cal)
    if cal[C_PHASE] == PHASE_IDLE:
        calibration_abort(foc, cfg, cal)
    return cal[C_PHASE]


@hot
def _refuse(cal: Ints, reason: int, value: int) -> int:
    """End with a reason, unless there is one already."""
    if cal[C_REASON] == FAULT_NONE:
        cal[C_REASON] = reason
        cal[C_VALUE] = value
    cal[C_PHASE] = PHASE_IDLE
    return reason


@hot
def _next(cal: Ints, phase: int) -> int:
    cal[C_PHASE] = phase
    cal[C_TICKS] = 0
    return phase


@hot
def _extremes(cal: Ints, place: int, value: int) -> int:
    """Take in a value of the lowest and highest at ``place``; return how far apart these are."""
    if value < cal[C_RAW_LOW + place]:
        cal[C_RAW_LOW + place] = value
    if value > cal[C_RAW_HIGH + place]:
        cal[C_RAW_HIGH + place] = value
    return cal[C_RAW_HIGH + place] - cal[C_RAW_LOW + place]


@hot
def _rest(foc: Ints, cfg, state, io: Ints, cal: Ints) -> int:
    """Collect 256 readings with the bridge off, then check them and set the current offsets."""
    if cal[C_TICKS] == 1:
        cal[C_REST_ROTOR] = foc[F_ROTOR]
        cal[C_REST_JOINT] = io[IO_JOINT_RAW]
    for phase in range(3):
        raw = foc[F_RAW_A + phase]
        cal[C_RAW_SUM + phase] = cal[C_RAW_SUM + phase] + raw
        _extremes(cal, phase, raw)
    _extremes(cal, 3, wrap_count(foc[F_ROTOR] - cal[C_REST_ROTOR]))
    if cal[C_TICKS] >> _REST_SHIFT == 0:
        return PHASE_REST
    _check_rest(cfg, state, cal)
    if cal[C_PHASE] == PHASE_IDLE:
        return PHASE_IDLE
    shift = _REST_SHIFT - 4
    set_offsets(foc, cal[C_RAW_SUM] >> shift, cal[C_RAW_SUM + 1] >> shift, cal[C_RAW_SUM + 2] >> shift)
    current_relax(foc)
    return _next(cal, PHASE_RAMP)


@hot
def _check_rest(cfg: Ints, state: Ints, cal: Ints) -> int:
    """Return FAULT_NONE if the currents, the supply and the rotor at rest are fit, else the first fault."""
    for phase in range(3):
        offset = cal[C_RAW_SUM + phase] >> _REST_SHIFT
        if offset > 2048 + cfg[K_OFFSET_SPREAD] or offset < 2048 - cfg[K_OFFSET_SPREAD]:
            return _refuse(cal, FAULT_CAL_OFFSET, offset)
        noise = cal[C_RAW_HIGH + phase] - cal[C_RAW_LOW + phase]
        if noise > _NOISE_MOST:
            return _refuse(cal, FAULT_CAL_NOISE, noise)
    if state[S_BUS] < cfg[K_CAL_BUS_LEAST] or state[S_BUS] > cfg[K_CAL_BUS_MOST]:
        return _refuse(cal, FAULT_CAL_BUS, state[S_BUS])
    if state[S_RATE] > cfg[K_STALL_RATE] or state[S_RATE] < -cfg[K_STALL_RATE]:
        return _refuse(cal, FAULT_CAL_MOVING, state[S_RATE])
    noise = cal[C_ROTOR_HIGH] - cal[C_ROTOR_LOW]
    if noise > _ENCODER_NOISE_MOST:
        return _refuse(cal, FAULT_CAL_ENCODER, noise)
    return FAULT_NONE


@hot
def _force(foc: Ints, cal: Ints, current: int) -> int:
    """Point the field at C_ANGLE with ``current`` on d, whatever the encoder says."""
    foc[F_ELEC_GAIN] = 0
    foc[F_ELEC_OFFSET] = (cal[C_ANGLE] & 0xFFFF) + TABLE_HALF_STEP
    foc[F_FEED_D] = 0
    foc[F_FEED_Q] = 0
    foc[F_Q_REF] = 0
    foc[F_D_REF] = current
    return current


@hot
def _ramp(foc, cfg: Ints, cal: Ints) -> int:
    """Let the current grow while the field comes from a quarter turn back: no rotor stands exactly against both."""
    cal[C_ANGLE] = (cal[C_TICKS] << 6) - 16384
    _force(foc, cal, cfg[K_CAL_CURRENT] * cal[C_TICKS] >> _RAMP_SHIFT)
    if cal[C_TICKS] >> _RAMP_SHIFT:
        _next(cal, PHASE_SETTLE)
    return cal[C_PHASE]


@hot
def _settle(foc: Ints, cfg: Ints, io: Ints, cal: Ints) -> int:
    """Wait until the rotor has found the field, then check the current and start to turn."""
    wanted = _force(foc, cal, cfg[K_CAL_CURRENT])
    if cal[C_TICKS] < _SETTLE_TICKS:
        return PHASE_SETTLE
    missing = wanted - foc[F_I_D]
    if missing > wanted >> 2 or missing < -(wanted >> 2):
        return _refuse(cal, FAULT_CAL_NO_CURRENT, foc[F_I_D])
    wrong = current_sum(foc)
    if wrong > cfg[K_SUM_LIMIT] or wrong < -cfg[K_SUM_LIMIT]:
        return _refuse(cal, FAULT_CAL_SUM, wrong)
    cal[C_LAST] = foc[F_ROTOR]
    cal[C_JOINT_LAST] = io[IO_JOINT_RAW]
    return _next(cal, PHASE_FORWARD)


@hot
def _turn(foc: Ints, cfg: Ints, io: Ints, cal: Ints) -> int:
    """Turn the field by one step, follow the encoders, and close the way when its end is reached."""
    cal[C_MOVED] += wrap_count(foc[F_ROTOR] - cal[C_LAST])
    cal[C_LAST] = foc[F_ROTOR]
    cal[C_JOINT_MOVED] += wrap_count(io[IO_JOINT_RAW] - cal[C_JOINT_LAST])
    cal[C_JOINT_LAST] = io[IO_JOINT_RAW]
    if cal[C_PHASE] >= PHASE_AGAIN:
        _sample_offset(foc, cal)
    travel = _SMALL_TRAVEL
    step = _SMALL_STEP
    if cal[C_KIND] == CAL_FULL:
        travel = _FULL_TRAVEL
        step = _FULL_STEP
    if cal[C_PHASE] == PHASE_BACK or cal[C_PHASE] == PHASE_RETURN:
        step = -step
    if cal[C_ANGLE] + step < 0 or cal[C_ANGLE] + step > travel:
        return _end_way(foc, cfg, io, cal, travel)
    cal[C_ANGLE] += step
    return _force(foc, cal, cfg[K_CAL_CURRENT])


@hot
def _end_way(foc, cfg, io, cal: Ints, travel: int) -> int:
    phase = cal[C_PHASE]
    if phase == PHASE_FORWARD:
        cal[C_FORWARD] = cal[C_MOVED]
        cal[C_JOINT_FORWARD] = cal[C_JOINT_MOVED]
    if phase == PHASE_BACK:
        _find_direction(cfg, cal, travel)
        _check_joint_encoder(cfg, io, cal)
        if cal[C_PHASE] == PHASE_IDLE:
            return PHASE_IDLE
    if phase == PHASE_RETURN:
        return _finish(foc, cfg, io, cal)
    return _next(cal, phase + 1)


@hot
def _find_direction(cfg: Ints, cal: Ints, travel: int) -> int:
    """Direction and pole pairs from the first way, which must have come back to where it began."""
    moved = cal[C_FORWARD]
    cal[C_DIRECTION] = 1
    if moved < 0:
        cal[C_DIRECTION] = -1
        moved = -moved
    left = cal[C_MOVED]
    if moved < 64 or left > moved >> 2 or left < -(moved >> 2):
        return _refuse(cal, FAULT_CAL_NOT_FREE, cal[C_FORWARD])
    pairs = (travel + moved + moved) // (moved << 2)
    if cal[C_KIND] == CAL_FULL:
        rest = travel - 4 * pairs * moved
        if rest > moved or rest < -moved or pairs < 1 or pairs > _POLE_PAIRS_MOST:
            return _refuse(cal, FAULT_CAL_POLE_PAIRS, pairs)
        if cfg[K_POLE_PAIRS] != 0 and cfg[K_POLE_PAIRS] != pairs:
            return _refuse(cal, FAULT_CAL_POLE_PAIRS, pairs)
    else:
        pairs = cfg[K_POLE_PAIRS]
        rest = travel - 4 * pairs * moved
        if rest > travel >> 2 or rest < -(travel >> 2):
            return _refuse(cal, FAULT_CAL_NOT_FREE, cal[C_FORWARD])
    cal[C_POLE_PAIRS] = pairs
    if cal[C_KIND] == CAL_VERIFY and cal[C_DIRECTION] != cfg[K_DIRECTION]:
        return _refuse(cal, FAULT_CAL_PHASE_ORDER, cal[C_DIRECTION])
    return FAULT_NONE


@hot
def _check_joint_encoder(cfg: Ints, io: Ints, cal: Ints) -> int:
    """The joint must have moved by the rotor's way through the gear, within a quarter and 8 counts."""
    if cfg[K_HAS_JOINT_ENCODER] == 0 or cfg[K_GEAR_Q8] < 1:
        return 0
    moved = cal[C_JOINT_FORWARD]
    if moved < 0:
        moved = -moved
    expected = (cal[C_FORWARD] * cal[C_DIRECTION] << 8) // cfg[K_GEAR_Q8]
    error = moved - expected
    if io[IO_JOINT_VALID] == 0 or error > (expected >> 2) + 8 or error < -(expected >> 2) - 8:
        return _refuse(cal, FAULT_CAL_JOINT_ENCODER, cal[C_JOINT_FORWARD])
    return 0


@hot
def _sample_offset(foc: Ints, cal: Ints) -> int:
    """Add one sample of field angle minus rotor angle, relative to the first."""
    offset = cal[C_ANGLE] - 4 * cal[C_POLE_PAIRS] * cal[C_DIRECTION] * foc[F_ROTOR]
    if cal[C_COUNT] == 0:
        cal[C_REFERENCE] = offset & 0xFFFF
    offset = ((offset - cal[C_REFERENCE] + 0x8000) & 0xFFFF) - 0x8000
    cal[C_SUM] += offset
    cal[C_COUNT] += 1
    if offset < cal[C_LOW]:
        cal[C_LOW] = offset
    if offset > cal[C_HIGH]:
        cal[C_HIGH] = offset
    return offset


@hot
def _finish(foc, cfg: Ints, io, cal: Ints) -> int:
    """Check the offsets' spread, then write everything found, or compare it."""
    spread = cal[C_HIGH] - cal[C_LOW]
    if spread > _SPREAD_MOST or cal[C_COUNT] < 1:
        return _refuse(cal, FAULT_CAL_SPREAD, spread)
    cal[C_OFFSET] = (cal[C_REFERENCE] + cal[C_SUM] // cal[C_COUNT]) & 0xFFFF
    if cal[C_KIND] == CAL_VERIFY:
        change = ((cal[C_OFFSET] - cfg[K_ELEC_OFFSET] + 0x8000) & 0xFFFF) - 0x8000
        if change > cfg[K_VERIFY] or change < -cfg[K_VERIFY]:
            return _refuse(cal, FAULT_CAL_OFFSET_CHANGED, change)
        return _next(cal, PHASE_IDLE)
    cfg[K_ELEC_OFFSET] = cal[C_OFFSET]
    cfg[K_DIRECTION] = cal[C_DIRECTION]
    cfg[K_POLE_PAIRS] = cal[C_POLE_PAIRS]
    cfg[K_CALIBRATED] = 1
    if cfg[K_HAS_JOINT_ENCODER]:
        same = cal[C_FORWARD] ^ cal[C_JOINT_FORWARD]
        cfg[K_JOINT_ENCODER_SIGN] = cfg[K_JOINT_SIGN]
        if same < 0:
            cfg[K_JOINT_ENCODER_SIGN] = -cfg[K_JOINT_SIGN]
    if cal[C_POSE_GIVEN]:
        set_zeros(cfg, cal)
    return _next(cal, PHASE_IDLE)


@hot
def set_zeros(cfg: Ints, cal: Ints) -> int:
    """Set both encoders' zeros from the pose C_POSE at which they read C_REST_ROTOR and C_REST_JOINT; return K_ZERO.

    The joint encoder's zero is rounded to its count: the rotor's is exact.
    """
    cfg[K_ZERO] = (cal[C_REST_ROTOR] - cal[C_POSE] * cfg[K_JOINT_SIGN]) & 16383
    if cfg[K_HAS_JOINT_ENCODER] and cfg[K_GEAR_Q8] > 0:
        half = cfg[K_GEAR_Q8] >> 1
        angle = ((cal[C_POSE] << 8) + half) // cfg[K_GEAR_Q8]
        cfg[K_JOINT_ENCODER_ZERO] = (cal[C_REST_JOINT] - angle * cfg[K_JOINT_ENCODER_SIGN]) & 16383
    return cfg[K_ZERO]
