"""The SDK's packets of one protocol, with a fix for a mistake of its version 4.1.0 in protocol 2.0.

Where data hold FF FF FD, an FD is stuffed behind it (Robotis e-manual, protocol 2.0, byte stuffing). The SDK takes it
out in place and compares with bytes that it has already moved, so it takes out one too many of FF FF FD FF FD FD.
"""

from typing import Any

from dynamixel_sdk import PacketHandler

_LENGTH = 5  # place of the two bytes of the length, which counts from the instruction to the check sum
_INSTRUCTION = 7
_CRC_BYTES = 2
_STUFFED = b"\xff\xff\xfd\xfd"


def packet_handler(protocol: float) -> Any:
    """Return the SDK's handler of protocol 1.0 or 2.0."""
    handler = PacketHandler(protocol)
    if protocol != 1.0:
        handler.removeStuffing = unstuffed
    return handler


def unstuffed(packet: list[int]) -> list[int]:
    """Take the stuffed bytes out of a whole packet, in place, and return it."""
    end = _INSTRUCTION + packet[_LENGTH] + (packet[_LENGTH + 1] << 8) - _CRC_BYTES
    body = packet[_INSTRUCTION:end]
    kept = [byte for at, byte in enumerate(body) if bytes(body[max(0, at - 3) : at + 1]) != _STUFFED]
    packet[_INSTRUCTION : end + _CRC_BYTES] = [*kept, *packet[end : end + _CRC_BYTES]]
    length = len(kept) + _CRC_BYTES
    packet[_LENGTH], packet[_LENGTH + 1] = length & 0xFF, length >> 8
    return packet
