"""Starts the gait controller on a board, or in a VM behind a pipe.

``run`` is the loop of both: take what has arrived, and when a tick is due plan it and send the
set-points. On a board the clock makes ticks due; behind a pipe TICK frames do, so that simulated time
is all there is.
"""

import sys
import time

from firmware import link
from firmware.gait import GaitBoard
from firmware.mpu6050 import MISSING, OK


class FrameSensor:
    """An inertial sensor whose counts come as COUNTS frames; with no new frame since the last reading it is missing."""

    def __init__(self):
        self._counts = link.int_block(6)
        self._fresh = False

    def put(self, buffer):
        """Take the payload of a COUNTS frame."""
        for i in range(6):
            self._counts[i] = link.read_int16(buffer, 2 + 2 * i)
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

    def read(self):
        """Wait for the next byte; return it, or -1 at the end of the stream."""
        byte = self._in.read(1)
        return byte[0] if byte else -1

    def write(self, buffer, length):
        """Send the first ``length`` bytes."""
        self._out.write(memoryview(buffer)[:length])
        flush = getattr(self._out, "flush", None)
        if flush:
            flush()


def run_piped(params, attitude):
    """Serve a pipe until it closes: every TICK frame plans one tick and answers with its set-points."""
    sensor = FrameSensor()
    board = GaitBoard(params, attitude, sensor)
    pipe = Pipe()
    pipe.write(board.writer.buffer, board.hello())
    while True:
        byte = pipe.read()
        if byte < 0:
            return
        kind = board.take(byte)
        if kind == link.COUNTS:
            sensor.put(board.reader.buffer)
        elif kind == link.READ:
            pipe.write(board.writer.buffer, board.reading())
        elif kind == link.TICK:
            pipe.write(board.writer.buffer, board.tick())


def run_board(params, attitude, sensor, stream, clock=time):
    """Serve a board's USB stream for ever: a tick every 1 / rate seconds of the board's own clock.

    ``stream`` is a pyb.USB_VCP or alike: any(), readinto(buffer), write(buffer). A tick that comes late
    is not made up for: the next is due one period after now.
    """
    board = GaitBoard(params, attitude, sensor)
    period_us = 1000000 // board.rate_hz
    byte = bytearray(1)
    out = memoryview(board.writer.buffer)[: board.hello()]
    stream.write(out)
    setpoints = reading = None
    due = clock.ticks_add(clock.ticks_us(), period_us)
    while True:
        while stream.any():
            if stream.readinto(byte) and board.take(byte[0]) == link.READ:
                length = board.reading()
                if reading is None:
                    reading = memoryview(board.writer.buffer)[:length]  # as are readings
                stream.write(reading)
        now = clock.ticks_us()
        if clock.ticks_diff(now, due) < 0:
            continue
        length = board.tick()
        if setpoints is None:
            setpoints = memoryview(board.writer.buffer)[:length]  # set-point frames are all of one length
        stream.write(setpoints)
        due = clock.ticks_add(due, period_us)
        if clock.ticks_diff(now, due) > 0:
            due = clock.ticks_add(now, period_us)
