"""Calibration: current offsets, rotor offset, direction, pole pairs and the joint encoder's sign, found tick by tick.

    rest (bridge off) -> ramp and settle on d current -> turn the field forward and back -> again -> done

At rest it checks current offsets and noise, bus voltage, encoder noise, no motion; on the field the
current reached, the sum of the phases and that the rotor follows. The first way forward and back
gives direction, pole pairs and the joint encoder's sign, the second the offset as the mean of both
ways, in which friction cancels. What is found is written only when everything is. Reasons are FAULT_CAL_*.

Kinds: full turns the field four electrical turns; small, for an assembled leg, half a turn with the
pole pairs known (1.2 deg at a 22:1 joint with 7); verify is small, changes nothing and compares.
"""

from ..record import field, record, vector
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
from .layout import Foc, JointConfig, JointIo, JointState
from .sine import TABLE_HALF_STEP

CAL_FULL = const(1)
CAL_SMALL = const(2)
CAL_VERIFY = const(3)


@record
class Calibration:
    """A calibration under way and what it found, or the reason of the last one."""

    kind: int = field("", "CAL_*, 0 while none is running")
    phase: int = field("", "PHASE_*")
    phase_ticks: int = field("ticks", "since this phase began")
    reason: int = field("", "FAULT_CAL_* of the last one, 0 if it succeeded")
    reason_value: int = field("", "in the unit of that fault")
    angle: int = field("brad", "angle of the field, not wrapped")
    moved: int = field("rc", "rotor since the settled position")
    rotor_last: int = field("rc", "rotor in the tick before")
    joint_moved: int = field("1/16384 joint turn", "joint since the settled position")
    joint_last: int = field("1/16384 joint turn", "joint encoder in the tick before")
    moved_forward: int = field("rc", "rotor on the first way forward")
    joint_moved_forward: int = field("1/16384 joint turn", "joint on the first way forward")
    direction: int = field("", "found: +-1")
    pole_pairs: int = field("", "found")
    offset_reference: int = field("brad", "first electrical offset seen")
    offset_sum: int = field("brad", "of the offsets relative to it")
    offset_count: int = field("", "how many these are")
    offset_low: int = field("brad", "least of them")
    offset_high: int = field("brad", "largest of them")
    raw_sum: Ints = vector(3, "count", "phases a, b, c at rest, summed")
    lowest: Ints = vector(4, "", "at rest, of phases a, b, c in counts and of the rotor in rc")
    highest: Ints = vector(4, "", "likewise")
    pose_given: int = field("", "1: the joint stands at pose when calibration starts")
    pose: int = field("rc", "joint-signed")
    rest_rotor: int = field("rc", "rotor when calibration started")
    rest_joint: int = field("1/16384 joint turn", "joint encoder when calibration started")
    offset_found: int = field("brad", "electrical offset found")


PHASE_IDLE = const(0)
PHASE_REST = const(1)
PHASE_RAMP = const(2)
PHASE_SETTLE = const(3)
PHASE_FORWARD = const(4)
PHASE_BACK = const(5)
PHASE_AGAIN = const(6)
PHASE_RETURN = const(7)

_ROTOR = const(3)  # its place in lowest and highest, behind the phases
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
def set_commutation(foc: Foc, cfg: JointConfig) -> int:
    """Hand the stored direction, pole pairs and offset to the current step; return electrical_gain."""
    foc.electrical_offset = cfg.elec_offset + TABLE_HALF_STEP
    foc.electrical_gain = 4 * cfg.pole_pairs * cfg.direction
    return foc.electrical_gain


@hot
def calibration_start(cal: Calibration, kind: int) -> int:
    """Begin a calibration of ``kind`` with the next tick; return PHASE_REST. pose_given and pose are the caller's."""
    cal.kind = kind
    cal.reason = FAULT_NONE
    cal.reason_value = 0
    cal.angle = 0
    cal.moved = 0
    cal.rotor_last = 0
    cal.joint_moved = 0
    cal.joint_last = 0
    cal.moved_forward = 0
    cal.joint_moved_forward = 0
    cal.direction = 0
    cal.pole_pairs = 0
    cal.offset_reference = 0
    cal.offset_sum = 0
    cal.offset_count = 0
    cal.offset_low = 0
    cal.offset_high = 0
    for phase in range(3):
        cal.raw_sum[phase] = 0
    for at in range(4):
        cal.lowest[at] = 0xFFFF
        cal.highest[at] = -0xFFFF
    return _next(cal, PHASE_REST)


@hot
def calibration_abort(foc: Foc, cfg: JointConfig, cal: Calibration) -> int:
    """End a calibration without a result, restore the commutation and the references; return PHASE_IDLE."""
    cal.phase = PHASE_IDLE
    cal.kind = 0
    foc.reference_d = 0
    foc.reference_q = 0
    set_commutation(foc, cfg)
    return PHASE_IDLE


@hot
def calibration_needs_bridge(cal: Calibration) -> int:
    """Return 1 while the field is on, 0 at rest and when idle: the bridge is off then."""
    if cal.phase > PHASE_REST:
        return 1
    return 0


@hot
def calibration_step(foc: Foc, cfg: JointConfig, state: JointState, io: JointIo, cal: Calibration) -> int:
    """Do one tick; return cal.phase, PHASE_IDLE when over. Then cal.reason is 0 or says what stood against it.

    About 18 s for a full one, 5 s for a small one.
    """
    phase = cal.phase
    if phase == PHASE_IDLE:
        return PHASE_IDLE
    cal.phase_ticks += 1
    if phase == PHASE_REST:
        _rest(foc, cfg, state, io, cal)
    elif phase == PHASE_RAMP:
        _ramp(foc, cfg, cal)
    elif phase == PHASE_SETTLE:
        _settle(foc, cfg, io, cal)
    else:
        _turn(foc, cfg, io, cal)
    if cal.phase == PHASE_IDLE:
        calibration_abort(foc, cfg, cal)
    return cal.phase


@hot
def _refuse(cal: Calibration, reason: int, value: int) -> int:
    """End with a reason, unless there is one already."""
    if cal.reason == FAULT_NONE:
        cal.reason = reason
        cal.reason_value = value
    cal.phase = PHASE_IDLE
    return reason


@hot
def _next(cal: Calibration, phase: int) -> int:
    cal.phase = phase
    cal.phase_ticks = 0
    return phase


@hot
def _extremes(cal: Calibration, place: int, value: int) -> int:
    """Take in a value of the lowest and highest at ``place``; return how far apart these are."""
    if value < cal.lowest[place]:
        cal.lowest[place] = value
    if value > cal.highest[place]:
        cal.highest[place] = value
    return cal.highest[place] - cal.lowest[place]


@hot
def _rest(foc: Foc, cfg: JointConfig, state: JointState, io: JointIo, cal: Calibration) -> int:
    """Collect 256 readings with the bridge off, then check them and set the current offsets."""
    if cal.phase_ticks == 1:
        cal.rest_rotor = foc.rotor
        cal.rest_joint = io.joint_raw
    for phase in range(3):
        raw = foc.raw[phase]
        cal.raw_sum[phase] = cal.raw_sum[phase] + raw
        _extremes(cal, phase, raw)
    _extremes(cal, _ROTOR, wrap_count(foc.rotor - cal.rest_rotor))
    if cal.phase_ticks >> _REST_SHIFT == 0:
        return PHASE_REST
    _check_rest(cfg, state, cal)
    if cal.phase == PHASE_IDLE:
        return PHASE_IDLE
    shift = _REST_SHIFT - 4
    set_offsets(foc, cal.raw_sum[0] >> shift, cal.raw_sum[1] >> shift, cal.raw_sum[2] >> shift)
    current_relax(foc)
    return _next(cal, PHASE_RAMP)


@hot
def _check_rest(cfg: JointConfig, state: JointState, cal: Calibration) -> int:
    """Return FAULT_NONE if the currents, the supply and the rotor at rest are fit, else the first fault."""
    for phase in range(3):
        offset = cal.raw_sum[phase] >> _REST_SHIFT
        if offset > 2048 + cfg.offset_spread or offset < 2048 - cfg.offset_spread:
            return _refuse(cal, FAULT_CAL_OFFSET, offset)
        noise = cal.highest[phase] - cal.lowest[phase]
        if noise > _NOISE_MOST:
            return _refuse(cal, FAULT_CAL_NOISE, noise)
    if state.bus < cfg.cal_bus_least or state.bus > cfg.cal_bus_most:
        return _refuse(cal, FAULT_CAL_BUS, state.bus)
    if state.rate > cfg.stall_rate or state.rate < -cfg.stall_rate:
        return _refuse(cal, FAULT_CAL_MOVING, state.rate)
    noise = cal.highest[_ROTOR] - cal.lowest[_ROTOR]
    if noise > _ENCODER_NOISE_MOST:
        return _refuse(cal, FAULT_CAL_ENCODER, noise)
    return FAULT_NONE


@hot
def _force(foc: Foc, cal: Calibration, current: int) -> int:
    """Point the field at cal.angle with ``current`` on d, whatever the encoder says."""
    foc.electrical_gain = 0
    foc.electrical_offset = (cal.angle & 0xFFFF) + TABLE_HALF_STEP
    foc.feed_d = 0
    foc.feed_q = 0
    foc.reference_q = 0
    foc.reference_d = current
    return current


@hot
def _ramp(foc: Foc, cfg: JointConfig, cal: Calibration) -> int:
    """Let the current grow while the field comes from a quarter turn back: no rotor stands exactly against both."""
    cal.angle = (cal.phase_ticks << 6) - 16384
    _force(foc, cal, cfg.cal_current * cal.phase_ticks >> _RAMP_SHIFT)
    if cal.phase_ticks >> _RAMP_SHIFT:
        _next(cal, PHASE_SETTLE)
    return cal.phase


@hot
def _settle(foc: Foc, cfg: JointConfig, io: JointIo, cal: Calibration) -> int:
    """Wait until the rotor has found the field, then check the current and start to turn."""
    wanted = _force(foc, cal, cfg.cal_current)
    if cal.phase_ticks < _SETTLE_TICKS:
        return PHASE_SETTLE
    missing = wanted - foc.current_d
    if missing > wanted >> 2 or missing < -(wanted >> 2):
        return _refuse(cal, FAULT_CAL_NO_CURRENT, foc.current_d)
    wrong = current_sum(foc)
    if wrong > cfg.sum_limit or wrong < -cfg.sum_limit:
        return _refuse(cal, FAULT_CAL_SUM, wrong)
    cal.rotor_last = foc.rotor
    cal.joint_last = io.joint_raw
    return _next(cal, PHASE_FORWARD)


@hot
def _turn(foc: Foc, cfg: JointConfig, io: JointIo, cal: Calibration) -> int:
    """Turn the field by one step, follow the encoders, and close the way when its end is reached."""
    cal.moved += wrap_count(foc.rotor - cal.rotor_last)
    cal.rotor_last = foc.rotor
    cal.joint_moved += wrap_count(io.joint_raw - cal.joint_last)
    cal.joint_last = io.joint_raw
    if cal.phase >= PHASE_AGAIN:
        _sample_offset(foc, cal)
    travel = _SMALL_TRAVEL
    step = _SMALL_STEP
    if cal.kind == CAL_FULL:
        travel = _FULL_TRAVEL
        step = _FULL_STEP
    if cal.phase == PHASE_BACK or cal.phase == PHASE_RETURN:
        step = -step
    if cal.angle + step < 0 or cal.angle + step > travel:
        return _end_sweep(foc, cfg, io, cal, travel)
    cal.angle += step
    return _force(foc, cal, cfg.cal_current)


@hot
def _end_sweep(foc: Foc, cfg: JointConfig, io: JointIo, cal: Calibration, travel: int) -> int:
    phase = cal.phase
    if phase == PHASE_FORWARD:
        cal.moved_forward = cal.moved
        cal.joint_moved_forward = cal.joint_moved
    if phase == PHASE_BACK:
        _find_direction(cfg, cal, travel)
        _check_joint_encoder(cfg, io, cal)
        if cal.phase == PHASE_IDLE:
            return PHASE_IDLE
    if phase == PHASE_RETURN:
        return _finish(foc, cfg, io, cal)
    return _next(cal, phase + 1)


@hot
def _find_direction(cfg: JointConfig, cal: Calibration, travel: int) -> int:
    """Direction and pole pairs from the first way, which must have come back to where it began."""
    moved = cal.moved_forward
    cal.direction = 1
    if moved < 0:
        cal.direction = -1
        moved = -moved
    left = cal.moved
    if moved < 64 or left > moved >> 2 or left < -(moved >> 2):
        return _refuse(cal, FAULT_CAL_NOT_FREE, cal.moved_forward)
    pairs = (travel + moved + moved) // (moved << 2)
    if cal.kind == CAL_FULL:
        rest = travel - 4 * pairs * moved
        if rest > moved or rest < -moved or pairs < 1 or pairs > _POLE_PAIRS_MOST:
            return _refuse(cal, FAULT_CAL_POLE_PAIRS, pairs)
        if cfg.pole_pairs != 0 and cfg.pole_pairs != pairs:
            return _refuse(cal, FAULT_CAL_POLE_PAIRS, pairs)
    else:
        pairs = cfg.pole_pairs
        rest = travel - 4 * pairs * moved
        if rest > travel >> 2 or rest < -(travel >> 2):
            return _refuse(cal, FAULT_CAL_NOT_FREE, cal.moved_forward)
    cal.pole_pairs = pairs
    if cal.kind == CAL_VERIFY and cal.direction != cfg.direction:
        return _refuse(cal, FAULT_CAL_PHASE_ORDER, cal.direction)
    return FAULT_NONE


@hot
def _check_joint_encoder(cfg: JointConfig, io: JointIo, cal: Calibration) -> int:
    """The joint must have moved by the rotor's way through the gear, within a quarter and 8 counts."""
    if cfg.has_joint_encoder == 0 or cfg.gear_q8 < 1:
        return 0
    moved = cal.joint_moved_forward
    if moved < 0:
        moved = -moved
    expected = (cal.moved_forward * cal.direction << 8) // cfg.gear_q8
    error = moved - expected
    if io.joint_valid == 0 or error > (expected >> 2) + 8 or error < -(expected >> 2) - 8:
        return _refuse(cal, FAULT_CAL_JOINT_ENCODER, cal.joint_moved_forward)
    return 0


@hot
def _sample_offset(foc: Foc, cal: Calibration) -> int:
    """Add one sample of field angle minus rotor angle, relative to the first."""
    offset = cal.angle - 4 * cal.pole_pairs * cal.direction * foc.rotor
    if cal.offset_count == 0:
        cal.offset_reference = offset & 0xFFFF
    offset = ((offset - cal.offset_reference + 0x8000) & 0xFFFF) - 0x8000
    cal.offset_sum += offset
    cal.offset_count += 1
    if offset < cal.offset_low:
        cal.offset_low = offset
    if offset > cal.offset_high:
        cal.offset_high = offset
    return offset


@hot
def _finish(foc: Foc, cfg: JointConfig, io: JointIo, cal: Calibration) -> int:
    """Check the offsets' spread, then write everything found, or compare it."""
    spread = cal.offset_high - cal.offset_low
    if spread > _SPREAD_MOST or cal.offset_count < 1:
        return _refuse(cal, FAULT_CAL_SPREAD, spread)
    cal.offset_found = (cal.offset_reference + cal.offset_sum // cal.offset_count) & 0xFFFF
    if cal.kind == CAL_VERIFY:
        change = ((cal.offset_found - cfg.elec_offset + 0x8000) & 0xFFFF) - 0x8000
        if change > cfg.verify or change < -cfg.verify:
            return _refuse(cal, FAULT_CAL_OFFSET_CHANGED, change)
        return _next(cal, PHASE_IDLE)
    cfg.elec_offset = cal.offset_found
    cfg.direction = cal.direction
    cfg.pole_pairs = cal.pole_pairs
    cfg.calibrated = 1
    if cfg.has_joint_encoder:
        same = cal.moved_forward ^ cal.joint_moved_forward
        cfg.joint_encoder_sign = cfg.joint_sign
        if same < 0:
            cfg.joint_encoder_sign = -cfg.joint_sign
    if cal.pose_given:
        set_zeros(cfg, cal)
    return _next(cal, PHASE_IDLE)


@hot
def set_zeros(cfg: JointConfig, cal: Calibration) -> int:
    """Set both encoders' zeros from the pose at which they read rest_rotor and rest_joint; return cfg.zero.

    The joint encoder's zero is rounded to its count: the rotor's is exact.
    """
    cfg.zero = (cal.rest_rotor - cal.pose * cfg.joint_sign) & 16383
    if cfg.has_joint_encoder and cfg.gear_q8 > 0:
        half = cfg.gear_q8 >> 1
        angle = ((cal.pose << 8) + half) // cfg.gear_q8
        cfg.joint_encoder_zero = (cal.rest_joint - angle * cfg.joint_encoder_sign) & 16383
    return cfg.zero
