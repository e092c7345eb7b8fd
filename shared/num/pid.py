"""A PID controller in integers: derivative on the measurement, clamped integral, limited output.

The gains include the tick: ``ki`` is ki * dt and ``kd`` is kd / dt, so a controller belongs to one rate.
"""

from ..record import field, record
from ..runtime import const, hot
from .fixed import saturate


@record
class Pid:
    """One controller: gains, limits and state."""

    kp_q12: int = field("Q12", "proportional gain, 0 .. 32767")
    ki_q16: int = field("Q16", "ki * dt, 0 .. 32767")
    kd_q10: int = field("Q10", "kd / dt, 0 .. 32767: up to 32, which is 64 ms at 500 Hz")
    integral_max: int = field("of the output", "limit of the integral term, 0 .. 16383")
    output_max: int = field("of the output", "limit of the output, 0 .. 16383")
    integral_q12: int = field("Q12 of the output", "the integral term")
    previous: int = field("of the input", "the last measurement")
    started: int = field("", "0 until there was a measurement")


_ERROR_MAX = const(8191)  # one quarter of a half turn: larger errors act as this one
_Q12_HALF = const(2048)
_RATE_MAX_Q10 = const(0x7FFFFFF)  # 2^17 output units: more than all other terms and the limit together


@hot
def pid_reset(pid: Pid) -> None:
    """Forget the integral and the last measurement of a controller."""
    pid.integral_q12 = 0
    pid.started = 0


@hot
def pid_step(pid: Pid, wanted: int, measured: int) -> int:
    """Return the output of a controller after one more tick.

    wanted, measured: any common unit (balance: brad), each within +-2^20; error and change are
    limited to +-8191. Output within +-output_max. The integral term is limited to
    +-integral_max, and does not grow while the output is limited on the same side.
    Error at most 2 output units plus the rounding of the gains. Intermediates: the sum of the three
    terms in Q12, within 2^28, 2^29 (the derivative is limited to that) and 2^26, is below 2^30.
    """
    error = wanted - measured
    if error > _ERROR_MAX or error < -_ERROR_MAX:
        error = saturate(error, -_ERROR_MAX, _ERROR_MAX)
    change = 0
    if pid.started:
        change = measured - pid.previous
        if change > _ERROR_MAX or change < -_ERROR_MAX:
            change = saturate(change, -_ERROR_MAX, _ERROR_MAX)
    pid.previous = measured
    pid.started = 1
    integral = pid.integral_q12
    rate = change * pid.kd_q10
    if rate > _RATE_MAX_Q10 or rate < -_RATE_MAX_Q10:
        rate = saturate(rate, -_RATE_MAX_Q10, _RATE_MAX_Q10)
    direct = error * pid.kp_q12 - (rate << 2)
    limit = pid.output_max
    step = (error * pid.ki_q16 + 8) >> 4
    before = (direct + integral + _Q12_HALF) >> 12
    if (before < limit or step < 0) and (before > -limit or step > 0):
        top = pid.integral_max << 12
        integral = saturate(integral + step, -top, top)
        pid.integral_q12 = integral
    return saturate((direct + integral + _Q12_HALF) >> 12, -limit, limit)
