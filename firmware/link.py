"""Frames over a byte stream (USB or UART): how a gait board talks with whatever commands it.

    0xCA 0x5E  kind  length  payload (0 .. 64 bytes)  CRC-16/CCITT-FALSE of kind, length and payload, low byte first

Numbers are little-endian. A broken frame is counted and dropped, and the next sync found. All byte work is done by
hot functions on blocks made beforehand: a stream is taken in blocks, not in bytes (``next_frame``), and a frame is
built in its own bytes (``put`` ... ``close_frame``).
"""

from array import array

from shared.record import field, record
from shared.runtime import Ints, const, hot, ptr8

SYNC_0 = const(0xCA)
SYNC_1 = const(0x5E)
LARGEST = const(64)  # bytes of payload
OVERHEAD = const(6)  # bytes of a frame beside its payload
PAYLOAD = const(4)  # where the payload of a frame to be sent begins

# To the board
COMMAND = const(1)  # COMMAND_SIZE int32: shared/planner/command.py
SENSED = const(2)  # 12 int16 joint angles in brad, as measured
STOP = const(5)  # emergency stop: drive nothing until RESET
RESET = const(6)
READ = const(7)  # uint8 number: read the inertial sensor now and answer with READING
# From the board
SETPOINTS = const(0x81)  # uint32 tick, uint32 flags, uint8 state, uint8 gait, 12 int16 joint angles in brad
READY = const(0x82)  # uint16 planner rate, uint8 number of gaits: sent once at the start
READING = const(0x83)  # uint8 number of the question, uint8 sensor fault, 6 int16 gyro and accelerometer counts

READER_BYTES = const(LARGEST + 4)  # kind, length, payload and CRC of the frame being read
TAKEN = const(2)  # where the payload of a frame read begins

_MASK = const(0x3FFFFFFF)


@record
class Reader:
    """How far a stream is read; the frame being read lies in READER_BYTES bytes beside it."""

    there: int = field("bytes", "of the frame, counted from its second sync byte: 0, 1 wait for the sync")
    next: int = field("bytes", "where next_frame goes on in what it was given")
    broken: int = field("", "frames dropped")


@hot
def crc16(data, start: int, end: int) -> int:
    """Return the CRC-16/CCITT-FALSE (polynomial 0x1021, start 0xFFFF) of data[start:end]."""
    d = ptr8(data)
    crc = 0xFFFF
    for i in range(start, end):
        x = crc >> 8 ^ d[i]
        x ^= x >> 4
        crc = (crc << 8 ^ x << 12 ^ x << 5 ^ x) & 0xFFFF
    return crc


@hot
def next_frame(reader: Reader, frame, data, count: int) -> int:
    """Take data[reader.next:count] up to the end of the first whole frame; return its kind.

    frame[TAKEN:TAKEN + frame[1]] is then its payload, and the next call goes on behind it. Return 0 when all is taken;
    then the next call begins with the first byte of its data. How a stream is split into data does not matter.
    """
    f = ptr8(frame)
    d = ptr8(data)
    at = reader.there
    i = reader.next
    kind = 0
    while i < count and kind == 0:
        byte = d[i]
        i += 1
        if at < 2:
            at = _sync(at, byte)
        else:
            f[at - 2] = byte
            at += 1
            if at == 4 and byte > LARGEST:
                _drop(reader)
                at = 0
            elif at >= 4 and at == f[1] + OVERHEAD:
                at = 0
                kind = _checked(reader, frame)
    reader.there = at
    reader.next = i
    if kind == 0:
        reader.next = 0
    return kind


@hot
def _sync(at: int, byte: int) -> int:
    """Return how many bytes of the sync are there after this one: 0, 1 or 2."""
    if at == 1 and byte == SYNC_1:
        return 2
    if byte == SYNC_0:
        return 1
    return 0


@hot
def _checked(reader: Reader, frame) -> int:
    """Return the kind of a frame whose last byte has come; 0 if its CRC is wrong."""
    f = ptr8(frame)
    end = f[1] + TAKEN
    if crc16(frame, 0, end) == f[end] | f[end + 1] << 8:
        return f[0]
    _drop(reader)
    return 0


@hot
def _drop(reader: Reader) -> None:
    """Count a broken frame."""
    reader.broken = (reader.broken + 1) & _MASK


@hot
def put(frame, at: int, value: int, size: int) -> int:
    """Write the low ``size`` bytes of a number at ``at``; return where the next one goes."""
    f = ptr8(frame)
    for i in range(size):
        f[at + i] = value & 0xFF
        value >>= 8
    return at + size


@hot
def put_each(frame, at: int, values: Ints, count: int, size: int) -> int:
    """Write the low ``size`` bytes of each of ``count`` numbers; return where the next one goes."""
    for i in range(count):
        at = put(frame, at, values[i], size)
    return at


@hot
def close_frame(frame, kind: int, end: int) -> int:
    """Complete the frame whose payload lies in frame[PAYLOAD:end]; return its whole length in bytes."""
    f = ptr8(frame)
    f[0] = SYNC_0
    f[1] = SYNC_1
    f[2] = kind
    f[3] = end - PAYLOAD
    crc = crc16(frame, 2, end)
    return put(frame, end, crc, 2)


@hot
def read_int16(data, at: int) -> int:
    """Return the signed 16-bit number at ``at``."""
    d = ptr8(data)
    value = d[at] | d[at + 1] << 8
    if value & 0x8000:
        value -= 0x10000
    return value


@hot
def read_int30(data, at: int) -> int:
    """Return the signed 32-bit number at ``at``, limited to 30 bits and sign so that it stays a small int."""
    d = ptr8(data)
    high = read_int16(data, at + 2)
    if high < -0x4000:
        return -0x40000000
    if high > 0x3FFF:
        return 0x3FFFFFFF
    return high << 16 | d[at] | d[at + 1] << 8


@hot
def read_each(data, at: int, values: Ints, start: int, count: int) -> None:
    """Write ``count`` signed 16-bit numbers from ``at`` on into values[start:]."""
    for i in range(count):
        values[start + i] = read_int16(data, at + 2 * i)


def int_block(size):
    """Return a block of ``size`` zeros."""
    return array("i", [0] * size)
