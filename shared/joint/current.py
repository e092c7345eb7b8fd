"""The current step: Clarke, Park, two PI controllers, inverse Park and SVPWM in one function, 10 000 times a second.

``current_step`` is written for few instructions: in viper its two integer parameters live in
registers and hold the pair it works on (currents, errors, voltages, then the extremes of the
phases), it calls nothing and reads each place once or twice; a product names what comes from memory
before what is in a register, which saves an instruction; one array holds all it needs, its sine
table too, because passing an array is expensive. Rare cases are left to ``current_repair``; the
step's result says so:

    code = current_step(rotor, invalid, loop)
    if code: code = current_repair(code, rotor, invalid, loop)
    if code: switch the bridge off
"""

from ..num.fixed import round_sqrt
from ..runtime import const, hot
from .layout import COSINE_AT, CurrentLoop, LoopSettings
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
def current_step(d: int, q: int, loop: CurrentLoop) -> int:
    """Do one current step; ``d`` is passed as the rotor count 0 .. 16383, ``q`` not 0 if that reading failed its check.

    Reads raw, reference_d, _q and cogging_q, writes duty, current_d and _q, voltage_d and _q of ``loop``. Returns
    STEP_DONE, or what current_repair has to finish.

    Worst error of a duty against exact arithmetic: 0.001 of the period (checked). Bounds: a rebuilt phase reads
    -2796 .. 6894 counts (offsets 1798 .. 2298), so (2a - b - c, sqrt 3 (b - c)) is no longer than 13800, the sums of
    Park stay below 13800 * 32769 < 2^29, the currents within 27600 and their squares below 2^30. The host chooses vu
    and checks that (loop.kp e + integral) stays below 2^30 for currents below the trip, and each voltage below 23170,
    so that the sum of their squares stays below 2^30.
    """
    if (d - loop.rotor + _JUMP) & _JUMP_OUTSIDE | loop.masked | q:
        return STEP_INPUT
    loop.rotor = d
    d = loop.electrical_gain * d + loop.electrical_offset
    q = ((d & 63) - 32) * _RAD_Q22
    c = d >> 6 & 1023
    s = loop.sine[c]
    y = loop.sine[c + COSINE_AT]
    c = y - (s * q >> 22)
    s += y * q >> 22
    x = (loop.raw[0] << 1) - loop.raw[1] - loop.raw[2] - loop.offset_alpha
    y = ((loop.raw[1] - loop.raw[2]) * _SQRT3_Q14 - loop.offset_beta) >> 14
    d = (c * x + s * y + 8192) >> 14
    q = (c * y - s * x + 8192) >> 14
    loop.current_d = d
    loop.current_q = q
    if d * d + q * q > loop.trip_square:
        return STEP_TRIP
    d = loop.reference_d - d
    loop.integral_d = loop.ki * d + loop.integral_d
    d = ((loop.kp * d + loop.integral_d + 4096) >> 13) + loop.feed_d
    q = loop.reference_q + loop.cogging_q - q
    loop.integral_q = loop.ki * q + loop.integral_q
    q = ((loop.kp * q + loop.integral_q + 4096) >> 13) + loop.feed_q
    loop.voltage_d = d
    loop.voltage_q = q
    if d * d + q * q > loop.limit_square:
        return STEP_LIMIT
    y = ((c * d - s * q) >> 11) * loop.gain_alpha >> 14
    q = ((c * q + s * d) >> 11) * loop.gain_beta >> 14
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
    if d - q > loop.span_max:
        return STEP_SHAPE
    d = loop.half_period - ((d + q) >> 1)
    loop.duty[0] = (y + d) >> 4
    loop.duty[1] = (s + d) >> 4
    loop.duty[2] = (c + d) >> 4
    return STEP_DONE


@hot
def current_repair(code: int, rotor: int, invalid: int, loop: CurrentLoop) -> int:
    """Finish what ``current_step`` left with the same arguments; return STEP_DONE or STEP_TRIP.

    A rotor reading that jumps by more than 512 rc or failed its check is replaced by the last good one and counted. A
    phase that had no time to be sampled is the negative sum of the others; if two had none, the voltage of the last
    step is rotated on with the rotor. A voltage vector that is too long is cut, d first. After a trip all duties are
    equal, and loop.tripped tells the motion tick.
    """
    if code == STEP_INPUT:
        if (rotor - loop.rotor + _JUMP) & _JUMP_OUTSIDE | invalid:
            loop.glitches += 1
            if invalid == 0:
                loop.rotor_rejected = rotor
            rotor = loop.rotor
        if _complete_currents(loop) == 0:
            loop.rotor = rotor
            return turn_voltage(loop)
        code = current_step(rotor, 0, loop)
    if code == STEP_LIMIT:
        limit_voltage(loop)
        return turn_voltage(loop)
    if code == STEP_SHAPE:
        return turn_voltage(loop)
    if code == STEP_TRIP:
        loop.tripped = 1
        _equal_duties(loop)
    return code


@hot
def turn_voltage(loop: CurrentLoop) -> int:
    """Write the duties for voltage_d and _q (no longer than voltage_limit) at the rotor's angle; return STEP_DONE."""
    angle = loop.rotor * loop.electrical_gain + loop.electrical_offset
    rest = ((angle & 63) - 32) * _RAD_Q22
    index = angle >> 6 & 1023
    sine0 = loop.sine[index]
    cosine0 = loop.sine[index + COSINE_AT]
    c = cosine0 - (sine0 * rest >> 22)
    s = sine0 + (cosine0 * rest >> 22)
    d = loop.voltage_d
    q = loop.voltage_q
    svpwm(loop, (c * d - s * q) >> 11, (c * q + s * d) >> 11)
    return STEP_DONE


@hot
def limit_voltage(loop: CurrentLoop) -> None:
    """Cut voltage_d, voltage_q to the length voltage_limit, d first.

    Anti-windup by clamping: an integral that the cut axis' error drives further outwards gets this
    step's part taken back. Length error at most 1/2 vu. Squares below 2^30.
    """
    limit = loop.voltage_limit
    loop.limited_steps += 1
    error = loop.reference_d - loop.current_d
    v = loop.voltage_d
    if v > limit or v < 0 - limit:  # not -limit: viper on x64 would negate the local itself
        if (v ^ error) >= 0:
            loop.integral_d -= error * loop.ki
        if v > 0:
            v = limit
        else:
            v = 0 - limit
        loop.voltage_d = v
    limit = round_sqrt(loop.limit_square - v * v)
    error = loop.reference_q + loop.cogging_q - loop.current_q
    v = loop.voltage_q
    if v > limit or v < 0 - limit:
        if (v ^ error) >= 0:
            loop.integral_q -= error * loop.ki
        if v > 0:
            v = limit
        else:
            v = 0 - limit
        loop.voltage_q = v


@hot
def current_reset(loop: CurrentLoop, rotor: int) -> None:
    """Start anew at rotor count 0 .. 16383: no references, integrals, faults; equal duties."""
    loop.rotor = rotor
    loop.rotor_rejected = -1
    loop.masked = 0
    loop.glitches = 0
    loop.limited_steps = 0
    loop.tripped = 0
    loop.current_d = 0
    loop.current_q = 0
    loop.reference_d = 0
    loop.reference_q = 0
    loop.cogging_q = 0
    loop.feed_d = 0
    loop.feed_q = 0
    current_clear(loop)


@hot
def current_clear(loop: CurrentLoop) -> None:
    """Forget integrals and voltage and write equal duties: for a bridge that is off."""
    loop.integral_d = 0
    loop.integral_q = 0
    loop.voltage_d = 0
    loop.voltage_q = 0
    _equal_duties(loop)


@hot
def set_loop(loop: CurrentLoop, loop_settings: LoopSettings) -> None:
    """Hand the stored settings to the current step."""
    loop.kp = loop_settings.current_kp
    loop.ki = loop_settings.current_ki
    loop.period = loop_settings.pwm_period
    loop.half_period = loop_settings.pwm_half
    loop.span_max = loop_settings.pwm_span
    loop.pulse = loop_settings.pwm_pulse
    loop.window = loop_settings.pwm_window
    loop.trip_square = loop_settings.trip_square


@hot
def keep_gains(loop: CurrentLoop, loop_settings: LoopSettings) -> None:
    """Take over the gains that commissioning has given the current step."""
    loop_settings.current_kp = loop.kp
    loop_settings.current_ki = loop.ki


@hot
def set_offsets(loop: CurrentLoop, a_q4: int, b_q4: int, c_q4: int) -> None:
    """Set the readings at no current, in 1/16 count, each 0 .. 65520. Error: 1/2 count in 2a - b - c."""
    loop.offset_q4[0] = a_q4
    loop.offset_q4[1] = b_q4
    loop.offset_q4[2] = c_q4
    loop.offset_alpha = (a_q4 + a_q4 - b_q4 - c_q4 + 8) >> 4
    loop.offset_beta = (((b_q4 - c_q4) * (_SQRT3_Q14 >> 1) + 4) >> 3) - 8192


@hot
def current_sum(loop: CurrentLoop) -> int:
    """Return a + b + c of the last sample in counts; 0 within noise if the sensing is sound. Error 1/2 count."""
    offsets = loop.offset_q4[0] + loop.offset_q4[1] + loop.offset_q4[2]
    return loop.raw[0] + loop.raw[1] + loop.raw[2] - ((offsets + 8) >> 4)


@hot
def _equal_duties(loop: CurrentLoop) -> None:
    half = loop.period >> 1
    for phase in range(3):
        loop.duty[phase] = half


@hot
def _complete_currents(loop: CurrentLoop) -> int:
    """Rebuild the one phase that loop.masked names from the others and clear the mask; 0 if it names more."""
    masked = loop.masked
    loop.masked = 0
    if masked == 0:
        return 1
    if masked & (masked - 1):
        return 0
    wrong = current_sum(loop)
    phase = masked >> 1
    loop.raw[phase] = loop.raw[phase] - wrong
    return 1
