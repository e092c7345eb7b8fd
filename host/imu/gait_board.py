"""The inertial sensor of a gait board, over its serial link: each reading is requested, and numbered.

The board keeps doing its own work; its other frames are read and thrown away.
"""

import select
import time
from collections.abc import Callable

import serial

from firmware import link
from firmware.mpu6050 import FAULT_NAMES, OK

from ..protocol.gait_frames import FrameReader, frame
from .base import COUNTS, Imu, ImuError, ImuLate

START_S = 1.0  # a board that has just been opened may still be starting a tick (chosen)
ANSWER_S = 0.004  # as for a servo (host/bus/dynamixel/port.py): USB, the board's tick, the scheduler
WRITE_S = 0.005
BAUD = 115200  # the board's USB accepts any
CHUNK = 4096
READING_BYTES = 2 + 2 * COUNTS  # of its payload (firmware/link.py)


def open_serial(port: str) -> serial.Serial:
    """Return an open serial port, whose reads don't wait; ImuError with what to do."""
    from ..bus.dynamixel.port import explain

    try:
        return serial.Serial(port, BAUD, timeout=0, write_timeout=WRITE_S, exclusive=True)
    except serial.SerialException as error:
        raise ImuError(explain(port, error)) from None


class GaitBoardImu(Imu):
    """The sensor of the board at ``port``."""

    kind = "gait board"

    def __init__(self, port: str, opener: Callable[[str], serial.Serial] = open_serial) -> None:
        self._port, self._opener = port, opener
        self._stream: serial.Serial | None = None
        self._reader = FrameReader()
        self._number, self._reading = 0, b""

    def open(self) -> None:
        """See Imu: the board must answer."""
        self.close()
        try:
            self._stream = self._opener(self._port)
            self._ask(START_S)
        except ImuLate:
            self.close()
            raise ImuError(f"{self._port}: no gait board answers: install its firmware with caramelo flash") from None
        except BaseException:
            self.close()
            raise

    def read(self) -> tuple[int, ...]:
        """See Imu."""
        if self._stream is None:
            raise ImuError(f"{self._port}: not open")
        return self._ask(ANSWER_S)

    def _ask(self, patience_s: float) -> tuple[int, ...]:
        """Ask for a reading and return it; answers to older questions are thrown away."""
        assert self._stream is not None
        end_s = time.monotonic() + patience_s
        self._number = (self._number + 1) & 0xFF
        try:
            self._stream.write(frame(link.READ, (self._number,)))
            while not self._found():
                left_s = end_s - time.monotonic()
                if left_s <= 0 or not select.select([self._stream.fileno()], [], [], left_s)[0]:
                    raise ImuLate(f"{self._port}: the gait board does not answer in time: check its cable and power")
        except serial.SerialTimeoutException:
            raise ImuLate(f"{self._port}: the gait board takes no bytes: check its cable and power") from None
        except (serial.SerialException, OSError) as error:
            raise ImuError(f"{self._port}: the gait board is gone ({error}): check its cable") from None
        fault = self._reading[1]
        if fault != OK:
            name = FAULT_NAMES[fault] if fault < len(FAULT_NAMES) else f"in fault {fault}"
            raise ImuError(f"{self._port}: the gait board's inertial sensor is {name}: check its wires")
        return tuple(link.read_int16(self._reading, 2 + 2 * axis) for axis in range(COUNTS))

    def _found(self) -> bool:
        """Take the available bytes; True if the awaited reading is among them."""
        assert self._stream is not None
        found = False
        for kind, payload in self._reader.frames(self._stream.read(CHUNK) or b""):
            if kind == link.READING and len(payload) == READING_BYTES and payload[0] == self._number:
                self._reading, found = payload, True
        return found

    def close(self) -> None:
        """See Imu."""
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.close()
