"""A simulated sensor: the motion of the plant's body in counts, with a bias and noise like an MPU6050's."""

import random
from collections.abc import Callable
from math import degrees

from sim2d.model import GRAVITY_M_S2

from ..imu.base import INT16_MAX, Axes, Imu
from ..robot.model import Robot

# MPU-6000/6050 product specification 3.4, section 6.1 and 6.2: 0.05 deg/s rms and 400 ug/sqrt(Hz), here at 44 Hz.
GYRO_NOISE_DEG_S = 0.05
ACCEL_NOISE_G = 0.0027
GYRO_BIAS_DEG_S = (1.2, -0.8, 0.5)  # the specification allows 20 (assumed)

Motion = tuple[tuple[float, float, float], tuple[float, float, float]]  # turning speed, specific force


class SimulatedImu(Imu):
    """``motion`` returns turning speed in rad/s and specific force in m/s2, body axes."""

    kind = "simulated"

    def __init__(self, robot: Robot, motion: Callable[[], Motion], seed: int = 0) -> None:
        self._motion, self._random = motion, random.Random(f"imu {seed}")
        self._gyro, self._accel = robot.imu.gyro_counts_per_deg_s, robot.imu.accel_counts_per_g
        self._axes = Axes(robot.imu.axes)

    def open(self) -> None:
        """See Imu."""

    def read(self) -> tuple[int, ...]:
        """See Imu."""
        turn, force = self._motion()
        noise = self._random.gauss
        body = [
            (degrees(rate) + bias + noise(0, GYRO_NOISE_DEG_S)) * self._gyro
            for rate, bias in zip(turn, GYRO_BIAS_DEG_S, strict=True)
        ]
        body += [(part / GRAVITY_M_S2 + noise(0, ACCEL_NOISE_G)) * self._accel for part in force]
        return tuple(round(max(-INT16_MAX, min(INT16_MAX, value))) for value in self._axes.to_sensor(body))

    def close(self) -> None:
        """See Imu."""
