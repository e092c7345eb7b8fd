"""Float twins of the joint's slower maths: conversions, trajectory, loops, tracking, temperatures. SI, plain math."""

import math


def wrap(difference, turn):
    """Return a difference wrapped to half a turn to either side."""
    return (difference + turn / 2) % turn - turn / 2


def braking_speed(distance, accel):
    """Return the speed per tick from which ``accel`` per tick stops after ``distance``: v (v + a) / 2a = d."""
    return math.sqrt(accel * accel / 4 + 2 * accel * distance) - accel / 2


def profile(position, speed, target, target_speed, accel, speed_max):
    """Return (position, speed) of the trajectory limiter one tick later."""
    left = target - position
    if abs(left) <= speed_max and abs(left - speed) <= accel and abs(target_speed - left) <= accel:
        return target, target_speed
    ahead = left - target_speed
    wanted = target_speed + math.copysign(min(braking_speed(abs(ahead), accel), speed_max), ahead)
    wanted = max(-speed_max, min(speed_max, wanted))
    speed += max(-accel, min(accel, wanted - speed))
    return position + speed, speed


def impedance(stiffness, damping, position_error, speed_error, feed):
    """Return stiffness x position error + damping x speed error + feed-forward, in any common units."""
    return stiffness * position_error + damping * speed_error + feed


def fall(value, start, end):
    """Return 1 at ``start`` and before, 0 at ``end`` and beyond, linear between."""
    if start == end:
        return 1.0 if value < end else 0.0
    return max(0.0, min(1.0, (end - value) / (end - start)))


def velocity_loop(error, integral, kp, ki_tick, feed, limit):
    """Return (current, integral) of the PI with clamped integral."""
    wanted = kp * error + integral + feed
    given = max(-limit, min(limit, wanted))
    if given == wanted or (wanted - given) * error < 0:
        integral += ki_tick * error
    return given, integral


def glide(target, rate, goal, feed, left):
    """Rate in equal steps to the goal's, what is missing at the end shared out evenly: (target, rate) after a tick."""
    if left <= 1:
        return goal, feed
    rate += (feed - rate) / left
    missing = goal + feed * (left - 1) - target - left * (rate + feed) / 2
    return target + rate + missing / left, rate


def smooth(fed, wanted):
    """A quarter of the way a tick."""
    return fed + (wanted - fed) / 4


def feed_voltages(rate, current, emf, omega_l, dead, zone, ahead):
    """Return (d, q): back-EMF, coupling and dead time in the rotor's frame, turned ahead by ``ahead`` rad."""
    d = -omega_l * current
    q = emf * rate + dead * max(-1.0, min(1.0, current / zone))
    return d * math.cos(ahead) - q * math.sin(ahead), d * math.sin(ahead) + q * math.cos(ahead)


def lead_angle(offset, rate, per_rate, direction):
    """Return the electrical offset with which an old reading gives the angle that the rotor has by now."""
    return offset + direction * per_rate * rate


def ntc(ohm, r25, beta):
    """Return the temperature in degrees C of an NTC."""
    return 1 / (1 / 298.15 + math.log(ohm / r25) / beta) - 273.15


def ntc_ohm(celsius, r25, beta):
    """Return an NTC's resistance."""
    return r25 * math.exp(beta * (1 / (celsius + 273.15) - 1 / 298.15))


def silicon_ohm(celsius, r25):
    """Return a silicon sensor's resistance."""
    return r25 * (1 + 0.0078 * (celsius - 25))


def mcu(raw, cal1, cal2):
    """Return the microcontroller's temperature in degrees C."""
    return 30 + (raw - cal1) * 80 / (cal2 - cal1)


def copper_W(ohm_25C, ampere, celsius):
    """Return the heat of a three-phase winding with a q current, its copper at a temperature."""
    return 1.5 * ohm_25C * (1 + 0.00393 * (celsius - 25)) * ampere * ampere


class TwoNodes:
    """Winding and housing above the air: heat into the winding, from there to the housing, from there to the air."""

    def __init__(self, winding_J_K, housing_J_K, between_K_W, air_K_W):
        self.data = (winding_J_K, housing_J_K, between_K_W, air_K_W)
        self.winding = self.housing = 0.0

    def step(self, watt, seconds):
        """Advance by one Euler step."""
        cw, ch, between, air = self.data
        flow = (self.winding - self.housing) / between
        winding = self.winding + (watt - flow) * seconds / cw
        self.housing += (flow - self.housing / air) * seconds / ch
        self.winding = winding
