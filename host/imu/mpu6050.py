"""MPU6050 on the Raspberry Pi's I2C bus: register map RM-MPU-6000A, revision 4.2.

Accelerometer, temperature and gyro are one block of big-endian words, which is read at once, so they belong to the same
instant.
"""

import fcntl
import struct
from typing import Any

from ..robot.model import Robot
from ..util.extras import how_to_get
from .base import Imu, ImuError, ImuLate

BUS, ADDRESS = 1, 0x68
WHERE = f"I2C {BUS}, address 0x{ADDRESS:02x}"
CONFIG, GYRO_CONFIG, ACCEL_CONFIG, ACCEL_OUT, POWER, WHO_AM_I = 0x1A, 0x1B, 0x1C, 0x3B, 0x6B, 0x75
BLOCK = 14  # accelerometer, temperature, gyro
IDENTITY = 0x68
CLOCK_GYRO_X = 0x01  # awake, clocked by the gyro: steadier than the chip's own oscillator (4.28)
LOW_PASS = 0x03  # 44 Hz, 4.9 ms late (4.3)
GYRO_RANGES = (131.0, 65.5, 32.8, 16.4)  # counts per deg/s by FS_SEL (4.19)
ACCEL_RANGES = (16384, 8192, 4096, 2048)  # counts per g by AFS_SEL (4.17)
# linux/i2c-dev.h: how long a transfer may take, in units of 10 ms. The driver's default of 1 s would block 50 ticks.
I2C_TIMEOUT, TIMEOUT_10MS = 0x0702, 1


def open_i2c(bus: int) -> Any:
    """Return an open SMBus of smbus2 (extra pi) that aborts a slow transfer in time."""
    from smbus2 import SMBus

    opened = SMBus(bus)
    fcntl.ioctl(opened.fd, I2C_TIMEOUT, TIMEOUT_10MS)
    return opened


class Mpu6050(Imu):
    """The sensor, with the ranges of the robot file's scales; ``opener`` makes the I2C bus."""

    kind = "mpu6050"

    def __init__(self, robot: Robot, opener: Any = open_i2c) -> None:
        self._opener = opener
        self._gyro_range = GYRO_RANGES.index(robot.imu.gyro_counts_per_deg_s)
        self._accel_range = ACCEL_RANGES.index(robot.imu.accel_counts_per_g)
        self._i2c: Any = None

    def open(self) -> None:
        """See Imu."""
        self.close()
        try:
            self._set_up()
        except BaseException:
            self.close()
            raise

    def _set_up(self) -> None:
        try:
            self._i2c = self._opener(BUS)
            identity = self._i2c.read_byte_data(ADDRESS, WHO_AM_I)
            if identity != IDENTITY:
                raise ImuError(f"{WHERE}: answers as 0x{identity:02x}, an MPU6050 answers as 0x{IDENTITY:02x}")
            for register, value in (
                (POWER, CLOCK_GYRO_X),
                (CONFIG, LOW_PASS),
                (GYRO_CONFIG, self._gyro_range << 3),
                (ACCEL_CONFIG, self._accel_range << 3),
            ):
                self._i2c.write_byte_data(ADDRESS, register, value)
        except ModuleNotFoundError:
            raise ImuError(f"no library for the I2C bus on this machine: {how_to_get('smbus2')}") from None
        except FileNotFoundError:
            raise ImuError(f"/dev/i2c-{BUS}: no such bus: run sudo raspi-config nonint do_i2c 0") from None
        except PermissionError:
            raise ImuError(
                f"/dev/i2c-{BUS}: no permission; run: sudo usermod -aG i2c $USER   and log in again"
            ) from None
        except OSError as error:
            raise ImuError(f"{WHERE}: no MPU6050 answers ({error.strerror or error}): check its wires") from None

    def read(self) -> tuple[int, ...]:
        """See Imu."""
        if self._i2c is None:
            raise ImuError(f"{WHERE}: not open")
        try:
            block = self._i2c.read_i2c_block_data(ADDRESS, ACCEL_OUT, BLOCK)
        except OSError as error:
            raise ImuLate(f"{WHERE}: stopped answering ({error.strerror or error}): check its wires") from None
        ax, ay, az, _, gx, gy, gz = struct.unpack(">7h", bytes(block))
        return gx, gy, gz, ax, ay, az

    def close(self) -> None:
        """See Imu."""
        if self._i2c is not None:
            self._i2c.close()
            self._i2c = None
