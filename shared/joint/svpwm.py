"""Space-vector modulation by min-max injection: duty = 1/2 + (v - (max + min) / 2) / V_bus, linear to V_bus / sqrt 3.

A duty is the time the high side is on, in compare counts 0 .. loop.period. The current step does the
same for the common case; this is the full form, with the shortest pulses and the sampling windows.
"""

from ..runtime import hot
from .layout import CurrentLoop


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
def svpwm(loop: CurrentLoop, alpha: int, beta: int) -> int:
    """Write the three duties for the voltage (alpha, beta) in 1/16 vu; return loop.masked.

    Range: a vector no longer than 16 voltage_limit; a longer one, up to twice that, is cut phase by phase
    and never leaves 0 .. loop.period. loop.masked gets a bit for each phase whose low side is on for less
    than loop.window, so that its next current sample is not valid. Error at most 1/2 + 1/8 compare
    count plus loop.pulse / 2 near the ends. Intermediates: the host chooses gain_alpha = 2^14
    loop.period / bus, so the products stay below 2^14 * 16 loop.period / sqrt 3 < 2^30 up to loop.period 7000.
    """
    a = alpha * loop.gain_alpha >> 14
    b = beta * loop.gain_beta >> 14
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
    middle = loop.half_period - ((high + low) >> 1)
    period = loop.period
    pulse = loop.pulse
    loop.duty[0] = shape_pulse((a + middle) >> 4, pulse, period)
    loop.duty[1] = shape_pulse((b + middle) >> 4, pulse, period)
    loop.duty[2] = shape_pulse((c + middle) >> 4, pulse, period)
    period -= loop.window
    masked = 0
    for phase in range(3):
        if loop.duty[phase] > period:
            masked |= 1 << phase
    loop.masked = masked
    return masked
