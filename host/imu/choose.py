"""Chooses a command's inertial sensor: on the Pi's I2C, on a gait board, or a recording."""

from pathlib import Path

from ..robot.model import Robot
from ..util.errors import UserError
from .base import Imu

I2C = "i2c"


def open_source(robot: Robot, where: str) -> Imu:
    """Return the sensor, not yet opened: ``i2c``, a gait board's serial port, or a recording's file."""
    if where == I2C:
        from .mpu6050 import Mpu6050

        return Mpu6050(robot)
    if where.endswith(".csv"):
        from .recorded import RecordedImu

        return RecordedImu(Path(where))
    if where.startswith("/"):
        from .gait_board import GaitBoardImu

        return GaitBoardImu(where)
    raise UserError(f"--imu {where}: allowed: {I2C}, a gait board's port such as /dev/ttyACM0, a recording's name.csv")
