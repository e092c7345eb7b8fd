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
from .layout import CurrentLoop, JointIo, JointSettings, JointState
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
def set_commutation(loop: CurrentLoop, settings: JointSettings) -> int:
    """Hand the stored direction, pole pairs and offset to the current step; return electrical_gain."""
    loop.electrical_offset = settings.elec_offset + TABLE_HALF_STEP
    loop.electrical_gain = 4 * settings.pole_pairs * settings.direction
    return loop.electrical_gain


@hot
def calibration_start(calibration: Calibration, kind: int) -> int:
    """Begin a calibration of ``kind`` with the next tick; return PHASE_REST. pose_given and pose are the caller's."""
    calibration.kind = kind
    calibration.reason = FAULT_NONE
    calibration.reason_value = 0
    calibration.angle = 0
    calibration.moved = 0
    calibration.rotor_last = 0
    calibration.joint_moved = 0
    calibration.joint_last = 0
    calibration.moved_forward = 0
    calibration.joint_moved_forward = 0
    calibration.direction = 0
    calibration.pole_pairs = 0
    calibration.offset_reference = 0
    calibration.offset_sum = 0
    calibration.offset_count = 0
    calibration.offset_low = 0
    calibration.offset_high = 0
    for phase in range(3):
        calibration.raw_sum[phase] = 0
    for at in range(4):
        calibration.lowest[at] = 0xFFFF
        calibration.highest[at] = -0xFFFF
    return _next(calibration, PHASE_REST)


@hot
def calibration_abort(loop: CurrentLoop, settings: JointSettings, calibration: Calibration) -> int:
    """End a calibration without a result, restore the commutation and the references; return PHASE_IDLE."""
    calibration.phase = PHASE_IDLE
    calibration.kind = 0
    loop.reference_d = 0
    loop.reference_q = 0
    set_commutation(loop, settings)
    return PHASE_IDLE


@hot
def calibration_needs_bridge(calibration: Calibration) -> int:
    """Return 1 while the field is on, 0 at rest and when idle: the bridge is off then."""
    if calibration.phase > PHASE_REST:
        return 1
    return 0


@hot
def calibration_step(
    loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, calibration: Calibration
) -> int:
    """Do one tick; return the phase, PHASE_IDLE when over. Then ``reason`` is 0 or says what stood against it.

    About 18 s for a full one, 5 s for a small one.
    """
    phase = calibration.phase
    if phase == PHASE_IDLE:
        return PHASE_IDLE
    calibration.phase_ticks += 1
    if phase == PHASE_REST:
        _rest(loop, settings, state, io, calibration)
    elif phase == PHASE_RAMP:
        _ramp(loop, settings, calibration)
    elif phase == PHASE_SETTLE:
        _settle(loop, settings, io, calibration)
    else:
        _turn(loop, settings, io, calibration)
    if calibration.phase == PHASE_IDLE:
        calibration_abort(loop, settings, calibration)
    return calibration.phase


@hot
def _refuse(calibration: Calibration, reason: int, value: int) -> int:
    """End with a reason, unless there is one already."""
    if calibration.reason == FAULT_NONE:
        calibration.reason = reason
        calibration.reason_value = value
    calibration.phase = PHASE_IDLE
    return reason


@hot
def _next(calibration: Calibration, phase: int) -> int:
    calibration.phase = phase
    calibration.phase_ticks = 0
    return phase


@hot
def _extremes(calibration: Calibration, place: int, value: int) -> int:
    """Take in a value of the lowest and highest at ``place``; return how far apart these are."""
    if value < calibration.lowest[place]:
        calibration.lowest[place] = value
    if value > calibration.highest[place]:
        calibration.highest[place] = value
    return calibration.highest[place] - calibration.lowest[place]


@hot
def _rest(loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, calibration: Calibration) -> int:
    """Collect 256 readings with the bridge off, then check them and set the current offsets."""
    if calibration.phase_ticks == 1:
        calibration.rest_rotor = loop.rotor
        calibration.rest_joint = io.joint_raw
    for phase in range(3):
        raw = loop.raw[phase]
        calibration.raw_sum[phase] = calibration.raw_sum[phase] + raw
        _extremes(calibration, phase, raw)
    _extremes(calibration, _ROTOR, wrap_count(loop.rotor - calibration.rest_rotor))
    if calibration.phase_ticks >> _REST_SHIFT == 0:
        return PHASE_REST
    _check_rest(settings, state, calibration)
    if calibration.phase == PHASE_IDLE:
        return PHASE_IDLE
    shift = _REST_SHIFT - 4
    set_offsets(loop, calibration.raw_sum[0] >> shift, calibration.raw_sum[1] >> shift, calibration.raw_sum[2] >> shift)
    current_relax(loop)
    return _next(calibration, PHASE_RAMP)


@hot
def _check_rest(settings: JointSettings, state: JointState, calibration: Calibration) -> int:
    """Return FAULT_NONE if the currents, the supply and the rotor at rest are fit, else the first fault."""
    for phase in range(3):
        offset = calibration.raw_sum[phase] >> _REST_SHIFT
        if offset > 2048 + settings.offset_spread or offset < 2048 - settings.offset_spread:
            return _refuse(calibration, FAULT_CAL_OFFSET, offset)
        noise = calibration.highest[phase] - calibration.lowest[phase]
        if noise > _NOISE_MOST:
            return _refuse(calibration, FAULT_CAL_NOISE, noise)
    if state.bus < settings.cal_bus_least or state.bus > settings.cal_bus_most:
        return _refuse(calibration, FAULT_CAL_BUS, state.bus)
    if state.rate > settings.stall_rate or state.rate < -settings.stall_rate:
        return _refuse(calibration, FAULT_CAL_MOVING, state.rate)
    noise = calibration.highest[_ROTOR] - calibration.lowest[_ROTOR]
    if noise > _ENCODER_NOISE_MOST:
        return _refuse(calibration, FAULT_CAL_ENCODER, noise)
    return FAULT_NONE


@hot
def _force(loop: CurrentLoop, calibration: Calibration, current: int) -> int:
    """Point the field at calibration.angle with ``current`` on d, whatever the encoder says."""
    loop.electrical_gain = 0
    loop.electrical_offset = (calibration.angle & 0xFFFF) + TABLE_HALF_STEP
    loop.feed_d = 0
    loop.feed_q = 0
    loop.reference_q = 0
    loop.reference_d = current
    return current


@hot
def _ramp(loop: CurrentLoop, settings: JointSettings, calibration: Calibration) -> int:
    """Let the current grow while the field comes from a quarter turn back: no rotor stands exactly against both."""
    calibration.angle = (calibration.phase_ticks << 6) - 16384
    _force(loop, calibration, settings.cal_current * calibration.phase_ticks >> _RAMP_SHIFT)
    if calibration.phase_ticks >> _RAMP_SHIFT:
        _next(calibration, PHASE_SETTLE)
    return calibration.phase


@hot
def _settle(loop: CurrentLoop, settings: JointSettings, io: JointIo, calibration: Calibration) -> int:
    """Wait until the rotor has found the field, then check the current and start to turn."""
    wanted = _force(loop, calibration, settings.cal_current)
    if calibration.phase_ticks < _SETTLE_TICKS:
        return PHASE_SETTLE
    missing = wanted - loop.current_d
    if missing > wanted >> 2 or missing < -(wanted >> 2):
        return _refuse(calibration, FAULT_CAL_NO_CURRENT, loop.current_d)
    wrong = current_sum(loop)
    if wrong > settings.sum_limit or wrong < -settings.sum_limit:
        return _refuse(calibration, FAULT_CAL_SUM, wrong)
    calibration.rotor_last = loop.rotor
    calibration.joint_last = io.joint_raw
    return _next(calibration, PHASE_FORWARD)


@hot
def _turn(loop: CurrentLoop, settings: JointSettings, io: JointIo, calibration: Calibration) -> int:
    """Turn the field by one step, follow the encoders, and close the way when its end is reached."""
    calibration.moved += wrap_count(loop.rotor - calibration.rotor_last)
    calibration.rotor_last = loop.rotor
    calibration.joint_moved += wrap_count(io.joint_raw - calibration.joint_last)
    calibration.joint_last = io.joint_raw
    if calibration.phase >= PHASE_AGAIN:
        _sample_offset(loop, calibration)
    travel = _SMALL_TRAVEL
    step = _SMALL_STEP
    if calibration.kind == CAL_FULL:
        travel = _FULL_TRAVEL
        step = _FULL_STEP
    if calibration.phase == PHASE_BACK or calibration.phase == PHASE_RETURN:
        step = -step
    if calibration.angle + step < 0 or calibration.angle + step > travel:
        return _end_sweep(loop, settings, io, calibration, travel)
    calibration.angle += step
    return _force(loop, calibration, settings.cal_current)


@hot
def _end_sweep(loop: CurrentLoop, settings: JointSettings, io: JointIo, calibration: Calibration, travel: int) -> int:
    phase = calibration.phase
    if phase == PHASE_FORWARD:
        calibration.moved_forward = calibration.moved
        calibration.joint_moved_forward = calibration.joint_moved
    if phase == PHASE_BACK:
        _find_direction(settings, calibration, travel)
        _check_joint_encoder(settings, io, calibration)
        if calibration.phase == PHASE_IDLE:
            return PHASE_IDLE
    if phase == PHASE_RETURN:
        return _finish(loop, settings, io, calibration)
    return _next(calibration, phase + 1)


@hot
def _find_direction(settings: JointSettings, calibration: Calibration, travel: int) -> int:
    """Direction and pole pairs from the first way, which must have come back to where it began."""
    moved = calibration.moved_forward
    calibration.direction = 1
    if moved < 0:
        calibration.direction = -1
        moved = -moved
    left = calibration.moved
    if moved < 64 or left > moved >> 2 or left < -(moved >> 2):
        return _refuse(calibration, FAULT_CAL_NOT_FREE, calibration.moved_forward)
    pairs = (travel + moved + moved) // (moved << 2)
    if calibration.kind == CAL_FULL:
        rest = travel - 4 * pairs * moved
        if rest > moved or rest < -moved or pairs < 1 or pairs > _POLE_PAIRS_MOST:
            return _refuse(calibration, FAULT_CAL_POLE_PAIRS, pairs)
        if settings.pole_pairs != 0 and settings.pole_pairs != pairs:
            return _refuse(calibration, FAULT_CAL_POLE_PAIRS, pairs)
    else:
        pairs = settings.pole_pairs
        rest = travel - 4 * pairs * moved
        if rest > travel >> 2 or rest < -(travel >> 2):
            return _refuse(calibration, FAULT_CAL_NOT_FREE, calibration.moved_forward)
    calibration.pole_pairs = pairs
    if calibration.kind == CAL_VERIFY and calibration.direction != settings.direction:
        return _refuse(calibration, FAULT_CAL_PHASE_ORDER, calibration.direction)
    return FAULT_NONE


@hot
def _check_joint_encoder(settings: JointSettings, io: JointIo, calibration: Calibration) -> int:
    """The joint must have moved by the rotor's way through the gear, within a quarter and 8 counts."""
    if settings.has_joint_encoder == 0 or settings.gear_q8 < 1:
        return 0
    moved = calibration.joint_moved_forward
    if moved < 0:
        moved = -moved
    expected = (calibration.moved_forward * calibration.direction << 8) // settings.gear_q8
    error = moved - expected
    if io.joint_valid == 0 or error > (expected >> 2) + 8 or error < -(expected >> 2) - 8:
        return _refuse(calibration, FAULT_CAL_JOINT_ENCODER, calibration.joint_moved_forward)
    return 0


@hot
def _sample_offset(loop: CurrentLoop, calibration: Calibration) -> int:
    """Add one sample of field angle minus rotor angle, relative to the first."""
    offset = calibration.angle - 4 * calibration.pole_pairs * calibration.direction * loop.rotor
    if calibration.offset_count == 0:
        calibration.offset_reference = offset & 0xFFFF
    offset = ((offset - calibration.offset_reference + 0x8000) & 0xFFFF) - 0x8000
    calibration.offset_sum += offset
    calibration.offset_count += 1
    if offset < calibration.offset_low:
        calibration.offset_low = offset
    if offset > calibration.offset_high:
        calibration.offset_high = offset
    return offset


@hot
def _finish(loop: CurrentLoop, settings: JointSettings, io: JointIo, calibration: Calibration) -> int:
    """Check the offsets' spread, then write everything found, or compare it."""
    spread = calibration.offset_high - calibration.offset_low
    if spread > _SPREAD_MOST or calibration.offset_count < 1:
        return _refuse(calibration, FAULT_CAL_SPREAD, spread)
    calibration.offset_found = (
        calibration.offset_reference + calibration.offset_sum // calibration.offset_count
    ) & 0xFFFF
    if calibration.kind == CAL_VERIFY:
        change = ((calibration.offset_found - settings.elec_offset + 0x8000) & 0xFFFF) - 0x8000
        if change > settings.verify or change < -settings.verify:
            return _refuse(calibration, FAULT_CAL_OFFSET_CHANGED, change)
        return _next(calibration, PHASE_IDLE)
    settings.elec_offset = calibration.offset_found
    settings.direction = calibration.direction
    settings.pole_pairs = calibration.pole_pairs
    settings.calibrated = 1
    if settings.has_joint_encoder:
        same = calibration.moved_forward ^ calibration.joint_moved_forward
        settings.joint_encoder_sign = settings.joint_sign
        if same < 0:
            settings.joint_encoder_sign = -settings.joint_sign
    if calibration.pose_given:
        set_zeros(settings, calibration)
    return _next(calibration, PHASE_IDLE)


@hot
def set_zeros(settings: JointSettings, calibration: Calibration) -> int:
    """Set both encoders' zeros from the pose at which they read rest_rotor and rest_joint; return settings.zero.

    The joint encoder's zero is rounded to its count: the rotor's is exact.
    """
    settings.zero = (calibration.rest_rotor - calibration.pose * settings.joint_sign) & 16383
    if settings.has_joint_encoder and settings.gear_q8 > 0:
        half = settings.gear_q8 >> 1
        angle = ((calibration.pose << 8) + half) // settings.gear_q8
        settings.joint_encoder_zero = (calibration.rest_joint - angle * settings.joint_encoder_sign) & 16383
    return settings.zero
