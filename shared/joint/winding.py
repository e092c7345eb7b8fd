"""Commissioning's first part: resistance, inductance of both axes, dead time and the current loop's gains.

The rotor is held by a voltage along one direction, without a current loop. Two voltages give the resistance, whatever
dead time takes of both: R = dV / dI. A voltage that changes its sign at every current step gives the inductances: the
current alternates by D = (V / R) tanh(R T / 2 L), which is V T / 2 L for any winding slower than a step.
"""

from ..num.fixed import ratio, saturate
from ..runtime import const, hot
from .commission_state import (
    COMMISSION_VERIFY,
    PHASE_ALTERNATE_D,
    PHASE_ALTERNATE_Q,
    PHASE_HIGH,
    PHASE_LOW,
    PHASE_PROVE_CURRENT,
    PHASE_SETTLE,
    Commission,
    begin_phase,
    fail,
)
from .commutation import point
from .current import current_sum
from .encoder import wrap_count
from .faults import (
    FAULT_COMMISSION_MOVING,
    FAULT_COMMISSION_NO_CURRENT,
    FAULT_COMMISSION_PHASE_OPEN,
    FAULT_COMMISSION_SUM,
    FAULT_COMMISSION_WINDING,
)
from .layout import CurrentLoop, JointSettings
from .probe import probe_begin

_OBLIQUE = const(2731)  # brad: 15 degrees, where every phase carries current
_RAMP_TICKS = const(320)
_RAMP_MOST = const(8000)  # ticks, with a rotor that does not come to rest
_TURNED_MOST = const(4)  # rc in a tick, 1.5 rad/s: its back-EMF is below 0.1 V for 60 mV s
_SETTLE_TICKS = const(512)
_SHORT_TICKS = const(16)
_LONG_TICKS = const(256)
_KP_LEAST = const(64)  # limits of the parameters current_kp and current_ki
_KP_MOST = const(16383)
_KI_LEAST = const(8)
_KI_MOST = const(4095)
_INDUCTANCE_MOST = const(524287)
_IMPEDANCE_MOST = const(0x20000000)
_SUM_MOST = const(0x3FFFFFF)
_QUICK_Q15 = const(22938)  # tanh(R T / 2 L) of 0.7: the winding settles within a step


@hot
def winding_inductance(volt_q4: int, current_q4: int, resistance_q16: int) -> int:
    """Return L / T in vu step / cu (Q16) of a current that alternates by +-current under +-volt; 0 if it is too quick.

    volt 1 .. 2^22, current 1 .. 2^20 (Q4), resistance 0 .. 2^18. From L / T = R / (2 atanh t), t = R current / volt, as
    volt / (2 current (1 + t^2/3 + t^4/5 + t^6/7)): error 0.7 % up to t = 0.7, where it ends.
    """
    impedance = ratio(volt_q4, current_q4, 16)
    if impedance < 2 or impedance > _IMPEDANCE_MOST:
        return 0
    t = ratio(resistance_q16, impedance, 15)
    if t > _QUICK_Q15:
        return 0
    square = t * t >> 15
    series = 6554 + (square * 4681 >> 15)  # 1/5, 1/7
    series = 10923 + (square * series >> 15)  # 1/3
    return ratio(impedance >> 1, 32768 + (square * series >> 15), 15)


@hot
def winding_step(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> None:
    """Do one tick of the phases ramp to alternate."""
    phase = commission.phase
    if phase < PHASE_SETTLE:
        _ramp(loop, settings, commission)
    elif phase == PHASE_SETTLE:
        _settle(loop, settings, commission)
    elif phase < PHASE_ALTERNATE_D:
        _measure(loop, commission)
    else:
        _alternate(loop, settings, commission)


@hot
def _ramp(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """Raise the voltage by 1/64 a tick until the current flows, along it or, if a phase is open, across it.

    This is slow enough for the current to follow in any winding. The field comes from a quarter turn back: no rotor
    stands exactly opposite to both ends of that way. While the rotor turns to the field, its back-EMF reduces the
    current: the voltage waits, or it would be too high once the rotor stands.
    """
    commission.angle = saturate((commission.phase_ticks << 6) - 16384, -16384, _OBLIQUE)
    point(loop, commission)
    wanted = settings.commission_current
    turned = wrap_count(loop.rotor - commission.rotor_last)
    commission.rotor_last = loop.rotor
    if turned > _TURNED_MOST or turned < -_TURNED_MOST:
        if commission.phase_ticks > _RAMP_MOST:
            return fail(commission, FAULT_COMMISSION_MOVING, turned << 8)
    elif loop.current_d < wanted and loop.current_q < wanted and loop.current_q > -wanted:
        commission.level += (commission.level >> 6) + 1
    elif commission.phase_ticks > _RAMP_TICKS:
        return begin_phase(commission, PHASE_SETTLE)
    if commission.level > loop.voltage_limit - (loop.voltage_limit >> 3):
        return fail(commission, FAULT_COMMISSION_NO_CURRENT, loop.current_d)
    loop.level = commission.level
    loop.feed_d = commission.level
    loop.feed_q = 0
    return commission.phase


@hot
def _settle(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """Wait until the rotor has aligned with the field, then check the phases' currents."""
    if commission.phase_ticks < _SETTLE_TICKS:
        return PHASE_SETTLE
    _check_phases(loop, settings, commission)
    if commission.reason:
        return commission.phase
    commission.angle = 0
    point(loop, commission)
    if commission.kind == COMMISSION_VERIFY:
        loop.kp = commission.final_kp
        loop.ki = commission.final_ki
        return _close_loop(loop, settings, commission)
    commission.window = 0
    return begin_phase(commission, PHASE_HIGH)


@hot
def _check_phases(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """Return 0 if every phase carries current (at least 0.26 of the vector at this angle) and they add up to 0."""
    least = settings.commission_current // 60  # counts: a tenth of the current, 6 cu each
    for phase in range(3):
        current = loop.raw[phase] - (loop.offset_q4[phase] >> 4)
        if current < least and current > 0 - least:
            return fail(commission, FAULT_COMMISSION_PHASE_OPEN, phase + 1)
    wrong = current_sum(loop)
    if wrong > settings.sum_limit or wrong < -settings.sum_limit:
        return fail(commission, FAULT_COMMISSION_SUM, wrong)
    return 0


@hot
def _measure(loop: CurrentLoop, commission: Commission) -> int:
    """Take the mean current, first at the whole voltage and then at half of it; find the resistance from both.

    The field moves to and fro by 2.8 degrees, so that the rounding errors of the duties differ and cancel.
    """
    wave = commission.phase_ticks & 63
    if wave > 31:
        wave = 63 - wave
    commission.angle = (wave - 16) << 5
    point(loop, commission)
    if commission.phase_ticks == _LONG_TICKS:
        probe_begin(loop, 1)
    if commission.phase_ticks < _LONG_TICKS + _LONG_TICKS:
        return commission.phase
    loop.probing = 0
    current_q4 = _mean_q4(loop, loop.sum_current_d)
    half = commission.level >> 1
    if commission.phase == PHASE_HIGH:
        commission.current_high_q4 = current_q4
        loop.level = half
        loop.feed_d = half
        return begin_phase(commission, PHASE_LOW)
    high = commission.level
    commission.resistance = ratio(high - half << 4, commission.current_high_q4 - current_q4, 16)
    if commission.resistance < 1 or commission.resistance > 0x3FFFF:
        return fail(commission, FAULT_COMMISSION_WINDING, commission.resistance)
    across = (commission.current_high_q4 >> 8) * commission.resistance
    across = across + ((commission.current_high_q4 & 255) * commission.resistance >> 8) >> 8
    commission.dead_q4 = saturate((high << 4) - across, 0, high << 4)
    commission.angle = 0
    point(loop, commission)
    loop.level = high
    loop.alternate_d = 4
    return _count(loop, commission, PHASE_ALTERNATE_D, _SHORT_TICKS)


@hot
def _mean_q4(loop: CurrentLoop, total: int) -> int:
    """Return a sum over the steps added up, in Q4; 0 without any. 2560 steps of 12288 at most: below 2^25."""
    if loop.probe_steps < 1:
        return 0
    return (saturate(total, -_SUM_MOST, _SUM_MOST) << 4) // loop.probe_steps


@hot
def _count(loop: CurrentLoop, commission: Commission, phase: int, ticks: int) -> int:
    """Begin sums over ``ticks`` in ``phase``; return the phase."""
    commission.window = ticks
    probe_begin(loop, 1)
    return begin_phase(commission, phase)


@hot
def _alternate(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """Let the alternating voltage grow until the current alternates by an eighth, measure, and do the other axis."""
    if commission.phase_ticks < commission.window:
        return commission.phase
    loop.probing = 0
    volt = loop.alternate_d | loop.alternate_q
    current = loop.sum_current_d
    if commission.phase == PHASE_ALTERNATE_Q:
        current = loop.sum_current_q
    current_q4 = _mean_q4(loop, current)
    if commission.window == _SHORT_TICKS:
        if current_q4 >= settings.commission_current << 1 or volt > loop.voltage_limit >> 1:
            return _count(loop, commission, commission.phase, _LONG_TICKS)
        if commission.phase == PHASE_ALTERNATE_D:
            loop.alternate_d = volt + (volt >> 1)
        else:
            loop.alternate_q = volt + (volt >> 1)
        return _count(loop, commission, commission.phase, _SHORT_TICKS)
    found = winding_inductance(volt << 4, saturate(current_q4, 1, 0xFFFFF), commission.resistance)
    if found < 1 or found > _INDUCTANCE_MOST:
        return fail(commission, FAULT_COMMISSION_WINDING, found)
    if commission.phase == PHASE_ALTERNATE_D:
        commission.inductance_d = found
        loop.alternate_q = loop.alternate_d
        loop.alternate_d = 0
        return _count(loop, commission, PHASE_ALTERNATE_Q, _SHORT_TICKS)
    commission.inductance_q = found
    loop.alternate_q = 0
    return _tune(loop, settings, commission)


@hot
def _tune(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """Set the current loop's gains, kp = L w with the mean of both axes and ki = R w; refuse them if out of range."""
    mean = commission.inductance_d + commission.inductance_q >> 1
    kp = (mean * settings.current_w + 0x4000) >> 15
    ki = (commission.resistance * settings.current_w + 0x4000) >> 15
    if kp < _KP_LEAST or kp > _KP_MOST:
        return fail(commission, FAULT_COMMISSION_WINDING, kp)
    if ki < _KI_LEAST or ki > _KI_MOST:
        return fail(commission, FAULT_COMMISSION_WINDING, ki)
    loop.kp = kp
    loop.ki = ki
    return _close_loop(loop, settings, commission)


@hot
def _close_loop(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """Let the current loop take over at the present voltage and hold the current; return the phase that follows."""
    loop.feed_q = 0
    loop.integral_q = 0
    loop.reference_q = 0
    loop.reference_d = settings.commission_current
    loop.integral_d = commission.level << 13
    loop.feed_d = 0
    return begin_phase(commission, PHASE_PROVE_CURRENT)
