"""The flash controller of an STM32F405 by its registers, hot (RM0090, section 3): unlock, program, lock.

A word or half word takes 16 us, 100 at most (DS8626), in which the processor stands still when its next instruction
lies in the flash. ``memory`` is the flash: on the chip its address, elsewhere a model of it.
"""

from shared.runtime import const, hot, ptr8, reg16, reg32

from .chip import FLASH_CR_32, FLASH_KEYR_32, FLASH_SR_32

BUSY = const(1 << 16)
ERRORS = const(0xF2)  # of SR; they are cleared by writing ones
_PROGRAM_HALF = const(0x101)  # PG, 16 bits at a time (2.1 V or more)
_PROGRAM_WORD = const(0x201)  # PG, 32 bits at a time (2.7 V or more)
_LOCK_BIT = const(31)
_KEY_1_HIGH = const(0x4567)  # the keys in halves: 32 bits do not fit a small int
_KEY_1_LOW = const(0x0123)
_KEY_2_HIGH = const(0xCDEF)
_KEY_2_LOW = const(0x89AB)
_LOCK_HALF = const(0x20000000)  # bit 31, told in a number that is within 2^30
_LOCK_SHIFT = const(2)


@hot
def unlock(chip) -> None:
    """Open the controller and forget its errors."""
    c = reg32(chip)
    if c[FLASH_CR_32] >> _LOCK_BIT & 1:
        high = _KEY_1_HIGH
        c[FLASH_KEYR_32] = high << 16 | _KEY_1_LOW
        high = _KEY_2_HIGH
        c[FLASH_KEYR_32] = high << 16 | _KEY_2_LOW
    c[FLASH_SR_32] = ERRORS


@hot
def lock(chip) -> None:
    """Close the controller."""
    c = reg32(chip)
    half = _LOCK_HALF
    c[FLASH_CR_32] = half << _LOCK_SHIFT


@hot
def program_half(chip, memory, place: int, value: int) -> int:
    """Program half word number ``place`` of the flash by an opened controller; return SR's error bits."""
    c = reg32(chip)
    m = reg16(memory)
    c[FLASH_CR_32] = _PROGRAM_HALF
    m[place] = value
    while c[FLASH_SR_32] & BUSY:
        pass
    return c[FLASH_SR_32] & ERRORS


@hot
def program_word(chip, memory, place: int, low: int, high: int) -> int:
    """Program word number ``place`` of the flash, told in halves, by an opened controller; return SR's error bits."""
    c = reg32(chip)
    m = reg32(memory)
    c[FLASH_CR_32] = _PROGRAM_WORD
    m[place] = high << 16 | low
    while c[FLASH_SR_32] & BUSY:
        pass
    return c[FLASH_SR_32] & ERRORS


@hot
def program_bytes(chip, memory, at: int, data, count: int) -> int:
    """Program ``count`` bytes from byte ``at`` on, both multiples of four; return SR's error bits, 0 if none."""
    d = ptr8(data)
    unlock(chip)
    wrong = 0
    for i in range(0, count, 4):
        low = d[i] | d[i + 1] << 8
        wrong = wrong | program_word(chip, memory, (at + i) >> 2, low, d[i + 2] | d[i + 3] << 8)
    lock(chip)
    return wrong
