"""The gait board's program behind a pipe, in a VM: its sensor and its clock are frames, and time is only simulated.

Runs on MicroPython. Two more kinds of frames go to such a board: COUNTS and TICK.
"""

import sys

from firmware.gait import GaitBoard
from firmware.link import READ, TAKEN, int_block, read_each
from firmware.mpu6050 import MISSING, OK

COUNTS = 3  # 6 int16 gyro and accelerometer counts: what the sensor reads next
TICK = 4  # plan one tick now


class FrameSensor:
    """An inertial sensor whose counts come as COUNTS frames; with no new frame since the last reading it is missing."""

    def __init__(self):
        self._counts = int_block(6)
        self._fresh = False

    def put(self, frame):
        """Take the payload of a COUNTS frame, as link.next_frame leaves it."""
        read_each(frame, TAKEN, self._counts, 0, 6)
        self._fresh = True

    def read(self, counts):
        """See Mpu6050.read."""
        if not self._fresh:
            return MISSING
        self._fresh = False
        for i in range(6):
            counts[i] = self._counts[i]
        return OK


class Pipe:
    """Standard input and output as the link's stream."""

    def __init__(self):
        self._in = sys.stdin.buffer
        self._out = sys.stdout.buffer

    def readinto(self, data):
        """Wait for the next byte; return 1, or 0 at the end of the stream. A whole block would be waited for."""
        byte = self._in.read(1)
        if not byte:
            return 0
        data[0] = byte[0]
        return 1

    def write(self, frame):
        """Send a frame."""
        self._out.write(frame)
        flush = getattr(self._out, "flush", None)
        if flush:
            flush()


def run_piped(params, attitude):
    """Serve a pipe until it closes: every TICK frame plans one tick and answers with its set-points."""
    sensor = FrameSensor()
    board = GaitBoard(params, attitude, sensor)
    pipe = Pipe()
    data = bytearray(1)
    pipe.write(board.ready)
    while pipe.readinto(data):
        kind = board.take(data, 1)
        while kind:
            if kind == COUNTS:
                sensor.put(board.frame)
            elif kind == READ:
                board.answer()
                pipe.write(board.reading)
            elif kind == TICK:
                board.tick()
                pipe.write(board.setpoints)
            kind = board.take(data, 1)
