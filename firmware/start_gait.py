"""Starts a gait board: its inertial sensor on I2C 1, its link on USB, its robot from the build."""

from shared.runtime import const

from .gait_main import run_board
from .mpu6050 import Mpu6050
from .robot_params import ATTITUDE, PARAMS

WATCHDOG = False  # it starts none
_CTRL_C = const(3)
_RUN = const(10)  # Ctrl-C in a row that stop the application: no frame holds so many bytes 3 (link.py)


class UsbStream:
    """USB as the link's stream. Frames may hold the byte of Ctrl-C, so only ten of them in a row interrupt."""

    def __init__(self, port):
        self._port = port
        self._run = 0
        port.setinterrupt(-1)

    def any(self):
        """Return True if a byte has arrived."""
        return self._port.any()

    def readinto(self, byte):
        """Read one byte into a buffer of one; KeyboardInterrupt after ten Ctrl-C in a row."""
        count = self._port.readinto(byte)
        if count:
            self._run = self._run + 1 if byte[0] == _CTRL_C else 0
            if self._run >= _RUN:
                self._port.setinterrupt(_CTRL_C)
                raise KeyboardInterrupt
        return count

    def write(self, buffer):
        """Send a frame; with nobody listening it is lost."""
        return self._port.write(buffer)


def motor_supply_mV():
    """Return 0: a gait board feeds no motor."""
    return 0


def start():
    """Serve the link for ever."""
    import machine
    import pyb

    sensor = Mpu6050(machine.I2C(1, freq=400000))
    run_board(PARAMS, ATTITUDE, sensor, UsbStream(pyb.USB_VCP()))
