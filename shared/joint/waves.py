"""Which waves the cogging has: creeping rounds (creeping.py), and after each a search of its table (spectrum.py).

First come short rounds, for multiples of the poles. The strongest wave that one finds acts in the next. A wave that the
next round finds again, although another one or none acted before, is right and stays. Then the rotor creeps round the
whole turn, for the waves that are no multiples of the poles. All but that first wave are checked (checking.py).
"""

from ..num.fixed import atan2_brad, saturate, wrap_brad
from ..runtime import const, hot
from .checking import begin_check, check_wave
from .cogging import drop_wave, put_wave, switch_waves, try_wave
from .commission_state import PHASE_WAVES, Commission, begin_phase, fail
from .creeping import CREEP_SHORT, CREEP_WHOLE, CREEP_WITHOUT, begin_round, creep_round, stand_still
from .faults import FAULT_COMMISSION_COGGING
from .holding import find_flux_taken
from .layout import WAVES, CurrentLoop, JointIo, JointSettings, JointState
from .spectrum import look_at_table, look_for, wave_amplitude

_ROUNDS_MOST = const(4)  # until it creeps round the whole turn
_SETTLED = const(2608)  # brad: a quarter of a rad, by which the phases of two rounds may differ
_ORDERS = const(12)  # times the pole pairs: the highest order searched for
_ORDER_MOST = const(250)  # with 512 places


@hot
def creep_begin(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> None:
    """Begin to creep without any waves."""
    commission.creep_rounds = 0
    commission.creep_settled = 0
    find_flux_taken(settings, commission)
    for wave in range(WAVES):
        drop_wave(loop, commission, wave)
    begin_round(loop, settings, commission, CREEP_SHORT)


@hot
def creep_step(
    loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, commission: Commission
) -> int:
    """Do one tick; return 1 when the cogging's waves are found and checked: they act from then on."""
    if commission.phase != PHASE_WAVES:
        if creep_round(loop, settings, state, io, commission):
            _begin_look(commission)
        return 0
    stand_still(loop, settings, state, io, commission)
    if look_at_table(loop, commission) == 0:
        return 0
    if commission.creep_part >= CREEP_WITHOUT:
        return check_wave(loop, settings, commission)
    _take_wave(commission)
    if look_for(commission, commission.order + 1) <= commission.order_last:
        return 0
    return _next_round(loop, settings, commission)


@hot
def _begin_look(commission: Commission) -> None:
    """Begin to search a round's table; in a check, for the waves that are checked.

    Else for multiples of the poles after a short round, for slower other waves after the whole turn; if no wave of a
    short round has settled, for those multiples there too.
    """
    begin_phase(commission, PHASE_WAVES)
    if commission.creep_part >= CREEP_WITHOUT:
        commission.wave = 0
        look_for(commission, commission.wave_order[0])
        return
    pairs = saturate(commission.pole_pairs, 1, 50)
    table_repeats = saturate(commission.table_repeats, 1, 100)
    commission.order_before = commission.wave_order[0]
    commission.current_before = commission.wave_current[0]
    commission.phase_before = commission.wave_phase[0]
    look_for(commission, (pairs + pairs) // table_repeats)
    commission.order_last = saturate(pairs * _ORDERS, 1, _ORDER_MOST) // table_repeats
    if commission.creep_settled:
        commission.order_last = pairs * _ORDERS >> 1
        return
    for wave in range(WAVES):
        commission.wave_order[wave] = 0
        commission.wave_current[wave] = 0


@hot
def _take_wave(commission: Commission) -> None:
    """Keep a wave if it is stronger than the weakest one kept, or than one near to it.

    Multiples of the poles stay as the last short round found them, because that round creeps more slowly.
    """
    current = wave_amplitude(commission)
    order = commission.order * commission.table_repeats
    settled = commission.creep_settled
    poles = saturate(commission.pole_pairs << 1, 2, 100)
    weakest = _indistinct(commission, order)
    if settled and (order % poles == 0 or weakest == 0):
        return
    if weakest < 0:
        weakest = settled
        for wave in range(settled, WAVES):
            if commission.wave_current[wave] < commission.wave_current[weakest]:
                weakest = wave
    if current > commission.wave_current[weakest]:
        _keep(commission, weakest, order, current, atan2_brad(commission.cosine_sum, commission.sine_sum))


@hot
def _keep(commission: Commission, wave: int, order: int, current: int, phase: int) -> None:
    commission.wave_order[wave] = order
    commission.wave_current[wave] = current
    commission.wave_phase[wave] = phase


@hot
def _indistinct(commission: Commission, order: int) -> int:
    """Return the first wave that the check, over two electrical turns, could not tell from this order; -1 if none.

    Two such waves may cancel each other there, and add up on the other side of the turn.
    """
    least = saturate(commission.pole_pairs, 1, 50) * 2 // 3
    for wave in range(WAVES):
        apart = order - commission.wave_order[wave]
        if commission.wave_current[wave] > 0 and apart < least and apart > 0 - least:
            return wave
    return -1


@hot
def _next_round(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """Let the strongest wave act in the next round; after the whole turn check all of them, return 1 if none is to be.

    A wave of more than a quarter of the current limit is refused.
    """
    strongest = 0
    for wave in range(WAVES):
        put_wave(loop, wave, 0, 0, 0)
        if commission.wave_current[wave] > commission.wave_current[strongest]:
            strongest = wave
    current = commission.wave_current[strongest]
    if current >> 4 > settings.commission_current >> 1:
        fail(commission, FAULT_COMMISSION_COGGING, current >> 4)
        return 0
    if commission.creep_part == CREEP_WHOLE:
        return begin_check(loop, settings, commission, current >> 3)
    _swap_first(commission, strongest)
    try_wave(loop, commission, 0)
    switch_waves(loop, 1)
    commission.creep_rounds += 1
    commission.creep_settled = _settled(commission)
    if commission.creep_settled == 0:
        if commission.creep_rounds < _ROUNDS_MOST:
            begin_round(loop, settings, commission, CREEP_SHORT)
            return 0
        drop_wave(loop, commission, 0)
    begin_round(loop, settings, commission, CREEP_WHOLE)
    return 0


@hot
def _settled(commission: Commission) -> int:
    """Return 1 if the first wave is the same as in the round before, in which another one acted, or none; else 0.

    Its amplitude may differ by an eighth, after the last round by a quarter: some motors' results alternate.
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
def _swap_first(commission: Commission, strongest: int) -> None:
    """Put the strongest wave at the first place."""
    order = commission.wave_order[strongest]
    current = commission.wave_current[strongest]
    phase = commission.wave_phase[strongest]
    _keep(commission, strongest, commission.wave_order[0], commission.wave_current[0], commission.wave_phase[0])
    _keep(commission, 0, order, current, phase)
