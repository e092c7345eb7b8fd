"""What the current step is fed once a millisecond: modulator gains from the bus voltage, voltages known beforehand.

Feed-forward: back-EMF (psi w on q), the coupling of the axes (w L i), the dead-time voltage along
the current, all turned ahead by the angle the rotor goes from the samples until the voltage acts (1.5 steps).
The rotor's angle itself is led here by the age of its reading, so that the current step has nothing to add.
"""

from ..fixed import cos_q15, mul_q15, saturate, sin_q15
from ..runtime import Ints, const, hot
from .layout import (
    F_ELEC_GAIN,
    F_ELEC_OFFSET,
    F_FEED_D,
    F_FEED_Q,
    F_GAIN_ALPHA,
    F_GAIN_BETA,
    F_LIMIT,
    F_LIMIT_SQUARE,
    F_PERIOD,
    F_Q_REF,
    K_ADVANCE,
    K_AGE,
    K_BEMF,
    K_BUS_LEAST,
    K_DEAD,
    K_DEAD_ZONE,
    K_ELEC_OFFSET,
    K_OMEGA_L,
    S_BUS,
    S_RATE,
)
from .sine import TABLE_HALF_STEP

_INV_SQRT3_Q15 = const(18919)
_HALF_SQRT3_Q15 = const(28378)
_RATE_MOST = const(0x7FFFF)
_OMEGA_L_MOST = const(0xFFFF)


@hot
def bus_voltage(raw: int, gain_q12: int) -> int:
    """Return the bus voltage in vu from ``raw`` counts 0 .. 4095 and a gain 0 .. 2^17. Error 1/2 vu and the gain's."""
    return (raw * gain_q12 + 2048) >> 12


@hot
def feed_bus(foc: Ints, cfg: Ints, bus_vu: int) -> int:
    """Set the modulator's gains and the longest vector for a bus of ``bus_vu``; return the bus used.

    bus_vu: any; below K_BUS_LEAST (at least 64) that is used, so nothing is divided by 0. F_PERIOD below 2^15.
    Errors: F_LIMIT 1/2 vu, gains half of their unit. Intermediates below 2^30.
    """
    least = cfg[K_BUS_LEAST]
    if least < 64:
        least = 64
    if bus_vu < least:
        bus_vu = least
    half = bus_vu >> 1
    limit = bus_vu * _INV_SQRT3_Q15 + 0x4000 >> 15
    foc[F_GAIN_ALPHA] = ((foc[F_PERIOD] << 14) + half) // bus_vu
    foc[F_GAIN_BETA] = ((foc[F_PERIOD] * _HALF_SQRT3_Q15 >> 1) + half) // bus_vu
    foc[F_LIMIT] = limit
    foc[F_LIMIT_SQUARE] = limit * limit
    return bus_vu


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
def lead_angle(foc: Ints, cfg: Ints, state: Ints) -> int:
    """Set F_ELEC_OFFSET so that the last reading of the rotor gives the angle at the samples; return it in brad.

    An answer of the encoder is one step old (K_AGE 0 .. 2047, rate within +-(2^19 - 1)). Error at most 1 brad plus
    what the rate is off. Intermediates: 2^19 * 2047 is below 2^30.
    """
    lead = saturate(state[S_RATE], -_RATE_MOST, _RATE_MOST) * cfg[K_AGE] >> 16
    if foc[F_ELEC_GAIN] < 0:
        lead = 0 - lead
    foc[F_ELEC_OFFSET] = cfg[K_ELEC_OFFSET] + TABLE_HALF_STEP + lead
    return foc[F_ELEC_OFFSET]


@hot
def feed_voltages(foc: Ints, cfg: Ints, state: Ints) -> int:
    """Write F_FEED_D and F_FEED_Q from the rotor's rate, the bus and the wanted current; return F_FEED_Q.

    Ranges: rate within +-(2^19 - 1), current within +-12288 cu, K_BEMF, K_OMEGA_L 0 .. 16383,
    K_ADVANCE 0 .. 2047. Result within +-F_LIMIT on each axis. Error at most 1/4096 of each part
    plus 4 vu. Intermediates: 2^16 * 16383, 2^16 * 12288 and 2^19 * 2047 are below 2^30.
    """
    rate = saturate(state[S_RATE], -_RATE_MOST, _RATE_MOST)
    current = saturate(foc[F_Q_REF], -12288, 12288)
    sign = 1
    if foc[F_ELEC_GAIN] < 0:
        sign = -1
    omega_l = saturate((rate >> 3) * cfg[K_OMEGA_L] >> 12, -_OMEGA_L_MOST, _OMEGA_L_MOST) * sign
    d = -(omega_l * current >> 16)
    q = ((rate >> 3) * cfg[K_BEMF] >> 16) * sign
    q += dead_time_voltage(current, mul_q15(state[S_BUS], cfg[K_DEAD]), cfg[K_DEAD_ZONE])
    ahead = (rate * cfg[K_ADVANCE] >> 16) * sign
    limit = foc[F_LIMIT]
    d = saturate(d, -limit, limit)
    q = saturate(q, -limit, limit)
    sine = sin_q15(ahead)
    cosine = cos_q15(ahead)
    foc[F_FEED_D] = saturate((d * cosine - q * sine) >> 15, -limit, limit)
    foc[F_FEED_Q] = saturate((d * sine + q * cosine) >> 15, -limit, limit)
    return foc[F_FEED_Q]
