"""The flash of an STM32F405 (RM0090, section 3): reads, programs, erases sectors.

A flash, this one or a simulated one, has ``view(at, count)``, ``program(at, data)`` and ``erase(sector)``; ``at``
counts from the beginning of the flash. The processor stands still while it erases: up to 2 s for 128 KiB.
"""

from shared.runtime import const

from .chip import FLASH_ACR_32, FLASH_CR_32, FLASH_SR_32, PERIPHERALS, peek, poke
from .flash_map import BASE, sector_at
from .flash_words import BUSY, ERRORS, lock, program_bytes, unlock

# SR's error bits, and what they say
_SAID = (
    (1 << 4, "this place is protected"),
    (1 << 5, "not aligned"),
    (1 << 6, "not written in whole words"),
    (1 << 7, "the order of operations was wrong"),
    (1 << 1, "the operation failed"),
)
_ERASE = const(0x202)  # SER, 32 bits at a time (2.7 V or more)
_SECTOR_SHIFT = const(3)
_START = const(1 << 16)
_CACHES_ON = const(3 << 9)
_CACHES_RESET = const(3 << 11)


class ChipFlash:
    """The chip's own flash. ``chip`` and ``memory`` are addresses there, and a model of it on a computer."""

    def __init__(self, chip=PERIPHERALS, memory=BASE):
        self.chip = chip
        self.memory = memory

    def view(self, at, count):
        """Return the bytes from ``at`` on as they lie in memory, without a copy."""
        import uctypes

        return uctypes.bytearray_at(BASE + at, count)

    def program(self, at, data):
        """Write whole words into erased flash; OSError with a sentence if they do not read back."""
        if at % 4 or len(data) % 4:
            raise OSError(f"flash {at:#x}: only whole words can be written")
        wrong = program_bytes(self.chip, self.memory, at, data, len(data))
        self.drop_caches()
        self._check(at, wrong)
        if bytes(self.view(at, len(data))) != bytes(data):
            raise OSError(f"flash {at:#x}: reads back something else: was it erased, is it worn out?")

    def erase(self, sector):
        """Erase one sector to ones."""
        control = _ERASE | sector << _SECTOR_SHIFT
        unlock(self.chip)
        poke(self.chip, FLASH_CR_32, control)
        poke(self.chip, FLASH_CR_32, control | _START)
        while peek(self.chip, FLASH_SR_32) & BUSY:
            pass
        wrong = peek(self.chip, FLASH_SR_32) & ERRORS
        lock(self.chip)
        self.drop_caches()
        self._check(sector_at(sector), wrong)

    def drop_caches(self):
        """Forget what the caches hold of the flash as it was (section 3.6): they may be reset only while off."""
        before = peek(self.chip, FLASH_ACR_32)
        off = before & ~_CACHES_ON
        for value in (off, off | _CACHES_RESET, off, before):
            poke(self.chip, FLASH_ACR_32, value)

    def _check(self, at, wrong):
        if wrong:
            words = [sentence for bit, sentence in _SAID if wrong & bit]
            raise OSError(f"flash {at:#x}: {', '.join(words)}")
