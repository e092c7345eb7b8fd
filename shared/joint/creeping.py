"""Commissioning's fifth part: the rotor creeps to and fro, and the current that this takes tells the cogging.

At each of 512 places of a table the current, less what the rotor's own acceleration took, is added up over the way,
both ways: friction cancels, and so does what comes late. Strong cogging would let the rotor hop from tooth to tooth,
and a load behind the gear's play would swing against it, so it creeps slowly and a field holds it (holding.py).

First it creeps two electrical turns to and fro, for multiples of the poles: they repeat with each pole, and the table
is one pole long. The strongest wave of what it found acts on the next round. A wave that the next round finds again,
though another one or none acted before, is right and stays. Then the rotor creeps round the whole turn for the waves
that are no multiples of the poles.

All but that first wave are checked by what they are for, an even speed: to and fro without the field, first without and
then with them, each to take half of the speed's ripple away, so often a turn; what does not is dropped. So is what had
less ripple to take than the first wave leaves, or than half of what its current would make, and one that is less than
a sixteenth of the friction: friction makes such waves.
"""

from ..num.fixed import atan2_brad, hypot, ratio, saturate, wrap_brad
from ..runtime import const, hot
from .cascade import write_current
from .cogging import hold_waves, put_wave
from .commission_state import COGS, PHASE_CREEP, PHASE_ROUND, PHASE_WAVES, STEPS, Commission, go_on, refuse
from .commutation import follow_rotor
from .faults import FAULT_COMMISSION_COGGING
from .holding import find_flux_taken, hold_rotor, turning_current
from .layout import COSINE_AT, WAVES, CurrentLoop, JointIo, JointSettings, JointState
from .play import add_play, find_play, follow_joint
from .probe import probe_begin
from .spinning import swing
from .swinging import ask_rate, follow_rate

_HALF_TURN = const(8192)  # rc from the middle
_SHORT = const(16384)  # rc from the middle, over the pole pairs: two electrical turns in all
_MARGIN = const(320)  # rc beyond it: 7 degrees of the rotor to turn round in
_ROUNDS_MOST = const(4)  # until it creeps round the whole turn
_TICKS_MOST = const(20000)  # of a round
_SHORT_ROUNDS = const(0)  # Commission.creep_part
_WHOLE_ROUND = const(1)
_WITHOUT = const(2)
_WITH = const(3)
_LEFT_MOST = const(128)  # of the ripple, in 1/256
_SETTLED = const(2608)  # brad: a quarter of a rad, by which two rounds may differ
_PAIRS_QUICK = const(14)  # with more the whole turn is crept round faster, for the time that it takes
_ORDERS = const(12)  # times the pole pairs: the highest order looked for
_ORDER_MOST = const(250)  # with 512 places
_PLACES = const(128)  # of the table in a tick
_SINE_STEPS = const(1023)  # of the sine table, less one
_CHANGE_MOST = const(511)  # rc/tick^2, of two ticks
_CURRENT_MOST = const(0x7FFFF)  # cu, times 10
_MOVED_MOST = const(1023)
_TABLE_MOST = const(0x1FFFFFFF)


@hot
def creep_begin(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """Begin to creep without any waves; return PHASE_CREEP."""
    commission.creep_rounds = 0
    commission.creep_part = _SHORT_ROUNDS
    find_flux_taken(settings, commission)
    commission.creep_settled = 0
    for wave in range(WAVES):
        _drop(loop, commission, wave)
    return _round(loop, settings, commission, PHASE_CREEP)


@hot
def _round(loop: CurrentLoop, settings: JointSettings, commission: Commission, phase: int) -> int:
    """Begin a round at 0.44 of the velocity loop's bandwidth for six waves a pole pair, others twice as fast."""
    pairs = saturate(commission.pole_pairs, 1, 50)
    rate = settings.velocity_w * 3 // (4 * pairs) + 1
    if commission.creep_part >= _WITHOUT:
        rate = rate << 1
    elif phase == PHASE_CREEP and pairs <= _PAIRS_QUICK:
        rate = rate * 5 >> 3
    elif phase == PHASE_ROUND:
        rate = settings.velocity_w * 3 // (2 * saturate(pairs, 1, _PAIRS_QUICK)) + 1
    commission.swing_rate = rate
    commission.swing_acceleration = (rate >> 4) + 1
    commission.half_swings = 0
    commission.creep_far = _HALF_TURN
    commission.fold = 1
    if commission.creep_part == _SHORT_ROUNDS:
        commission.fold = pairs + pairs
    if phase == PHASE_CREEP:
        commission.creep_far = _SHORT // saturate(pairs, 2, 50)
    if commission.away * commission.sign < 0 - commission.creep_far and phase == PHASE_CREEP:
        commission.half_swings = 1
    commission.way = 0
    commission.play_sum = 0
    for place in range(COGS):
        commission.cogging[place] = 0
    probe_begin(loop, 1)
    return go_on(commission, phase)


@hot
def creep_step(
    loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, commission: Commission
) -> int:
    """Do one tick; return 1 when the cogging's waves are found and checked: they act from then on."""
    phase = commission.phase
    current_d = loop.sum_current_d
    current = loop.sum_current_q
    probe_begin(loop, 1)
    moved = swing(loop, state, commission)
    follow_joint(io, commission)
    way = saturate(moved, -_MOVED_MOST, _MOVED_MOST)
    change = way - commission.moved_before
    if phase == PHASE_WAVES:
        _hold(loop, settings, state, commission)
        return _look_at_table(loop, settings, commission)
    if loop.electrical_gain == 0:
        current = turning_current(settings, commission, current_d, current, loop.rotor, moved)
    far = commission.creep_far
    if commission.away * commission.sign > far + _MARGIN:
        commission.sign = 0 - commission.sign
        commission.half_swings += 1
    _follow(loop, settings, state, commission, far)
    if commission.phase_ticks > _TICKS_MOST:
        refuse(commission, FAULT_COMMISSION_COGGING, loop.reference_q)
    if commission.reason:
        return 0
    if commission.half_swings > 0 and commission.away < far and commission.away >= 0 - far:
        _add(commission, _ripple_or_current(commission, change))
        add_play(settings, commission, commission.moved_last)
    commission.moved_before = commission.moved_last
    commission.moved_last = way
    commission.current_last = current
    commission.place_last = (loop.rotor * commission.fold >> 5) & (COGS - 1)
    if commission.half_swings > 2 and commission.creep_part >= _WITHOUT:
        return _look_again(commission)
    if commission.half_swings > 2:
        follow_rotor(loop, state, commission)
        find_play(settings, commission)
        return _look(loop, commission)
    return 0


@hot
def _follow(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission, far: int) -> int:
    """Creep, faster on the way to where a round begins; return the current."""
    rate = commission.swing_rate
    at = commission.away * commission.sign
    if commission.creep_part >= _WITHOUT and at < 0 - far - _MARGIN:
        commission.swing_rate += rate >> 1
    elif commission.half_swings == 0 and at < far - _MARGIN:
        commission.swing_rate = rate * 3
    ask_rate(settings, state, commission)
    commission.swing_rate = rate
    return _push(loop, settings, state, commission)


@hot
def _push(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> int:
    """Hand the current on; while waves are looked for a field holds the rotor, from its first standstill on."""
    if commission.creep_part >= _WITHOUT or commission.half_swings < 1:
        return write_current(loop, settings, state)
    if loop.electrical_gain and commission.swing_reference * commission.sign < 0:
        return write_current(loop, settings, state)
    return hold_rotor(loop, settings, state, commission)


@hot
def _ripple_or_current(commission: Commission, change: int) -> int:
    """Return what is added up for the tick before: while waves are checked the rotor's rate above the wanted.

    Else the current that the motion alone took, times 10, less the acceleration's: ``change`` of the way in two ticks.
    """
    if commission.creep_part >= _WITHOUT:
        speed = commission.moved_last * commission.sign << 8
        return saturate(speed - commission.swing_rate, -_CURRENT_MOST, _CURRENT_MOST)
    taken = (saturate(commission.inertia, 0, 0x3FFFF) * saturate(change, -_CHANGE_MOST, _CHANGE_MOST) >> 5) * STEPS
    return saturate(commission.current_last - taken, -_CURRENT_MOST, _CURRENT_MOST)


@hot
def _add(commission: Commission, value: int) -> int:
    """Add the value of the tick before over its way to the place where the rotor was; return the way."""
    way = commission.moved_last * commission.sign
    place = commission.place_last
    commission.cogging[place] = saturate(commission.cogging[place] + value * way, -_TABLE_MOST, _TABLE_MOST)
    commission.way += way
    return way


@hot
def _hold(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> int:
    """Let the rotor stand while the table is looked at; return the current."""
    rate = commission.swing_rate
    commission.swing_rate = 0
    follow_rate(loop, settings, state, commission)
    commission.swing_rate = rate
    return loop.reference_q


@hot
def _look(loop: CurrentLoop, commission: Commission) -> int:
    """Begin to look for waves: of a short round for multiples of the poles, of the whole turn for slower others.

    If no short round's wave has settled, the whole turn is looked at for those multiples too. Return 0.
    """
    pairs = saturate(commission.pole_pairs, 1, 50)
    commission.order_before = commission.wave_order[0]
    commission.current_before = commission.wave_current[0]
    commission.phase_before = commission.wave_phase[0]
    fold = saturate(commission.fold, 1, 100)
    commission.order = (pairs + pairs) // fold
    commission.order_last = saturate(pairs * _ORDERS, 1, _ORDER_MOST) // fold
    if commission.creep_settled:
        commission.order_last = pairs * _ORDERS >> 1
    for wave in range(WAVES):
        if commission.creep_settled == 0:
            commission.wave_order[wave] = 0
            commission.wave_current[wave] = 0
    return _begin_look(commission)


@hot
def _look_again(commission: Commission) -> int:
    """Begin to look at the speed's ripple, so often a turn as the waves are; return 0."""
    commission.wave = 0
    commission.order = commission.wave_order[0]
    return _begin_look(commission)


@hot
def _begin_look(commission: Commission) -> int:
    commission.place = 0
    commission.cosine_sum = 0
    commission.sine_sum = 0
    go_on(commission, PHASE_WAVES)
    return 0


@hot
def _look_at_table(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """Multiply a part of the table with a wave; after the last wave go on, or return 1 after the check."""
    order = commission.order
    cosine = commission.cosine_sum
    sine = commission.sine_sum
    begin = commission.place
    for place in range(begin, begin + _PLACES):
        at = (place + place + 1) * order & _SINE_STEPS
        value = commission.cogging[place] + 128 >> 8
        value = saturate(value, -32767, 32767)
        cosine += value * loop.sine[at + COSINE_AT] + 0x4000 >> 15
        sine += value * loop.sine[at] + 0x4000 >> 15
    commission.cosine_sum = cosine
    commission.sine_sum = sine
    commission.place = begin + _PLACES
    if commission.place < COGS:
        return 0
    commission.place = 0
    commission.cosine_sum = 0
    commission.sine_sum = 0
    if commission.creep_part >= _WITHOUT:
        return _check_wave(loop, settings, commission, cosine, sine)
    _take_wave(commission, order, cosine, sine)
    commission.order = order + 1
    if commission.order <= commission.order_last:
        return 0
    return _next_round(loop, settings, commission)


@hot
def _amplitude(commission: Commission, order: int, cosine: int, sine: int) -> int:
    """Return the amplitude of a wave in the table, in cu, Q4, or in rate when that was added up.

    A place is as wide as 1/512 table: its mean is sin(x) / x of what it holds in the middle, x = pi order / 512.
    """
    current = ratio(hypot(cosine, sine), saturate(commission.way, 1, _TABLE_MOST), 9) * 8 // 5
    current = saturate(current, 0, 0x7FFF)
    return current + (current * (order * order * 105 >> 12) >> 12)


@hot
def _check_wave(
    loop: CurrentLoop, settings: JointSettings, commission: Commission, cosine: int, sine: int
) -> int:
    """Take in the ripple without or with a wave; after the last wave go on, or return 1 if the check is over."""
    wave = commission.wave
    ripple = 0
    if commission.order > 0:
        ripple = _amplitude(commission, commission.order, cosine, sine)
    before = commission.ripple[wave]
    if commission.creep_part == _WITHOUT and wave > 0:
        commission.useless |= _too_quiet(commission, wave, ripple) << wave
    if commission.creep_part == _WITHOUT or wave == 0:
        commission.ripple[wave] = ripple
    if commission.creep_part == _WITH and wave >= commission.creep_settled and commission.order > 0:
        commission.useless |= _useless(commission, before, ripple) << wave
    if wave < WAVES - 1:
        commission.wave = wave + 1
        commission.order = commission.wave_order[wave + 1]
        return 0
    if commission.creep_part == _WITH:
        _drop_useless(loop, commission)
        return 1
    hold_waves(loop, 1)
    commission.creep_part = _WITH
    _round(loop, settings, commission, PHASE_CREEP)
    return 0


@hot
def _too_quiet(commission: Commission, wave: int, ripple: int) -> int:
    """Return 1 if a wave's ripple is not half of what its current would make, as the settled first one's does."""
    if commission.creep_settled == 0:
        return 0
    if ripple * (commission.wave_current[0] >> 3) < commission.ripple[0] * (commission.wave_current[wave] >> 4):
        return 1
    return 0


@hot
def _useless(commission: Commission, before: int, ripple: int) -> int:
    """Return 1 if a wave leaves more than half of its ripple, or had less of it than the first wave leaves; else 0."""
    if (ripple << 8) // saturate(before, 1, 0xFFFF) > _LEFT_MOST or before < commission.ripple[0]:
        return 1
    return 0


@hot
def _drop_useless(loop: CurrentLoop, commission: Commission) -> int:
    """Drop the waves that were of no use; return which, bits."""
    for wave in range(WAVES):
        if commission.useless >> wave & 1:
            _drop(loop, commission, wave)
    return commission.useless


@hot
def _drop(loop: CurrentLoop, commission: Commission, wave: int) -> int:
    commission.wave_order[wave] = 0
    commission.wave_current[wave] = 0
    return _act(loop, commission, wave, wave)


@hot
def _take_wave(commission: Commission, order: int, cosine: int, sine: int) -> int:
    """Keep a wave if it is stronger than the weakest kept, or than a near one; return its amplitude in cu, Q4.

    Multiples of the poles stay as the last short round found them, because that creeps more slowly.
    """
    current = _amplitude(commission, order, cosine, sine)
    order = order * commission.fold
    settled = commission.creep_settled
    poles = saturate(commission.pole_pairs << 1, 2, 100)
    weakest = _near(commission, order)
    if settled and (order % poles == 0 or weakest == 0):
        return current
    if weakest < 0:
        weakest = settled
        for wave in range(settled, WAVES):
            if commission.wave_current[wave] < commission.wave_current[weakest]:
                weakest = wave
    if current > commission.wave_current[weakest]:
        commission.wave_order[weakest] = order
        commission.wave_current[weakest] = current
        commission.wave_phase[weakest] = atan2_brad(cosine, sine)
    return current


@hot
def _near(commission: Commission, order: int) -> int:
    """Return the first wave that the check, in two electrical turns, could not tell from this; -1 if none.

    Two of them may leave each other nothing there, and all the more on the other side of the turn.
    """
    least = saturate(commission.pole_pairs, 1, 50) * 2 // 3
    near = -1
    for wave in range(WAVES):
        apart = order - commission.wave_order[wave]
        if near < 0 and commission.wave_current[wave] > 0 and apart < least and apart > 0 - least:
            near = wave
    return near


@hot
def _next_round(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """Let the strongest wave act on the next round, or all of them after the last; return 0.

    A wave of more than a quarter of the current limit is refused.
    """
    strongest = 0
    for wave in range(WAVES):
        put_wave(loop, wave, 0, 0, 0)
        if commission.wave_current[wave] > commission.wave_current[strongest]:
            strongest = wave
    current = commission.wave_current[strongest] >> 4
    if current > settings.commission_current >> 1:
        refuse(commission, FAULT_COMMISSION_COGGING, current)
        return 0
    if commission.creep_part == _WHOLE_ROUND:
        return _begin_check(loop, settings, commission, commission.wave_current[strongest] >> 3)
    _swap_first(commission, strongest)
    _act(loop, commission, 0, 0)
    hold_waves(loop, 1)
    commission.creep_rounds += 1
    commission.creep_settled = _settled(commission)
    if commission.creep_settled == 0 and commission.creep_rounds < _ROUNDS_MOST:
        _round(loop, settings, commission, PHASE_CREEP)
        return 0
    if commission.creep_settled == 0:
        _drop(loop, commission, 0)
    commission.creep_part = _WHOLE_ROUND
    _round(loop, settings, commission, PHASE_ROUND)
    return 0


@hot
def _settled(commission: Commission) -> int:
    """Return 1 if the first wave is the same as in the round before, in which another one acted, or none; else 0.

    Its amplitude may differ by an eighth, after the last round by a quarter: some motors' rounds come out in turns.
    """
    little = commission.wave_current[0] >> 3
    if commission.creep_rounds == _ROUNDS_MOST:
        little = little << 1
    change = commission.wave_current[0] - commission.current_before
    turned = wrap_brad(commission.wave_phase[0] - commission.phase_before)
    if commission.wave_order[0] != commission.order_before or change > little or change < 0 - little:
        return 0
    if turned > _SETTLED or turned < -_SETTLED:
        return 0
    return 1


@hot
def _swap_first(commission: Commission, strongest: int) -> int:
    """Put the strongest wave at the first place; return its order."""
    order = commission.wave_order[strongest]
    current = commission.wave_current[strongest]
    phase = commission.wave_phase[strongest]
    commission.wave_order[strongest] = commission.wave_order[0]
    commission.wave_current[strongest] = commission.wave_current[0]
    commission.wave_phase[strongest] = commission.wave_phase[0]
    commission.wave_order[0] = order
    commission.wave_current[0] = current
    commission.wave_phase[0] = phase
    return order


@hot
def _begin_check(loop: CurrentLoop, settings: JointSettings, commission: Commission, least: int) -> int:
    """Make that of the short rounds ready, and all waves of at least that amplitude, but creep without; return 0.

    A wave below 1/16 of the friction is none: friction alone made some of 1/25. If there is none but the one of the
    short rounds, there is nothing to check: return 1.
    """
    others = 0
    if least < commission.coulomb >> 4:
        least = commission.coulomb >> 4
    for wave in range(WAVES):
        if wave >= commission.creep_settled:
            if commission.wave_current[wave] < least:
                _drop(loop, commission, wave)
            others += commission.wave_order[wave]
        _act(loop, commission, wave, wave)
    if others == 0:
        return 1
    hold_waves(loop, 0)
    commission.useless = 0
    commission.creep_part = _WITHOUT
    _round(loop, settings, commission, PHASE_CREEP)
    return 0


@hot
def _act(loop: CurrentLoop, commission: Commission, place: int, wave: int) -> int:
    return put_wave(
        loop, place, commission.wave_order[wave], commission.wave_current[wave], commission.wave_phase[wave]
    )
