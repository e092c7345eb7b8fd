"""Starts the gait controller on a board, or in a VM behind a pipe.

``run`` is the loop of both: take what has arrived, and when a tick is due plan it and send the
set-points. On a board the clock makes ticks due; behind a pipe TICK frames do, so that simulated time
is all there is.
"""

import sys
import time

from firmware.gait import GaitBoard
from firmware.link import COUNTS, READ, TAKEN, TICK, int_block, read_each
from firmware.mpu6050 import MISSING, OK

BLOCK_BYTES = 64  # taken from a stream at a time: a packet of USB's (full speed)


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


def run_board(params, attitude, sensor, stream, clock=time):
    """Serve a board's USB stream for ever: a tick every 1 / rate seconds of the board's own clock.

    ``stream``: readinto(data) returns how many bytes it wrote there, 0 or None if none has come; write(frame). What
    comes is taken a block at a time between looks at the clock, so that a flooded stream cannot hold up a tick.
    A tick that comes late is not made up for: the next is due one period after now.
    """
    board = GaitBoard(params, attitude, sensor)
    period_us = 1000000 // board.rate_hz
    data = bytearray(BLOCK_BYTES)
    stream.write(board.ready)
    due = clock.ticks_add(clock.ticks_us(), period_us)
    while True:
        take_block(board, stream, data)
        now = clock.ticks_us()
        if clock.ticks_diff(now, due) < 0:
            continue
        board.tick()
        stream.write(board.setpoints)
        due = clock.ticks_add(due, period_us)
        if clock.ticks_diff(now, due) > 0:
            due = clock.ticks_add(now, period_us)


def take_block(board, stream, data):
    """Take what has come, at most a block, and answer what it asks."""
    count = stream.readinto(data)
    if not count:
        return
    while True:
        kind = board.take(data, count)
        if not kind:
            return
        if kind == READ:
            board.answer()
            stream.write(board.reading)
