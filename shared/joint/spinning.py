"""Commissioning's third part: the rotor swings to and fro by itself, and its back-EMF gives the flux linkage.

It turns a quarter of a turn to either side of the middle; the current across the flux falls to 0 at half of the speed
limit. A current along the flux stays, so that dead time takes all it can of every phase, in a known direction. Over
whole swings, the current loop's voltage less R i, L di/dt, w L i and dead time is the flux linkage times the angle
travelled, whatever the load. Its part on the d axis shows the error of the offset, free of friction and gravity.
"""

from ..num.fixed import atan2_brad, hypot, ratio, saturate
from ..runtime import const, hot
from .bend import fill_bend
from .commission_state import PHASE_SPIN, STEPS, Commission, begin_phase, fail
from .commutation import commutate, follow_rotor
from .encoder import wrap_count
from .faults import FAULT_COMMISSION_FLUX, FAULT_COMMISSION_FRICTION, FAULT_COMMISSION_NOT_FREE
from .layout import CurrentLoop, JointSettings, JointState
from .probe import probe_begin

_QUARTER = const(4096)  # rc
_FAR = const(12288)  # rc from the centre
_HALVES = const(8)
_ELECTRICAL_RATE = const(320000)  # rate of the rotor times pole pairs: 480 rad/s
_RAD_Q19 = const(201)  # 4 2 pi / 65536: electrical rad for each rc and pole pair
_TICKS_MOST = const(4000)
_BEMF_MOST = const(16383)  # of the parameter


@hot
def spin_begin(loop: CurrentLoop, commission: Commission) -> int:
    """Hand the results so far to the current step and begin to swing; return PHASE_SPIN."""
    fill_bend(loop, commission.bend[0], commission.bend[1], commission.bend[2], commission.bend[3])
    commutate(loop, commission.pole_pairs, commission.direction, commission.offset_found)
    loop.reference_d = loop.reference_d >> 1
    commission.centre = commission.moved_forward >> 1
    commission.sign = -1  # the field turned on last
    commission.half_swings = 0
    commission.way = 0
    commission.dead_sum_d = 0
    commission.dead_sum_q = 0
    commission.current_change = 0
    probe_begin(loop, -1)
    return begin_phase(commission, PHASE_SPIN)


@hot
def spin_step(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> int:
    """Do one tick; return 1 when the flux is found."""
    commission.way += swing(loop, state, commission) * commission.sign
    turn_round(commission)
    loop.probe_sign = commission.sign
    _push(loop, settings, state, commission)
    if commission.phase_ticks > _TICKS_MOST:
        fail(commission, FAULT_COMMISSION_FRICTION, commission.lag)
    if commission.reason or commission.half_swings < _HALVES:
        return 0
    loop.probing = 0
    return _find_flux(loop, commission)


@hot
def swing(loop: CurrentLoop, state: JointState, commission: Commission) -> int:
    """Follow the rotor, and update the commutation unless a field is forced; return the way, rc, electrical-signed."""
    moved = wrap_count(loop.rotor - commission.rotor_last)
    commission.rotor_last = loop.rotor
    commission.moved += moved
    commission.swing_position = (commission.moved - commission.centre) * commission.direction
    if loop.electrical_gain:
        follow_rotor(loop, state, commission)
    if commission.swing_position > _FAR or commission.swing_position < -_FAR:
        fail(commission, FAULT_COMMISSION_NOT_FREE, commission.moved)
    return moved * commission.direction


@hot
def turn_round(commission: Commission) -> int:
    """Reverse the direction a quarter of a turn from the middle; return it."""
    if commission.swing_position * commission.sign > _QUARTER:
        commission.sign = 0 - commission.sign
        commission.half_swings += 1
    return commission.sign


@hot
def swing_rate(settings: JointSettings, commission: Commission) -> int:
    """Return the speed of a swing: half of the speed limit, or what its commutation allows."""
    wanted = settings.rate_max >> 1
    fastest = _ELECTRICAL_RATE // saturate(commission.pole_pairs, 1, 50)
    if wanted > fastest:
        return fastest
    return wanted


@hot
def swing_current(settings: JointSettings, state: JointState, commission: Commission, wanted: int) -> int:
    """Return the current that falls from half of the commissioning current at rest to none at the ``wanted`` speed."""
    sign = commission.sign
    slip = saturate(wanted - state.rate * commission.direction * sign, -wanted, wanted)
    return (slip >> 4) * (settings.commission_current >> 1) // ((wanted >> 4) + 1) * sign


@hot
def _push(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> None:
    """Set the swing's current, and add up the voltage that it costs besides resistance."""
    sign = commission.sign
    current = swing_current(settings, state, commission, swing_rate(settings, commission))
    commission.current_change += (current - loop.reference_q) * sign
    lost = (commission.dead_q4 << 8) // (hypot(loop.reference_d, current) + 1) * sign
    commission.dead_sum_d += lost * loop.reference_d >> 8
    commission.dead_sum_q += lost * current >> 8
    loop.reference_q = current


@hot
def _find_flux(loop: CurrentLoop, commission: Commission) -> int:
    """Find flux linkage and offset from the sums; return 1, or 0 if no motor has such a flux.

    Sums of voltage stay below 2^28 in 4 s of 10 steps a tick, those of current below 2^27 (most of it cancels).
    """
    resistance = commission.resistance
    turned = commission.way * commission.pole_pairs * _RAD_Q19 >> 19  # electrical rad
    along = commission.inductance_d + resistance + (resistance >> 1)  # w L i_d, and R i_d 1.5 steps ahead
    loss = (loop.sum_current_q >> 14) * resistance >> 2
    loss += (commission.current_change >> 4) * (commission.inductance_q >> 6) >> 6
    ahead_q4 = commission.dead_q4 + (commission.dead_q4 >> 1)
    loss += (((along >> 4) * loop.reference_d >> 8) + ahead_q4) * turned >> 4
    q = loop.sum_voltage_q - loss - (commission.dead_sum_q >> 4) * STEPS
    d = loop.sum_voltage_d - ((loop.sum_current_d >> 14) * resistance >> 2) - (commission.dead_sum_d >> 4) * STEPS
    commission.offset_found = (commission.offset_found + atan2_brad(0 - d, q)) & 0xFFFF
    commission.flux = ratio(hypot(d, q), commission.way, 8) * 4 // 5
    if q < 1 or commission.flux < 1 or commission.flux > _BEMF_MOST:
        fail(commission, FAULT_COMMISSION_FLUX, commission.flux)
        return 0
    return 1
