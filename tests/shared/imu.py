"""A moving IMU for tests: counts of an MPU6050 on a body whose roll and pitch are known, and filters for them."""

import math
from array import array

from host.robot.file import load_robot
from host.robot.scale import attitude_block
from shared.sense.attitude import Attitude

GYRO_COUNTS_PER_RAD_S = 131 * 180 / math.pi
ONE_G = 16384
CARAMELO = load_robot("caramelo")


def block(rate_hz=50, **settings):
    """Return the integer filter of Caramelo at a rate, with other settings where given by name."""
    made = attitude_block(CARAMELO, rate_hz)
    for name, value in settings.items():
        setattr(made, name, value)
    return made


def up(roll, pitch):
    """Return the direction of up in a body with this roll and pitch, R = Rx(roll) Ry(pitch)."""
    return -math.cos(roll) * math.sin(pitch), math.sin(roll), math.cos(roll) * math.cos(pitch)


def counts(roll, pitch, roll_rate, pitch_rate, bias=(0, 0, 0), push_g=(0, 0, 0)):
    """Return the six counts at this attitude, rates in rad/s."""
    rates = roll_rate * math.cos(pitch), pitch_rate, roll_rate * math.sin(pitch)
    gyro = [round(r * GYRO_COUNTS_PER_RAD_S) + b for r, b in zip(rates, bias, strict=True)]
    accel = [round(ONE_G * (u + p)) for u, p in zip(up(roll, pitch), push_g, strict=True)]
    return array("i", [max(-32768, min(32767, v)) for v in gyro + accel])


def angles_deg(made: Attitude):
    """Return the integer filter's roll and pitch."""
    return made.roll * 360 / 65536, made.pitch * 360 / 65536


def apart_deg(one, other):
    """Return the largest difference of angles on the circle."""
    return max(abs((p - q + 180) % 360 - 180) for p, q in zip(one, other, strict=True))
