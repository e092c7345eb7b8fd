"""A PID controller in floats: parallel form, derivative on the measurement, integral term held while limited."""

from .fixed import limit


class Pid:
    """Gains in 1, 1/s and s; angles and limits in rad."""

    def __init__(self, kp, ki, kd, integral_max, output_max, rate_hz):
        self.kp, self.ki, self.kd = kp, ki / rate_hz, kd * rate_hz
        self.integral_max, self.output_max = integral_max, output_max
        self.reset()

    def reset(self):
        """Forget everything."""
        self.integral = 0.0
        self.previous = None

    def step(self, wanted, measured, error_max):
        """Return the output of one tick; error and change are limited to ``error_max``."""
        error = limit(wanted - measured, -error_max, error_max)
        change = 0.0 if self.previous is None else limit(measured - self.previous, -error_max, error_max)
        self.previous = measured
        direct = self.kp * error - self.kd * change
        output = direct + self.integral
        if (output < self.output_max or error < 0) and (output > -self.output_max or error > 0):
            self.integral = limit(self.integral + self.ki * error, -self.integral_max, self.integral_max)
        return limit(direct + self.integral, -self.output_max, self.output_max)
