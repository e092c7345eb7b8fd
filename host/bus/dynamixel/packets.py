"""The SDK's packets of one protocol, with fixes for two mistakes of its version 4.1.0.

A servo's answer to an earlier question, which comes late, is taken as that to the present one, and its check sum as the
model or the value. Here an answer of another length than the question's counts as damaged.

In protocol 2.0, where data hold FF FF FD, an FD is stuffed behind it (Robotis e-manual, protocol 2.0, byte stuffing).
The SDK takes it out in place and compares with bytes that it has already moved, so it takes out one too many of
FF FF FD FF FD FD.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

from dynamixel_sdk import COMM_RX_CORRUPT, COMM_SUCCESS, INST_PING, INST_READ, PacketHandler

from .roll_call import ANSWER

_LENGTH = 5  # place of the two bytes of the length, which counts from the instruction to the check sum
_INSTRUCTION = 7
_CRC_BYTES = 2
_STUFFED = b"\xff\xff\xfd\xfd"


def packet_handler(protocol: float) -> Any:
    """Return the SDK's handler of protocol 1.0 or 2.0."""
    handler = PacketHandler(protocol)
    if protocol != 1.0:
        handler.removeStuffing = unstuffed
    handler.txRxPacket = partial(_ask, handler.txRxPacket, due_1 if protocol == 1.0 else due_2)
    return handler


def _ask(ask: Callable[..., Any], due: Callable[[list[int]], int], port: Any, question: list[int]) -> Any:
    """Ask one servo as the SDK does; COMM_RX_CORRUPT for an answer that is not as long as this question's."""
    length = due(question)
    packet, result, error = ask(port, question)
    if result == COMM_SUCCESS and packet is not None and len(packet) != length:
        result = COMM_RX_CORRUPT
    return packet, result, error


def due_1(question: list[int]) -> int:
    """Return how many bytes the answer has, in protocol 1.0: to a read, as many more as the question names."""
    return 6 + (question[6] if question[4] == INST_READ else 0)


def due_2(question: list[int]) -> int:
    """Return the same in protocol 2.0, where a ping is answered with model and firmware."""
    if question[_INSTRUCTION] == INST_READ:
        return 11 + question[10] + (question[11] << 8)
    return ANSWER if question[_INSTRUCTION] == INST_PING else 11


def unstuffed(packet: list[int]) -> list[int]:
    """Take the stuffed bytes out of a whole packet, in place, and return it."""
    end = _INSTRUCTION + packet[_LENGTH] + (packet[_LENGTH + 1] << 8) - _CRC_BYTES
    body = packet[_INSTRUCTION:end]
    kept = [byte for at, byte in enumerate(body) if bytes(body[max(0, at - 3) : at + 1]) != _STUFFED]
    packet[_INSTRUCTION : end + _CRC_BYTES] = [*kept, *packet[end : end + _CRC_BYTES]]
    length = len(kept) + _CRC_BYTES
    packet[_LENGTH], packet[_LENGTH + 1] = length & 0xFF, length >> 8
    return packet
