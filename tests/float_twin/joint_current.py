"""Float twin of the current step and its parts: SI units, plain math, also runs on MicroPython."""

import math

SQRT3 = math.sqrt(3.0)


def svpwm(alpha, beta, bus):
    """Return the three duties by min-max injection, closed form."""
    a = alpha
    b = SQRT3 / 2 * beta - alpha / 2
    c = -SQRT3 / 2 * beta - alpha / 2
    middle = (max(a, b, c) + min(a, b, c)) / 2
    return 0.5 + (a - middle) / bus, 0.5 + (b - middle) / bus, 0.5 + (c - middle) / bus


def limit_voltage(d, q, limit):
    """Return (d, q) cut to the length ``limit``, d first."""
    if d * d + q * q <= limit * limit:
        return d, q
    d = max(-limit, min(limit, d))
    room = math.sqrt(limit * limit - d * d)
    return d, max(-room, min(room, q))


class CurrentLoop:
    """State and data of the step in SI; ``step`` does what current_step and current_repair do for valid inputs."""

    def __init__(self, kp, ki_step, bus, pole_pairs, offset):
        self.kp = kp
        self.ki = ki_step
        self.bus = bus
        self.pole_pairs = pole_pairs
        self.offset = offset
        self.d_ref = self.q_ref = 0.0
        self.feed_d = self.feed_q = 0.0
        self.integral_d = self.integral_q = 0.0
        self.i_d = self.i_q = 0.0
        self.v_d = self.v_q = 0.0
        self.duty_a = self.duty_b = self.duty_c = 0.5

    def step(self, rotor, a, b, c):
        """Take the rotor's angle in rad and three phase currents in A; set i, v and the duties."""
        angle = self.pole_pairs * rotor + self.offset
        s = math.sin(angle)
        k = math.cos(angle)
        alpha = (2 * a - b - c) / 3
        beta = (b - c) / SQRT3
        self.i_d = k * alpha + s * beta
        self.i_q = k * beta - s * alpha
        error_d = self.d_ref - self.i_d
        error_q = self.q_ref - self.i_q
        integral_d = self.integral_d + self.ki * error_d
        integral_q = self.integral_q + self.ki * error_q
        d = self.kp * error_d + integral_d + self.feed_d
        q = self.kp * error_q + integral_q + self.feed_q
        limit = self.bus / SQRT3
        if d * d + q * q > limit * limit:
            cut_d, cut_q = limit_voltage(d, q, limit)
            if cut_d != d and (d >= 0) == (error_d >= 0):
                integral_d = self.integral_d
            if cut_q != q and (q >= 0) == (error_q >= 0):
                integral_q = self.integral_q
            d = cut_d
            q = cut_q
        self.integral_d = integral_d
        self.integral_q = integral_q
        self.v_d = d
        self.v_q = q
        self.duty_a, self.duty_b, self.duty_c = svpwm(k * d - s * q, s * d + k * q, self.bus)
