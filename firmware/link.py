"""Frames over a byte stream (USB or UART): how a gait board talks with whatever commands it.

    0xCA 0x5E  kind  length  payload (0 .. 64 bytes)  CRC-16/CCITT-FALSE of kind, length and payload, low byte first

Numbers are little-endian. A broken frame is counted and dropped, and the next sync found; nothing
here allocates once the link exists.
"""

from array import array

from shared.runtime import const

SYNC_0 = const(0xCA)
SYNC_1 = const(0x5E)
LARGEST = const(64)

# To the board
COMMAND = const(1)  # COMMAND_SIZE int32: shared/command.py
SENSED = const(2)  # 12 int16 joint angles in brad, as measured
COUNTS = const(3)  # 6 int16 gyro and accelerometer counts: for a board without its own sensor
TICK = const(4)  # plan one tick now: for a board that is paced from outside
STOP = const(5)  # emergency stop: drive nothing until RESET
RESET = const(6)
READ = const(7)  # uint8 number: read the inertial sensor now and answer with READING
# From the board
SETPOINTS = const(0x81)  # uint32 tick, uint32 flags, uint8 state, uint8 gait, 12 int16 joint angles in brad
READY = const(0x82)  # uint16 planner rate, uint8 number of gaits: sent once at the start
READING = const(0x83)  # uint8 number of the question, uint8 sensor fault, 6 int16 counts as in COUNTS


def crc16(data, start, end):
    """Return the CRC-16/CCITT-FALSE (polynomial 0x1021, start 0xFFFF) of data[start:end]."""
    crc = 0xFFFF
    for i in range(start, end):
        crc ^= data[i] << 8
        for _ in range(8):
            crc = (crc << 1) ^ 0x1021 if crc & 0x8000 else crc << 1
            crc &= 0xFFFF
    return crc


class Reader:
    """Finds frames in single bytes: ``take(byte)`` returns a frame's kind when it is complete, else 0.

    ``buffer[2:2 + length]`` then holds the payload. ``broken`` counts frames dropped.
    """

    def __init__(self):
        self.buffer = bytearray(LARGEST + 4)
        self.length = 0
        self.broken = 0
        self._at = -2  # -2, -1: bytes of the sync still to come; else place in the buffer

    def take(self, byte):
        """Take the next byte of the stream; return the kind of the frame it ends, or 0."""
        if self._at < 0:
            self._find_sync(byte)
            return 0
        self.buffer[self._at] = byte
        self._at += 1
        if self._at == 2 and byte > LARGEST:
            return self._drop()
        if self._at < 2 or self._at < self.buffer[1] + 4:
            return 0
        self._at = -2
        end = self.buffer[1] + 2
        if crc16(self.buffer, 0, end) != self.buffer[end] | self.buffer[end + 1] << 8:
            return self._drop()
        self.length = end - 2
        return self.buffer[0]

    def _find_sync(self, byte):
        if self._at == -2:
            if byte == SYNC_0:
                self._at = -1
        elif byte == SYNC_1:
            self._at = 0
        elif byte != SYNC_0:
            self._at = -2

    def _drop(self):
        self._at = -2
        self.broken += 1
        return 0


class Writer:
    """Builds one frame at a time in ``buffer``; ``close`` returns its whole length in bytes."""

    def __init__(self):
        self.buffer = bytearray(LARGEST + 6)
        self.buffer[0] = SYNC_0
        self.buffer[1] = SYNC_1
        self._at = 4

    def open(self, kind):
        """Begin a frame of this kind."""
        self.buffer[2] = kind
        self._at = 4

    def put(self, value, size):
        """Append the low ``size`` bytes of a number."""
        for _ in range(size):
            self.buffer[self._at] = value & 0xFF
            value >>= 8
            self._at += 1

    def close(self):
        """Fill in length and CRC; return the number of bytes to send."""
        end = self._at
        self.buffer[3] = end - 4
        crc = crc16(self.buffer, 2, end)
        self.buffer[end] = crc & 0xFF
        self.buffer[end + 1] = crc >> 8
        return end + 2


def read_int16(buffer, at):
    """Return the signed 16-bit number at ``at``."""
    value = buffer[at] | buffer[at + 1] << 8
    return value - 0x10000 if value & 0x8000 else value


def read_int30(buffer, at):
    """Return the signed 32-bit number at ``at``, limited to 30 bits and sign so that it stays a small int."""
    high = read_int16(buffer, at + 2)
    if high < -0x4000:
        return -0x40000000
    if high > 0x3FFF:
        return 0x3FFFFFFF
    return (high << 16) | buffer[at] | buffer[at + 1] << 8


def int_block(size):
    """Return a block of ``size`` zeros."""
    return array("i", [0] * size)
