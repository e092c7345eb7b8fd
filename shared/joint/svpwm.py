"""Space-vector modulation by min-max injection: duty = 1/2 + (v - (max + min) / 2) / V_bus, linear to V_bus / sqrt 3.

A duty is the time the high side is on, in compare counts 0 .. foc.period. The current step does the
same for the common case; this is the full form, with the shortest pulses and the sampling windows.
"""

from ..runtime import hot
from .layout import Foc


@hot
def shape_pulse(duty: int, pulse: int, period: int) -> int:
    """Return the duty the bridge can make that is nearest to ``duty``, within 0 .. period.

    A pulse, high or low, is at least ``pulse`` counts long or absent; 0 <= 2 pulse <= period < 2^15.
    duty: any within +-(2^29 - 1). Error at most pulse / 2 for duties within 0 .. period.
    """
    if duty + duty < pulse:
        return 0
    if duty < pulse:
        return pulse
    rest = period - duty
    if rest + rest < pulse:
        return period
    if rest < pulse:
        return period - pulse
    return duty


@hot
def svpwm(foc: Foc, alpha: int, beta: int) -> int:
    """Write the three duties for the voltage (alpha, beta) in 1/16 vu; return foc.masked.

    Range: a vector no longer than 16 voltage_limit; a longer one, up to twice that, is cut phase by phase
    and never leaves 0 .. foc.period. foc.masked gets a bit for each phase whose low side is on for less
    than foc.window, so that its next current sample is not valid. Error at most 1/2 + 1/8 compare
    count plus foc.pulse / 2 near the ends. Intermediates: the host chooses gain_alpha = 2^14
    foc.period / bus, so the products stay below 2^14 * 16 foc.period / sqrt 3 < 2^30 up to foc.period 7000.
    """
    a = alpha * foc.gain_alpha >> 14
    b = beta * foc.gain_beta >> 14
    c = -b - (a >> 1)
    b -= a >> 1
    high = b
    low = c
    if b < c:
        high = c
        low = b
    if a > high:
        high = a
    elif a < low:
        low = a
    middle = foc.half_period - ((high + low) >> 1)
    period = foc.period
    pulse = foc.pulse
    foc.duty[0] = shape_pulse((a + middle) >> 4, pulse, period)
    foc.duty[1] = shape_pulse((b + middle) >> 4, pulse, period)
    foc.duty[2] = shape_pulse((c + middle) >> 4, pulse, period)
    period -= foc.window
    masked = 0
    for phase in range(3):
        if foc.duty[phase] > period:
            masked |= 1 << phase
    foc.masked = masked
    return masked
