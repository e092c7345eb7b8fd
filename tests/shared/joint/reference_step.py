"""The current step written to be read: what shared/joint/current.py computes, to the bit, one idea a function.

Clarke and Park (amplitude-invariant, d along the rotor's flux), a PI controller for each axis with clamping as
anti-windup, the voltage limit with d first, inverse Park, and space-vector modulation by min-max injection. Units as in
shared/joint/layout.py. Works on any object with the fields of Foc.
"""

from math import isqrt

from shared.num.fixed import cos_q15, sin_q15

SQRT3_Q14 = 28378
RAD_PER_BRAD_Q22 = 402
JUMP_RC = 512  # a step; no rotor is as fast


def step(foc, rotor, invalid):
    """Do one step; return whether the bridge may stay on."""
    rotor = believed_rotor(foc, rotor, invalid)
    known = complete_currents(foc)
    foc.rotor = rotor
    sine, cosine = sine_cosine(foc, rotor)
    if known:
        foc.current_d, foc.current_q = park(*clarke(foc), sine, cosine)
        if foc.current_d**2 + foc.current_q**2 > foc.trip_square:
            foc.tripped = 1
            foc.duty = [foc.period >> 1] * 3
            return False
        control(foc)
    modulate(foc, *inverse_park(foc.voltage_d, foc.voltage_q, sine, cosine))
    return True


def believed_rotor(foc, rotor, invalid):
    """Return the reading, or the one before if it failed its check or jumps; such a one is counted."""
    jump = (rotor - foc.rotor + 8192) % 16384 - 8192
    if not invalid and -JUMP_RC <= jump < JUMP_RC:
        return rotor
    foc.glitches += 1
    if not invalid:
        foc.rotor_rejected = rotor
    return foc.rotor


def complete_currents(foc):
    """Rebuild a phase that had no time to be sampled, as the currents add up to 0; return False if two had none."""
    missing = [phase for phase in range(3) if foc.masked >> phase & 1]
    foc.masked = 0
    if len(missing) == 1:
        foc.raw[missing[0]] -= sum(foc.raw) - (sum(foc.offset_q4) + 8 >> 4)
    return len(missing) < 2


def sine_cosine(foc, rotor):
    """Return both in Q15 of the electrical angle: the table's nearest entry, turned on by the rest."""
    angle = rotor * foc.electrical_gain + foc.electrical_offset  # half an entry is in the offset
    entry, rest_q22 = angle // 64 * 64, (angle % 64 - 32) * RAD_PER_BRAD_Q22
    sine, cosine = sin_q15(entry & 0xFFFF), cos_q15(entry & 0xFFFF)
    return sine + (cosine * rest_q22 >> 22), cosine - (sine * rest_q22 >> 22)


def clarke(foc):
    """Return (2a - b - c, sqrt 3 (b - c)) in counts, which is three times the current."""
    a, b, c = foc.raw
    return 2 * a - b - c - foc.offset_alpha, (b - c) * SQRT3_Q14 - foc.offset_beta >> 14


def park(alpha, beta, sine, cosine):
    """Return (d, q) of a vector, twice as long: counts become cu."""
    return cosine * alpha + sine * beta + 8192 >> 14, cosine * beta - sine * alpha + 8192 >> 14


def control(foc):
    """Set the voltage: a PI controller for each axis, and no longer than the bus allows."""
    error_d, error_q = foc.reference_d - foc.current_d, foc.reference_q - foc.current_q
    foc.integral_d += error_d * foc.ki
    foc.integral_q += error_q * foc.ki
    foc.voltage_d = (error_d * foc.kp + foc.integral_d + 4096 >> 13) + foc.feed_d
    foc.voltage_q = (error_q * foc.kp + foc.integral_q + 4096 >> 13) + foc.feed_q
    if foc.voltage_d**2 + foc.voltage_q**2 > foc.limit_square:
        foc.limited_steps += 1
        foc.voltage_d, back_d = limited(foc.voltage_d, foc.voltage_limit, error_d)
        foc.voltage_q, back_q = limited(foc.voltage_q, rounded_sqrt(foc.limit_square - foc.voltage_d**2), error_q)
        foc.integral_d -= back_d * foc.ki
        foc.integral_q -= back_q * foc.ki


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


def modulate(foc, alpha, beta):
    """Set the duties: the phases' voltages moved so that their extremes lie evenly about half the period."""
    a = alpha * foc.gain_alpha >> 14  # 1/16 compare count
    beta = beta * foc.gain_beta >> 14
    phases = a, beta - (a >> 1), -beta - (a >> 1)
    middle = foc.half_period - (max(phases) + min(phases) >> 1)
    foc.duty = [possible(phase + middle >> 4, foc.pulse, foc.period) for phase in phases]
    foc.masked = sum(1 << phase for phase in range(3) if foc.duty[phase] > foc.period - foc.window)


def possible(duty, shortest, period):
    """Return the nearest duty whose pulses, high and low, are long enough or absent."""
    for pulse, end, inwards in ((duty, 0, 1), (period - duty, period, -1)):
        if 2 * pulse < shortest:
            return end
        if pulse < shortest:
            return end + inwards * shortest
    return duty
