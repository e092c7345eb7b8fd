"""The current step: Clarke, Park, two PI controllers, inverse Park and SVPWM in one function, 10 000 times a second.

``current_step`` is written for few instructions: in viper its two integer parameters live in
registers and hold the pair it works on (currents, errors, voltages, then the extremes of the
phases), it calls nothing and reads each place once or twice; one array holds all it needs, its sine
table too, because handing over an array is dear. What is rare is left to ``current_repair``, and the
step says so by its result:

    code = current_step(rotor, invalid, foc)
    if code: code = current_repair(code, rotor, invalid, foc)
    if code: switch the bridge off
"""

from ..fixed import round_sqrt
from ..runtime import Ints, const, hot
from .layout import (
    F_COSINE,
    F_D_REF,
    F_DUTY_A,
    F_DUTY_B,
    F_DUTY_C,
    F_ELEC_GAIN,
    F_ELEC_OFFSET,
    F_FEED_D,
    F_FEED_Q,
    F_GAIN_ALPHA,
    F_GAIN_BETA,
    F_GLITCHES,
    F_HALF,
    F_I_D,
    F_I_Q,
    F_INTEGRAL_D,
    F_INTEGRAL_Q,
    F_KI,
    F_KP,
    F_LIMIT,
    F_LIMIT_SQUARE,
    F_LIMITED,
    F_MASKED,
    F_OFFSET_A,
    F_OFFSET_ALPHA,
    F_OFFSET_B,
    F_OFFSET_BETA,
    F_OFFSET_C,
    F_PERIOD,
    F_Q_REF,
    F_RAW_A,
    F_RAW_B,
    F_RAW_C,
    F_ROTOR,
    F_ROTOR_SEEN,
    F_SINE,
    F_SPAN,
    F_TRIP_SQUARE,
    F_TRIPPED,
    F_V_D,
    F_V_Q,
)
from .svpwm import svpwm

STEP_DONE = const(0)
STEP_INPUT = const(1)  # a rotor reading or a current sample cannot be used as it is
STEP_LIMIT = const(2)  # the voltage vector is longer than the bus allows
STEP_SHAPE = const(3)  # a pulse is near an end of the period
STEP_TRIP = const(4)  # the current is above the trip level: switch the bridge off

_JUMP = const(512)  # rc a step; 31 turns a ms, faster than any rotor here
_JUMP_OUTSIDE = const(0x3C00)  # bits of (jump + _JUMP) that are 0 for jumps within +-_JUMP
_SQRT3_Q14 = const(28378)
_RAD_Q22 = const(402)  # rad per brad


@hot
def current_step(d: int, q: int, foc: Ints) -> int:
    """Do one current step; ``d`` comes as the rotor count 0 .. 16383, ``q`` not 0 if that reading failed its check.

    Reads F_RAW_*, F_D_REF and F_Q_REF, writes F_DUTY_*, F_I_*, F_V_*. Returns STEP_DONE, or what
    current_repair has to finish.

    Worst error of a duty against exact arithmetic: 0.001 of the period (checked). Bounds: a rebuilt
    phase reads -2796 .. 6894 counts (offsets 1798 .. 2298), so (2a - b - c, sqrt 3 (b - c)) is no longer
    than 13800, the sums of Park stay below 13800 * 32769 < 2^29, the currents within 27600 and their
    squares below 2^30. The host chooses vu and checks that (F_KP e + F_INTEGRAL) stays below 2^30 for
    currents below the trip, and each voltage below 23170, so that the sum of their squares stays below 2^30.
    """
    if (d - foc[F_ROTOR] + _JUMP) & _JUMP_OUTSIDE | foc[F_MASKED] | q:
        return STEP_INPUT
    foc[F_ROTOR] = d
    d = d * foc[F_ELEC_GAIN] + foc[F_ELEC_OFFSET]
    q = ((d & 63) - 32) * _RAD_Q22
    c = d >> 6 & 1023
    s = foc[F_SINE + c]
    y = foc[F_COSINE + c]
    c = y - (s * q >> 22)
    s += y * q >> 22
    x = (foc[F_RAW_A] << 1) - foc[F_RAW_B] - foc[F_RAW_C] - foc[F_OFFSET_ALPHA]
    y = ((foc[F_RAW_B] - foc[F_RAW_C]) * _SQRT3_Q14 - foc[F_OFFSET_BETA]) >> 14
    d = (c * x + s * y + 8192) >> 14
    q = (c * y - s * x + 8192) >> 14
    foc[F_I_D] = d
    foc[F_I_Q] = q
    if d * d + q * q > foc[F_TRIP_SQUARE]:
        return STEP_TRIP
    d = foc[F_D_REF] - d
    foc[F_INTEGRAL_D] = d * foc[F_KI] + foc[F_INTEGRAL_D]
    d = ((d * foc[F_KP] + foc[F_INTEGRAL_D] + 4096) >> 13) + foc[F_FEED_D]
    q = foc[F_Q_REF] - q
    foc[F_INTEGRAL_Q] = q * foc[F_KI] + foc[F_INTEGRAL_Q]
    q = ((q * foc[F_KP] + foc[F_INTEGRAL_Q] + 4096) >> 13) + foc[F_FEED_Q]
    foc[F_V_D] = d
    foc[F_V_Q] = q
    if d * d + q * q > foc[F_LIMIT_SQUARE]:
        return STEP_LIMIT
    y = ((c * d - s * q) >> 11) * foc[F_GAIN_ALPHA] >> 14
    q = ((c * q + s * d) >> 11) * foc[F_GAIN_BETA] >> 14
    d = y >> 1
    c = 0 - q - d
    s = q - d
    d = s
    if q < 0:
        d = c
        q = s
    else:
        q = c
    if y > d:
        d = y
    elif y < q:
        q = y
    if d - q > foc[F_SPAN]:
        return STEP_SHAPE
    d = foc[F_HALF] - ((d + q) >> 1)
    foc[F_DUTY_A] = (y + d) >> 4
    foc[F_DUTY_B] = (s + d) >> 4
    foc[F_DUTY_C] = (c + d) >> 4
    return STEP_DONE


@hot
def current_repair(code: int, rotor: int, invalid: int, foc: Ints) -> int:
    """Finish what ``current_step`` left with the same arguments; return STEP_DONE or STEP_TRIP.

    A rotor reading that jumps by more than 512 rc or failed its check is replaced by the last good
    one and counted. A phase that had no time to be sampled is the negative sum of the others; if
    two had none, the voltage of the last step is turned on with the rotor. A voltage vector that is
    too long is cut, d first. After a trip all duties are equal, and F_TRIPPED tells the motion tick.
    """
    if code == STEP_INPUT:
        if (rotor - foc[F_ROTOR] + _JUMP) & _JUMP_OUTSIDE | invalid:
            foc[F_GLITCHES] += 1
            if invalid == 0:
                foc[F_ROTOR_SEEN] = rotor
            rotor = foc[F_ROTOR]
        if _complete_currents(foc) == 0:
            foc[F_ROTOR] = rotor
            return turn_voltage(foc)
        code = current_step(rotor, 0, foc)
    if code == STEP_LIMIT:
        limit_voltage(foc)
        return turn_voltage(foc)
    if code == STEP_SHAPE:
        return turn_voltage(foc)
    if code == STEP_TRIP:
        foc[F_TRIPPED] = 1
        _equal_duties(foc)
    return code


@hot
def turn_voltage(foc: Ints) -> int:
    """Write the duties for F_V_D, F_V_Q (no longer than F_LIMIT) at the angle of F_ROTOR; return STEP_DONE."""
    angle = foc[F_ROTOR] * foc[F_ELEC_GAIN] + foc[F_ELEC_OFFSET]
    rest = ((angle & 63) - 32) * _RAD_Q22
    index = angle >> 6 & 1023
    sine0 = foc[F_SINE + index]
    cosine0 = foc[F_COSINE + index]
    c = cosine0 - (sine0 * rest >> 22)
    s = sine0 + (cosine0 * rest >> 22)
    d = foc[F_V_D]
    q = foc[F_V_Q]
    svpwm(foc, (c * d - s * q) >> 11, (c * q + s * d) >> 11)
    return STEP_DONE


@hot
def limit_voltage(foc: Ints) -> int:
    """Cut F_V_D, F_V_Q to the length F_LIMIT, d first; return F_LIMITED.

    Anti-windup by clamping: an integral that the cut axis' error drives further outwards gets this
    step's part taken back. Length error at most 1/2 vu. Squares below 2^30.
    """
    limit = foc[F_LIMIT]
    foc[F_LIMITED] += 1
    error = foc[F_D_REF] - foc[F_I_D]
    v = foc[F_V_D]
    if v > limit or v < 0 - limit:  # not -limit: viper on x64 would negate the local itself
        if (v ^ error) >= 0:
            foc[F_INTEGRAL_D] -= error * foc[F_KI]
        if v > 0:
            v = limit
        else:
            v = 0 - limit
        foc[F_V_D] = v
    limit = round_sqrt(foc[F_LIMIT_SQUARE] - v * v)
    error = foc[F_Q_REF] - foc[F_I_Q]
    v = foc[F_V_Q]
    if v > limit or v < 0 - limit:
        if (v ^ error) >= 0:
            foc[F_INTEGRAL_Q] -= error * foc[F_KI]
        if v > 0:
            v = limit
        else:
            v = 0 - limit
        foc[F_V_Q] = v
    return foc[F_LIMITED]


@hot
def current_reset(foc: Ints, rotor: int) -> int:
    """Start anew at rotor count 0 .. 16383: no references, integrals, faults; equal duties. Return 0."""
    foc[F_ROTOR] = rotor
    foc[F_ROTOR_SEEN] = -1
    foc[F_MASKED] = 0
    foc[F_GLITCHES] = 0
    foc[F_LIMITED] = 0
    foc[F_TRIPPED] = 0
    foc[F_I_D] = 0
    foc[F_I_Q] = 0
    foc[F_D_REF] = 0
    foc[F_Q_REF] = 0
    foc[F_FEED_D] = 0
    foc[F_FEED_Q] = 0
    return current_relax(foc)


@hot
def current_relax(foc: Ints) -> int:
    """Forget integrals and voltage and write equal duties: for a bridge that is off. Return 0."""
    foc[F_INTEGRAL_D] = 0
    foc[F_INTEGRAL_Q] = 0
    foc[F_V_D] = 0
    foc[F_V_Q] = 0
    return _equal_duties(foc)


@hot
def set_offsets(foc: Ints, a_q4: int, b_q4: int, c_q4: int) -> int:
    """Set the readings at no current, in 1/16 count, each 0 .. 65520; return 0. Error: 1/2 count in 2a - b - c."""
    foc[F_OFFSET_A] = a_q4
    foc[F_OFFSET_B] = b_q4
    foc[F_OFFSET_C] = c_q4
    foc[F_OFFSET_ALPHA] = (a_q4 + a_q4 - b_q4 - c_q4 + 8) >> 4
    foc[F_OFFSET_BETA] = (((b_q4 - c_q4) * (_SQRT3_Q14 >> 1) + 4) >> 3) - 8192
    return 0


@hot
def current_sum(foc: Ints) -> int:
    """Return a + b + c of the last sample in counts; 0 within noise if the sensing is sound. Error 1/2 count."""
    offsets = foc[F_OFFSET_A] + foc[F_OFFSET_B] + foc[F_OFFSET_C]
    return foc[F_RAW_A] + foc[F_RAW_B] + foc[F_RAW_C] - ((offsets + 8) >> 4)


@hot
def _equal_duties(foc: Ints) -> int:
    half = foc[F_PERIOD] >> 1
    for phase in range(3):
        foc[F_DUTY_A + phase] = half
    return 0


@hot
def _complete_currents(foc: Ints) -> int:
    """Rebuild the one phase that F_MASKED names from the others and clear the mask; 0 if it names more."""
    masked = foc[F_MASKED]
    foc[F_MASKED] = 0
    if masked == 0:
        return 1
    if masked & (masked - 1):
        return 0
    wrong = current_sum(foc)
    phase = masked >> 1
    foc[F_RAW_A + phase] = foc[F_RAW_A + phase] - wrong
    return 1
