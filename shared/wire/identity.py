"""A board's identity before it has a node: a 30-bit number from the chip's unique id, and when it answers to all.

The number is CRC-30/CDMA (polynomial 0x2030B9C7, 3GPP2 C.S0002) of the unique id, because 30 bits are a small integer
of a 32-bit MicroPython. Not part of the control tick, so plain Python.
"""

from ..runtime import const

_POLYNOMIAL = const(0x2030B9C7)
_ALL_BITS = const(0x3FFFFFFF)
_LOW_BITS = const(0x1FFFFFFF)
DISCOVER_SLOTS = const(64)


def board_id(unique_id: bytes) -> int:
    """Return the board's number, 0 .. 2^30 - 1, from the bytes of the chip's unique id (12 on an STM32F405).

    Exact CRC-30/CDMA. Intermediates below 2^30: the top bit is taken away before the shift.
    Two of 12 boards share a number with probability 6e-8; the full id is in the parameters unique_id_*.
    """
    crc = _ALL_BITS
    for byte in unique_id:
        for place in range(7, -1, -1):
            top = (crc >> 29) ^ ((byte >> place) & 1)
            crc = (crc & _LOW_BITS) << 1
            if top:
                crc ^= _POLYNOMIAL
    return crc ^ _ALL_BITS


def discover_delay_ms(board: int, sequence: int) -> int:
    """Return how long a board waits, 0 .. 63 ms, before it answers a request sent to all.

    Two nodes that answer at once under one identifier destroy each other's frames, so the time depends on
    the board's number; and on the request's sequence number (0 .. 255), so that two boards which meet once
    do not meet every time. Range: board 0 .. 2^30 - 1. Intermediates below 2^30.
    """
    mixed = (board & 0x7FFF) * (2 * (sequence & 0xFF) + 1) + (board >> 15) * (sequence & 0xFF)
    mixed &= _ALL_BITS
    return (mixed ^ (mixed >> 6) ^ (mixed >> 12)) & (DISCOVER_SLOTS - 1)
