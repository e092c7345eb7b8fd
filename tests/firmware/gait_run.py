"""A gait board fed with blocks of a stream while the heap is locked; runs on CPython and in MicroPython alike."""

from firmware.gait import GaitBoard
from firmware.gait_main import BLOCK_BYTES, take_block
from firmware.link import crc16
from firmware.mpu6050 import Mpu6050
from shared.body.params import Params
from shared.record import pack, unpack
from shared.sense.attitude import Attitude


class I2c:
    """A sensor that lies level, with noise, and whose y axis is stuck at its end now and then."""

    def __init__(self):
        self.readings = 0

    def readfrom_mem(self, address, register, count):
        return bytes((0x68 if register == 0x75 else 0,) + (0,) * (count - 1))

    def writeto_mem(self, address, register, data):
        pass

    def readfrom_mem_into(self, address, register, raw):
        self.readings = (self.readings + 1) & 0xFFFF
        raw[4] = 0x40
        raw[9] = self.readings & 7
        raw[2] = 0x80 if self.readings % 300 > 280 else 0


class Stream:
    """Hands out one of ``blocks`` at each reading; keeps a check sum of what is written."""

    def __init__(self, blocks):
        self.blocks, self.at, self.sent, self.digest = blocks, 0, 0, 0xFFFF

    def readinto(self, data):
        block = self.blocks[self.at]
        self.at += 1
        for i in range(len(block)):
            data[i] = block[i]
        return len(block)

    def write(self, frame):
        self.sent += 1
        self.digest = (self.digest * 31 + crc16(frame, 0, len(frame))) & 0xFFFF


def values_of(block):
    """Return a record's integers; in the VMs it is an array."""
    return pack(block) if hasattr(block, "FIELDS") else list(block)


def run(params, attitude, blocks, lock, unlock):
    """Take each block and plan a tick after it; return what was sent and how the board ended.

    ``params`` and ``attitude`` are their integers.
    """
    board = GaitBoard(unpack(Params(), params), unpack(Attitude(), attitude), Mpu6050(I2c(), sleep_ms=lambda ms: None))
    stream, data = Stream(blocks), bytearray(BLOCK_BYTES)
    states = faults = 0
    for _ in range(len(blocks)):
        lock()
        take_block(board, stream, data)
        board.tick()
        stream.write(board.setpoints)
        states |= 1 << board.planner.status.state
        faults |= 1 << (board.status.flags >> 20)
        unlock()
    status, reader = values_of(board.status), values_of(board.reader)
    return [stream.sent, stream.digest, states, faults, status, reader, pack(board.command)]
