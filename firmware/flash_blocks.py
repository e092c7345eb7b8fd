"""An image that comes in blocks of six bytes, in any order, over the joints' bus: each goes to the flash as it comes.

A bitmap says which have come; nothing is allocated for a block.
"""

from shared.record import field, record
from shared.runtime import const, hot, ptr8, ptr16
from shared.wire.framing import BLOCK_HIGH

from .flash_words import lock, program_half, program_word, unlock

BLOCK_BYTES = const(6)
_HALVES = const(3)


@record
class Taking:
    """How far an image has come."""

    place: int = field("half words", "where it begins, from the flash's beginning")
    blocks: int = field("", "it has so many")
    last: int = field("half words", "in its last block, 1 .. 3")
    left: int = field("", "blocks that have not come")
    bad: int = field("", "blocks beyond its end")
    wrong: int = field("", "error bits of the flash controller so far")


@hot
def begin_taking(taking: Taking, at: int, length: int) -> int:
    """Expect ``length`` bytes, an even number, from byte ``at`` of the flash on; return how many blocks that makes."""
    taking.place = at >> 1
    taking.blocks = (length + BLOCK_BYTES - 1) // BLOCK_BYTES
    taking.last = _HALVES - (taking.blocks * BLOCK_BYTES - length) // 2
    taking.left = taking.blocks
    taking.bad = 0
    taking.wrong = 0
    return taking.blocks


@hot
def take_block(chip, memory, taking: Taking, bitmap, frame, identifier: int) -> None:
    """Program one block, number and three half words in ``frame``, unless it has come before."""
    f = ptr16(frame)
    b = ptr8(bitmap)
    number = f[0] | (identifier & BLOCK_HIGH) << 16
    if number >= taking.blocks:
        taking.bad = (taking.bad + 1) & 0x3FFFFFFF
        return
    byte = number >> 3
    bit = 1 << (number & 7)
    if b[byte] & bit:
        return
    place = taking.place + number * _HALVES
    unlock(chip)
    if number == taking.blocks - 1:
        for i in range(taking.last):
            taking.wrong = taking.wrong | program_half(chip, memory, place + i, f[1 + i])
    elif place & 1:
        taking.wrong = taking.wrong | program_half(chip, memory, place, f[1])
        taking.wrong = taking.wrong | program_word(chip, memory, (place + 1) >> 1, f[2], f[3])
    else:
        taking.wrong = taking.wrong | program_word(chip, memory, place >> 1, f[1], f[2])
        taking.wrong = taking.wrong | program_half(chip, memory, place + 2, f[3])
    lock(chip)
    b[byte] = b[byte] | bit
    taking.left -= 1


@hot
def next_missing(taking: Taking, bitmap, start: int) -> int:
    """Return the number of the first block from ``start`` on that has not come; ``taking.blocks`` if all have."""
    b = ptr8(bitmap)
    number = start
    while number < taking.blocks:
        if b[number >> 3] == 0xFF:
            number = (number | 7) + 1
        elif b[number >> 3] >> (number & 7) & 1:
            number += 1
        else:
            return number
    return taking.blocks
