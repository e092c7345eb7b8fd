"""The gait controller's loop: take what has arrived, and when a tick is due plan it and send the set-points."""

import time

from .gait import GaitBoard
from .link import READ

BLOCK_BYTES = 64  # taken from a stream at a time: a packet of USB's (full speed)


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
