"""A PID controller in integers: derivative on the measurement, clamped integral, limited output.

One controller is PID_SIZE numbers of a block. Gains already hold the tick: ``KI`` is ki * dt and
``KD`` is kd / dt, so a block belongs to one rate.
"""

from .fixed import saturate
from .runtime import const, hot, ptr32

PID_KP_Q12 = const(0)  # 0 .. 32767
PID_KI_Q16 = const(1)  # 0 .. 32767, ki * dt
PID_KD_Q10 = const(2)  # 0 .. 32767, kd / dt: up to 32, which is 64 ms at 500 Hz
PID_INTEGRAL_MAX = const(3)  # output units, 0 .. 16383
PID_OUTPUT_MAX = const(4)  # output units, 0 .. 16383
PID_INTEGRAL_Q12 = const(5)  # state: the integral term
PID_PREVIOUS = const(6)  # state: the measurement before
PID_STARTED = const(7)  # state: 0 until there is one
PID_SIZE = const(8)

_ERROR_MAX = const(8191)  # one quarter of a half turn: larger errors act as this one
_Q12_HALF = const(2048)
_RATE_MAX_Q10 = const(0x7FFFFFF)  # 2^17 output units: more than all other terms and the limit together


@hot
def pid_reset(block, base: int) -> int:
    """Forget the integral and the last measurement of the controller at ``block[base]``; return 0."""
    b = ptr32(block)
    b[base + PID_INTEGRAL_Q12] = 0
    b[base + PID_STARTED] = 0
    return 0


@hot
def pid_step(block, base: int, wanted: int, measured: int) -> int:
    """Return the output of the controller at ``block[base]`` after one more tick.

    wanted, measured: any common unit (balance: brad), each within +-2^20; error and change are
    limited to +-8191. Output within +-PID_OUTPUT_MAX. The integral term is limited to
    +-PID_INTEGRAL_MAX, and does not grow while the output is limited on the same side.
    Error at most 2 output units plus the rounding of the gains. Intermediates: the sum of the three
    terms in Q12, within 2^28, 2^29 (the derivative is limited to that) and 2^26, is below 2^30.
    """
    b = ptr32(block)
    error = wanted - measured
    if error > _ERROR_MAX or error < -_ERROR_MAX:
        error = saturate(error, -_ERROR_MAX, _ERROR_MAX)
    change = 0
    if b[base + PID_STARTED]:
        change = measured - b[base + PID_PREVIOUS]
        if change > _ERROR_MAX or change < -_ERROR_MAX:
            change = saturate(change, -_ERROR_MAX, _ERROR_MAX)
    b[base + PID_PREVIOUS] = measured
    b[base + PID_STARTED] = 1
    integral = b[base + PID_INTEGRAL_Q12]
    rate = change * b[base + PID_KD_Q10]
    if rate > _RATE_MAX_Q10 or rate < -_RATE_MAX_Q10:
        rate = saturate(rate, -_RATE_MAX_Q10, _RATE_MAX_Q10)
    direct = error * b[base + PID_KP_Q12] - (rate << 2)
    limit = b[base + PID_OUTPUT_MAX]
    step = (error * b[base + PID_KI_Q16] + 8) >> 4
    before = (direct + integral + _Q12_HALF) >> 12
    if (before < limit or step < 0) and (before > -limit or step > 0):
        top = b[base + PID_INTEGRAL_MAX] << 12
        integral = saturate(integral + step, -top, top)
        b[base + PID_INTEGRAL_Q12] = integral
    return saturate((direct + integral + _Q12_HALF) >> 12, -limit, limit)
