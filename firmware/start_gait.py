"""Starts a gait board: its inertial sensor on I2C 1, its link on USB, its robot from the build."""

from shared.runtime import const, hot, ptr8

from .gait_main import run_board
from .mpu6050 import Mpu6050
from .robot_params import ATTITUDE, PARAMS

WATCHDOG = False  # it starts none
_CTRL_C = const(3)
_RUN = const(10)  # Ctrl-C in a row that stop the application: no frame holds so many bytes 3 (link.py)


@hot
def ctrl_c_run(data, count: int, run: int) -> int:
    """Return how many bytes of Ctrl-C in a row data[:count] ends with, ``run`` of them before it; _RUN once reached."""
    d = ptr8(data)
    for i in range(count):
        if run < _RUN:
            run += 1
            if d[i] != _CTRL_C:
                run = 0
    return run


class UsbStream:
    """USB as the link's stream. Frames may hold the byte of Ctrl-C, so only ten of them in a row interrupt."""

    def __init__(self, port):
        self._port = port
        self.write = port.write  # of a frame; with nobody listening it is lost
        self._run = 0
        port.setinterrupt(-1)

    def readinto(self, data):
        """Read what has come into ``data``; return how many bytes. KeyboardInterrupt after ten Ctrl-C in a row."""
        count = self._port.readinto(data)
        if not count:
            return 0
        self._run = ctrl_c_run(data, count, self._run)
        if self._run == _RUN:
            self._port.setinterrupt(_CTRL_C)
            raise KeyboardInterrupt
        return count


def motor_supply_mV():
    """Return 0: a gait board feeds no motor."""
    return 0


def armed():
    """Return False: nothing moves by this board's own doing."""
    return False


def start(journal, update):
    """Serve the link for ever; a gait board keeps no settings, and is updated over USB only."""
    import machine
    import pyb

    sensor = Mpu6050(machine.I2C(1, freq=400000))
    run_board(PARAMS, ATTITUDE, sensor, UsbStream(pyb.USB_VCP()))
