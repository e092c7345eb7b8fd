"""The current step written to be read: what shared/joint/current.py computes, to the bit, one idea a function.

Clarke and Park (amplitude-invariant, d along the rotor's flux), a PI controller for each axis with clamping as
anti-windup, the voltage limit with d first, inverse Park, and space-vector modulation by min-max injection. Units as in
shared/joint/layout.py. Works on any object with the fields of CurrentLoop.
"""

from math import isqrt

from shared.num.fixed import cos_q15, sin_q15

SQRT3_Q14 = 28378
RAD_PER_BRAD_Q22 = 402
JUMP_RC = 512  # a step; no rotor is as fast


def step(loop, rotor, invalid):
    """Do one step; return whether the bridge may stay on."""
    rotor = believed_rotor(loop, rotor, invalid)
    known = complete_currents(loop)
    loop.rotor = rotor
    sine, cosine = sine_cosine(loop, rotor)
    if known:
        loop.current_d, loop.current_q = park(*clarke(loop), sine, cosine)
        if loop.current_d**2 + loop.current_q**2 > loop.trip_square:
            loop.tripped = 1
            loop.duty = [loop.period >> 1] * 3
            return False
        control(loop)
    modulate(loop, *inverse_park(loop.voltage_d, loop.voltage_q, sine, cosine))
    return True


def believed_rotor(loop, rotor, invalid):
    """Return the reading, or the one before if it failed its check or jumps; such a one is counted."""
    jump = (rotor - loop.rotor + 8192) % 16384 - 8192
    if not invalid and -JUMP_RC <= jump < JUMP_RC:
        return rotor
    loop.glitches += 1
    if not invalid:
        loop.rotor_rejected = rotor
    return loop.rotor


def complete_currents(loop):
    """Rebuild a phase that had no time to be sampled, as the currents add up to 0; return False if two had none."""
    missing = [phase for phase in range(3) if loop.masked >> phase & 1]
    loop.masked = 0
    if len(missing) == 1:
        loop.raw[missing[0]] -= sum(loop.raw) - (sum(loop.offset_q4) + 8 >> 4)
    return len(missing) < 2


def sine_cosine(loop, rotor):
    """Return both in Q15 of the electrical angle: the table's nearest entry, turned on by the rest."""
    angle = rotor * loop.electrical_gain + loop.electrical_offset  # half an entry is in the offset
    entry, rest_q22 = angle // 64 * 64, (angle % 64 - 32) * RAD_PER_BRAD_Q22
    sine, cosine = sin_q15(entry & 0xFFFF), cos_q15(entry & 0xFFFF)
    return sine + (cosine * rest_q22 >> 22), cosine - (sine * rest_q22 >> 22)


def clarke(loop):
    """Return (2a - b - c, sqrt 3 (b - c)) in counts, which is three times the current."""
    a, b, c = loop.raw
    return 2 * a - b - c - loop.offset_alpha, (b - c) * SQRT3_Q14 - loop.offset_beta >> 14


def park(alpha, beta, sine, cosine):
    """Return (d, q) of a vector, twice as long: counts become cu."""
    return cosine * alpha + sine * beta + 8192 >> 14, cosine * beta - sine * alpha + 8192 >> 14


def control(loop):
    """Set the voltage: a PI controller for each axis, and no longer than the bus allows."""
    error_d, error_q = loop.reference_d - loop.current_d, loop.reference_q - loop.current_q
    loop.integral_d += error_d * loop.ki
    loop.integral_q += error_q * loop.ki
    loop.voltage_d = (error_d * loop.kp + loop.integral_d + 4096 >> 13) + loop.feed_d
    loop.voltage_q = (error_q * loop.kp + loop.integral_q + 4096 >> 13) + loop.feed_q
    if loop.voltage_d**2 + loop.voltage_q**2 > loop.limit_square:
        loop.limited_steps += 1
        loop.voltage_d, back_d = limited(loop.voltage_d, loop.voltage_limit, error_d)
        loop.voltage_q, back_q = limited(loop.voltage_q, rounded_sqrt(loop.limit_square - loop.voltage_d**2), error_q)
        loop.integral_d -= back_d * loop.ki
        loop.integral_q -= back_q * loop.ki


def limited(voltage, limit, error):
    """Return the voltage within its limit, and the error that the integral is not to keep: one that drives outwards."""
    if abs(voltage) <= limit:
        return voltage, 0
    outwards = (voltage < 0) == (error < 0)
    return (limit if voltage > 0 else -limit), error if outwards else 0


def rounded_sqrt(square):
    return (isqrt(4 * square) + 1) // 2


def inverse_park(d, q, sine, cosine):
    """Return (alpha, beta) in 1/16 vu."""
    return cosine * d - sine * q >> 11, cosine * q + sine * d >> 11


def modulate(loop, alpha, beta):
    """Set the duties: the phases' voltages moved so that their extremes lie evenly about half the period."""
    a = alpha * loop.gain_alpha >> 14  # 1/16 compare count
    beta = beta * loop.gain_beta >> 14
    phases = a, beta - (a >> 1), -beta - (a >> 1)
    middle = loop.half_period - (max(phases) + min(phases) >> 1)
    loop.duty = [possible(phase + middle >> 4, loop.pulse, loop.period) for phase in phases]
    loop.masked = sum(1 << phase for phase in range(3) if loop.duty[phase] > loop.period - loop.window)


def possible(duty, shortest, period):
    """Return the nearest duty whose pulses, high and low, are long enough or absent."""
    for pulse, end, inwards in ((duty, 0, 1), (period - duty, period, -1)):
        if 2 * pulse < shortest:
            return end
        if pulse < shortest:
            return end + inwards * shortest
    return duty
