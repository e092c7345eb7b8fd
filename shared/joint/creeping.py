"""Commissioning's fifth part: the rotor creeps to and fro, and a table records the current at each place.

Strong cogging would let the rotor hop from tooth to tooth, and a load behind the gear's play would swing against it, so
the rotor creeps slowly and a field holds it (holding.py). A short round covers two electrical turns to and fro, for
multiples of the poles: these waves repeat with each pole, so the table is one pole long. A whole round covers the whole
turn. To check waves, the velocity loop alone turns the rotor, twice as fast, and the table records its speed. waves.py
chooses the rounds.
"""

from ..num.fixed import saturate
from ..runtime import const, hot
from .cascade import write_current
from .commission_state import COGGING_BINS, PHASE_CREEP, PHASE_IDLE, PHASE_ROUND, STEPS, Commission, begin_phase, fail
from .commutation import follow_rotor
from .faults import FAULT_COMMISSION_COGGING
from .holding import hold_rotor, turning_current
from .layout import CurrentLoop, JointIo, JointSettings, JointState
from .play import add_play, find_play, follow_joint
from .probe import probe_begin
from .spectrum import add_to_table, clear_table
from .spinning import swing
from .swinging import ask_rate, follow_rate

CREEP_SHORT = const(0)  # over two electrical turns, held by a field
CREEP_WHOLE = const(1)  # likewise over the whole turn
CREEP_WITHOUT = const(2)  # over two electrical turns by the velocity loop alone, without the waves
CREEP_WITH = const(3)  # likewise with them

_HALF_TURN = const(8192)  # rc from the middle
_SHORT = const(16384)  # rc from the middle, over the pole pairs: two electrical turns in all
_MARGIN = const(320)  # rc beyond it: 7 degrees of the rotor in which to turn round
_TICKS_MOST = const(20000)  # of a round
_PAIRS_QUICK = const(14)  # with more, a whole round creeps faster, to limit its time
_CHANGE_MOST = const(511)  # rc/tick^2, of two ticks
_CURRENT_MOST = const(0x7FFFF)  # cu, times 10
_MOVED_MOST = const(1023)


@hot
def begin_round(loop: CurrentLoop, settings: JointSettings, commission: Commission, part: int) -> None:
    """Begin a round CREEP_*; six waves per pole pair pass at 0.44 of the velocity loop's bandwidth."""
    pairs = saturate(commission.pole_pairs, 1, 50)
    rate = settings.velocity_w * 3 // (4 * pairs) + 1
    far = _SHORT // saturate(pairs, 2, 50)
    table_repeats = 1
    phase = PHASE_CREEP
    if part == CREEP_SHORT:
        table_repeats = pairs + pairs
        if pairs <= _PAIRS_QUICK:
            rate = rate * 5 >> 3
    elif part == CREEP_WHOLE:
        rate = settings.velocity_w * 3 // (2 * saturate(pairs, 1, _PAIRS_QUICK)) + 1
        far = _HALF_TURN
        phase = PHASE_ROUND
    else:
        rate = rate << 1
    commission.creep_part = part
    commission.swing_rate = rate
    commission.swing_acceleration = (rate >> 4) + 1
    commission.creep_far = far
    commission.half_swings = 0
    if phase == PHASE_CREEP and commission.swing_position * commission.sign < 0 - far:
        commission.half_swings = 1
    commission.play_sum = 0
    clear_table(commission, table_repeats)
    probe_begin(loop, 1)
    begin_phase(commission, phase)


@hot
def creep_round(
    loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, commission: Commission
) -> int:
    """Do one tick of a round; return 1 when it is over: there and back since the rotor first turned round."""
    d = loop.sum_current_d
    current = loop.sum_current_q
    probe_begin(loop, 1)
    moved = swing(loop, state, commission)
    follow_joint(io, commission)
    if loop.electrical_gain == 0:
        current = turning_current(settings, commission, d, current, loop.rotor, moved)
    far = commission.creep_far
    if commission.swing_position * commission.sign > far + _MARGIN:
        commission.sign = 0 - commission.sign
        commission.half_swings += 1
    _creep(loop, settings, state, commission)
    if commission.phase_ticks > _TICKS_MOST:
        fail(commission, FAULT_COMMISSION_COGGING, loop.reference_q)
    if commission.reason:
        return 0
    _take_in(loop, settings, commission, current, saturate(moved, -_MOVED_MOST, _MOVED_MOST))
    if commission.half_swings <= 2:
        return 0
    if commission.creep_part < CREEP_WITHOUT:
        follow_rotor(loop, state, commission)
        find_play(settings, commission)
        if commission.phase == PHASE_IDLE:  # too much of it: refused
            return 0
    return 1


@hot
def stand_still(
    loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, commission: Commission
) -> None:
    """Let the rotor stand for a tick, while the table is searched."""
    probe_begin(loop, 1)
    swing(loop, state, commission)
    follow_joint(io, commission)
    rate = commission.swing_rate
    commission.swing_rate = 0
    follow_rate(loop, settings, state, commission)
    commission.swing_rate = rate


@hot
def _creep(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> int:
    """Turn the rotor on, faster on the way to where the round begins; from there a field holds it, but in a check."""
    far = commission.creep_far
    rate = commission.swing_rate
    at = commission.swing_position * commission.sign
    if commission.creep_part >= CREEP_WITHOUT and at < 0 - far - _MARGIN:
        commission.swing_rate += rate >> 1
    elif commission.half_swings == 0 and at < far - _MARGIN:
        commission.swing_rate = rate * 3
    ask_rate(settings, state, commission)
    commission.swing_rate = rate
    if commission.creep_part >= CREEP_WITHOUT or commission.half_swings < 1:
        return write_current(loop, settings, state)
    if loop.electrical_gain and commission.swing_reference * commission.sign < 0:  # not before its first standstill
        return write_current(loop, settings, state)
    return hold_rotor(loop, settings, state, commission)


@hot
def _take_in(loop: CurrentLoop, settings: JointSettings, commission: Commission, current: int, moved: int) -> None:
    """Add the tick before, whose acceleration is known only now, to the table and the play."""
    far = commission.creep_far
    if commission.half_swings > 0 and commission.swing_position < far and commission.swing_position >= 0 - far:
        add_to_table(commission, _ripple_or_current(commission, moved - commission.moved_before))
        add_play(settings, commission, commission.moved_last)
    commission.moved_before = commission.moved_last
    commission.moved_last = moved
    commission.current_last = current
    commission.bin_last = (loop.rotor * commission.table_repeats >> 5) & (COGGING_BINS - 1)


@hot
def _ripple_or_current(commission: Commission, change: int) -> int:
    """Return the value to add up for the tick before: in a check, the rotor's rate above the wanted one.

    Else the current that the motion alone took, times 10, less the acceleration's; ``change``: of the way in two ticks.
    """
    if commission.creep_part >= CREEP_WITHOUT:
        speed = commission.moved_last * commission.sign << 8
        return saturate(speed - commission.swing_rate, -_CURRENT_MOST, _CURRENT_MOST)
    taken = (saturate(commission.inertia, 0, 0x3FFFF) * saturate(change, -_CHANGE_MOST, _CHANGE_MOST) >> 5) * STEPS
    return saturate(commission.current_last - taken, -_CURRENT_MOST, _CURRENT_MOST)
