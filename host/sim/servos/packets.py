"""Dynamixel packets from the servo's side: instructions in, status packets out. Robotis e-manual, protocol 1.0, 2.0.

Written from the manual and not from the SDK, so that a test between the two means something.
"""

from typing import NamedTuple

PING, READ, WRITE, REBOOT, SYNC_READ, SYNC_WRITE, BULK_READ = 1, 2, 3, 8, 0x82, 0x83, 0x92
STATUS = 0x55
BROADCAST = 0xFE
CRC_POLYNOMIAL = 0x8005
HEADER_2 = b"\xff\xff\xfd"
HEADER_1 = b"\xff\xff"


class Instruction(NamedTuple):
    """One instruction packet; ``intact`` is False if its checksum is wrong."""

    servo: int
    code: int
    parameters: bytes
    intact: bool = True


def _crc_table() -> list[int]:
    table = []
    for byte in range(256):
        value = byte << 8
        for _ in range(8):
            value = (value << 1 ^ CRC_POLYNOMIAL if value & 0x8000 else value << 1) & 0xFFFF
        table.append(value)
    return table


_CRC = _crc_table()


def crc16(data: bytes) -> int:
    """Return the CRC-16 of protocol 2.0: polynomial 0x8005, start 0, not reflected."""
    value = 0
    for byte in data:
        value = (value << 8 ^ _CRC[(value >> 8 ^ byte) & 0xFF]) & 0xFFFF
    return value


def _take_packet(buffer: bytearray, header: bytes, length_at: int, length_size: int) -> bytes | None:
    """Take the first whole packet from the buffer, and the bytes before it; None if there is none yet.

    A packet starts with ``header``; its length, ``length_size`` bytes at ``length_at``, counts the bytes after it.
    """
    at = buffer.find(header)
    if at < 0:
        del buffer[: max(0, len(buffer) - len(header) + 1)]  # the rest may be a header's beginning
        return None
    del buffer[:at]
    counted_from = length_at + length_size
    if len(buffer) < counted_from:
        return None
    end = counted_from + int.from_bytes(buffer[length_at:counted_from], "little")
    if len(buffer) < end:
        return None
    packet = bytes(buffer[:end])
    del buffer[:end]
    return packet


class Framing2:
    """Protocol 2.0."""

    address_size = 2

    def take(self, buffer: bytearray) -> Instruction | None:
        """Take the first whole packet from the buffer; None if there is none yet."""
        packet = _take_packet(buffer, HEADER_2, 5, 2)
        if packet is None:
            return None
        if len(packet) < 10:
            return Instruction(packet[4], 0, b"", False)
        intact = crc16(packet[:-2]) == int.from_bytes(packet[-2:], "little")
        body = packet[7:-2].replace(b"\xff\xff\xfd\xfd", HEADER_2)
        return Instruction(packet[4], body[0], body[1:], intact)

    def status(self, servo: int, error: int, parameters: bytes) -> bytes:
        """Return a status packet."""
        body = (bytes([STATUS, error]) + parameters).replace(HEADER_2, b"\xff\xff\xfd\xfd")
        packet = HEADER_2 + bytes([0, servo]) + (len(body) + 2).to_bytes(2, "little") + body
        return packet + crc16(packet).to_bytes(2, "little")


class Framing1:
    """Protocol 1.0."""

    address_size = 1

    def take(self, buffer: bytearray) -> Instruction | None:
        """See Framing2."""
        packet = _take_packet(buffer, HEADER_1, 3, 1)
        if packet is None:
            return None
        if len(packet) < 6:
            return Instruction(packet[2], 0, b"", False)
        return Instruction(packet[2], packet[4], packet[5:-1], packet[-1] == ~sum(packet[2:-1]) & 0xFF)

    def status(self, servo: int, error: int, parameters: bytes) -> bytes:
        """See Framing2."""
        body = bytes([servo, len(parameters) + 2, error]) + parameters
        return HEADER_1 + body + bytes([~sum(body) & 0xFF])


def framing(protocol: float) -> Framing1 | Framing2:
    """Return a protocol's framing."""
    return Framing1() if protocol == 1.0 else Framing2()
