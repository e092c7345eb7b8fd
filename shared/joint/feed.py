"""What the current step gets once a millisecond: modulator gains from the bus voltage, and feed-forward voltages.

Feed-forward: back-EMF (psi w on q), the coupling of the axes (w L i), the dead-time voltage along the current, all
rotated ahead by the angle the rotor goes from the samples until the voltage acts (1.5 steps).
"""

from ..num.fixed import cos_q15, mul_q15, saturate, sin_q15
from ..runtime import const, hot
from .layout import CurrentLoop, JointSettings, JointState

_INV_SQRT3_Q15 = const(18919)
_HALF_SQRT3_Q15 = const(28378)
_RATE_MOST = const(0x7FFFF)
_OMEGA_L_MOST = const(0xFFFF)


@hot
def bus_voltage(raw: int, gain_q12: int) -> int:
    """Return the bus voltage in vu from ``raw`` counts 0 .. 4095 and a gain 0 .. 2^17. Error 1/2 vu and the gain's."""
    return (raw * gain_q12 + 2048) >> 12


@hot
def feed_bus(loop: CurrentLoop, settings: JointSettings, bus_vu: int) -> None:
    """Set the modulator's gains and the longest vector for a bus of ``bus_vu``.

    bus_vu: any; below bus_least (at least 64) that is used, so nothing is divided by 0. loop.period below 2^15.
    Errors: voltage_limit 1/2 vu, gains half of their unit. Intermediates below 2^30.
    """
    least = settings.bus_least
    if least < 64:
        least = 64
    if bus_vu < least:
        bus_vu = least
    half = bus_vu >> 1
    limit = bus_vu * _INV_SQRT3_Q15 + 0x4000 >> 15
    loop.gain_alpha = ((loop.period << 14) + half) // bus_vu
    loop.gain_beta = ((loop.period * _HALF_SQRT3_Q15 >> 1) + half) // bus_vu
    loop.voltage_limit = limit
    loop.limit_square = limit * limit


@hot
def dead_time_voltage(current_cu: int, dead_vu: int, zone_cu: int) -> int:
    """Return the voltage lost to dead time, in vu, with the sign of the current.

    The mean over a turn of the three phases' square waves, 4/pi of one phase's, is taken along the
    current vector. current within +-32767, dead_vu 0 .. 32767, zone_cu at least 1: below it the
    voltage falls linearly to 0. Error at most 1 vu.
    """
    if zone_cu < 1:
        zone_cu = 1
    current_cu = saturate(current_cu, 0 - zone_cu, zone_cu)
    return current_cu * dead_vu // zone_cu


@hot
def feed_voltages(loop: CurrentLoop, settings: JointSettings, state: JointState) -> int:
    """Write feed_d and feed_q from the rotor's rate, the bus and the wanted current; return feed_q.

    Ranges: rate within +-(2^19 - 1), current within +-12288 cu, settings.bemf, omega_l 0 .. 16383,
    settings.advance 0 .. 2047. Result within +-voltage_limit on each axis. Error at most 1/4096 of each part
    plus 4 vu. Intermediates: 2^16 * 16383, 2^16 * 12288 and 2^19 * 2047 are below 2^30.
    """
    rate = saturate(state.rate, -_RATE_MOST, _RATE_MOST)
    current = saturate(loop.reference_q, -12288, 12288)
    sign = 1
    if loop.electrical_gain < 0:
        sign = -1
    omega_l = saturate((rate >> 3) * settings.omega_l >> 12, -_OMEGA_L_MOST, _OMEGA_L_MOST) * sign
    d = -(omega_l * current >> 16)
    q = ((rate >> 3) * settings.bemf >> 16) * sign
    q += dead_time_voltage(current, mul_q15(state.bus, settings.dead), settings.dead_zone)
    ahead = (rate * settings.advance >> 16) * sign
    limit = loop.voltage_limit
    d = saturate(d, -limit, limit)
    q = saturate(q, -limit, limit)
    sine = sin_q15(ahead)
    cosine = cos_q15(ahead)
    loop.feed_d = saturate((d * cosine - q * sine) >> 15, -limit, limit)
    loop.feed_q = saturate((d * sine + q * cosine) >> 15, -limit, limit)
    return loop.feed_q
