"""Commissioning's second part: the field takes the rotor round once, back, and round again.

The first pass gives direction, pole pairs and the joint encoder's sign. On the other two, the angle between field and
rotor gives the offset, as the mean of both directions, in which friction cancels, and the eccentricity of the rotor
encoder, as the harmonics once and twice a turn. To verify, the field turns by half an electrical turn only.
"""

from ..num.fixed import cos_q15, hypot, saturate, sin_q15
from ..runtime import const, hot
from .commission_state import COMMISSION_FULL, PHASE_AGAIN, PHASE_BACK, PHASE_FORWARD, Commission, begin_phase, fail
from .commutation import point
from .encoder import wrap_count
from .faults import (
    FAULT_COMMISSION_END_STOP,
    FAULT_COMMISSION_FRICTION,
    FAULT_COMMISSION_JOINT_ENCODER,
    FAULT_COMMISSION_MAGNET,
    FAULT_COMMISSION_NOT_FREE,
    FAULT_COMMISSION_PHASE_ORDER,
    FAULT_COMMISSION_POLE_PAIRS,
    FAULT_NONE,
)
from .layout import CurrentLoop, JointIo, JointSettings
from .play import follow_joint

_TURN = const(16384)  # rc
_ELECTRICAL = const(0xFFFF)  # brad of an electrical turn, less one
_STEP = const(256)  # brad a tick: 3.9 electrical turns a second
_VERIFY_TRAVEL = const(32768)
_VERIFY_STEP = const(32)
_PAIRS_MOST = const(40)
_ERROR_MOST = const(16383)  # brad: a quarter of an electrical turn, beyond which no field holds a rotor
_LAG_MOST = const(5461)  # brad: 30 degrees, half of the commissioning current's torque
_BEND_MOST = const(2549)  # rc in Q4: 3.5 degrees


@hot
def turn_step(loop: CurrentLoop, settings: JointSettings, io: JointIo, commission: Commission) -> int:
    """Do one tick; return 1 when the last pass is done and its results are found."""
    step = _VERIFY_STEP
    if commission.kind == COMMISSION_FULL:
        step = _STEP
    if commission.phase == PHASE_FORWARD and commission.phase_ticks == 1:
        _begin(loop, io, commission)
    moved = wrap_count(loop.rotor - commission.rotor_last)
    commission.rotor_last = loop.rotor
    commission.moved += moved
    follow_joint(io, commission)
    if commission.phase == PHASE_FORWARD:
        _forward(loop, settings, io, commission, step)
        return 0
    if commission.phase == PHASE_BACK:
        moved = -moved
        step = -step
    _compare(loop, commission, moved * commission.direction)
    if commission.angle + step >= 0 and commission.angle + step <= commission.travel:
        commission.angle += step
        point(loop, commission)
        return 0
    return _end(settings, commission)


@hot
def _begin(loop: CurrentLoop, io: JointIo, commission: Commission) -> None:
    commission.start_rotor = loop.rotor
    commission.rotor_last = loop.rotor
    commission.joint_last = io.joint_raw
    commission.travel = (_PAIRS_MOST + 2) * (_ELECTRICAL + 1)
    if commission.kind != COMMISSION_FULL:
        commission.travel = _VERIFY_TRAVEL


@hot
def _forward(loop: CurrentLoop, settings: JointSettings, io: JointIo, commission: Commission, step: int) -> None:
    """Turn the field until the rotor has gone round, or the field has done its travel; check that the rotor follows."""
    moved = commission.moved
    if moved < 0:
        moved = -moved
    angle = commission.angle + step
    if moved < _TURN and angle <= commission.travel:
        commission.angle = angle
        point(loop, commission)
        if angle & _ELECTRICAL < step:
            _check_turn(commission, moved)
        return
    commission.travel = commission.angle
    commission.moved_forward = commission.moved
    commission.joint_moved_forward = commission.joint_moved
    commission.direction = 1
    if commission.moved < 0:
        commission.direction = -1
    if _check_pairs(settings, commission, moved) == 0 and _check_joint_encoder(settings, io, commission) == 0:
        begin_phase(commission, PHASE_BACK)


@hot
def _check_turn(commission: Commission, moved: int) -> None:
    """Check after each electrical turn that the rotor has moved on, at least half as far as in the first."""
    first = commission.moved_first
    if first == 0:
        commission.moved_first = moved
        if moved * _PAIRS_MOST < _TURN >> 1:
            fail(commission, FAULT_COMMISSION_NOT_FREE, commission.moved)
    elif moved - commission.moved_seen < first >> 1:
        fail(commission, FAULT_COMMISSION_END_STOP, commission.moved)
    commission.moved_seen = moved


@hot
def _check_pairs(settings: JointSettings, commission: Commission, moved: int) -> int:
    """Find the pole pairs, or check them and the direction against the stored ones; return 0 or what is wrong."""
    travel = commission.travel
    pairs = settings.pole_pairs
    if commission.kind == COMMISSION_FULL:
        pairs = (travel + moved + moved) // (moved << 2)
    commission.pole_pairs = pairs
    apart = moved + (moved >> 1)  # brad: 3/8 of an electrical turn, of which friction may take twice its lag
    rest = travel - 4 * pairs * moved
    if commission.kind != COMMISSION_FULL:
        if rest > travel >> 2 or rest < -(travel >> 2):
            return fail(commission, FAULT_COMMISSION_NOT_FREE, commission.moved)
        if commission.direction != settings.direction:
            return fail(commission, FAULT_COMMISSION_PHASE_ORDER, commission.direction)
    elif moved < _TURN or pairs < 1 or pairs > _PAIRS_MOST or rest > apart or rest < -apart:
        return fail(commission, FAULT_COMMISSION_POLE_PAIRS, commission.moved)
    return FAULT_NONE


@hot
def _check_joint_encoder(settings: JointSettings, io: JointIo, commission: Commission) -> int:
    """Check that the joint moved by the rotor's way through the gear, within a quarter and 8 counts."""
    if settings.has_joint_encoder == 0 or settings.gear_q8 < 1:
        return FAULT_NONE
    moved = commission.joint_moved_forward
    if moved < 0:
        moved = -moved
    expected = (commission.moved_forward * commission.direction << 8) // settings.gear_q8
    error = moved - expected
    if io.joint_valid == 0 or error > (expected >> 2) + 8 or error < -(expected >> 2) - 8:
        return fail(commission, FAULT_COMMISSION_JOINT_ENCODER, commission.joint_moved_forward)
    return 0


@hot
def _compare(loop: CurrentLoop, commission: Commission, way: int) -> None:
    """Add up field less rotor, times the rotor's ``way``, also with both harmonics.

    With this weight, what repeats many times a turn (cogging) does not disturb the harmonics. Two ways of 2^14 rc times
    2^14 brad: below 2^30.
    """
    error = commission.angle - 4 * commission.pole_pairs * commission.direction * commission.moved
    error = saturate(error, -_ERROR_MOST, _ERROR_MOST)
    commission.error_sum += error * way
    commission.error_way += way
    if commission.kind == COMMISSION_FULL:
        at = loop.rotor << 2
        _add_harmonic(commission, 0, at, error, way)
        _add_harmonic(commission, 2, at + at, error, way)


@hot
def _add_harmonic(commission: Commission, place: int, angle: int, error: int, way: int) -> None:
    sums = commission.harmonic_sum
    sums[place] = sums[place] + (error * cos_q15(angle) + 0x4000 >> 15) * way
    sums[place + 1] = sums[place + 1] + (error * sin_q15(angle) + 0x4000 >> 15) * way


@hot
def _end(settings: JointSettings, commission: Commission) -> int:
    """Go on with the next pass; after the last one find friction, offset and eccentricity, and return 1."""
    way = commission.error_way
    if way < 1:
        fail(commission, FAULT_COMMISSION_NOT_FREE, commission.moved)
        return 0
    mean = commission.error_sum // way
    if commission.phase == PHASE_BACK:
        quarter = commission.moved_forward * commission.direction >> 2
        if commission.moved > quarter or commission.moved < -quarter:
            fail(commission, FAULT_COMMISSION_NOT_FREE, commission.moved)
            return 0
        commission.mean_back = mean
        begin_phase(commission, PHASE_AGAIN)
        return 0
    commission.lag = mean - commission.mean_back  # half of (2 mean - back) - back
    if commission.lag > _LAG_MOST:
        fail(commission, FAULT_COMMISSION_FRICTION, commission.lag)
        return 0
    gain = 4 * commission.pole_pairs * commission.direction
    commission.offset_found = (mean - gain * commission.start_rotor) & 0xFFFF
    if commission.kind == COMMISSION_FULL:
        _find_bend(commission)
    if commission.reason:
        return 0
    return 1


@hot
def _find_bend(commission: Commission) -> None:
    """Find the eccentricity's harmonics."""
    scale = commission.error_way * commission.pole_pairs >> 3
    for at in range(4):
        found = commission.harmonic_sum[at] // scale
        commission.bend[at] = saturate(found, -4095, 4095) * commission.direction
    amplitude = hypot(commission.bend[0], commission.bend[1])
    if amplitude > _BEND_MOST:
        fail(commission, FAULT_COMMISSION_MAGNET, amplitude >> 4)
