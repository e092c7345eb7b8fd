"""The flash controller of an STM32F405 by its registers (RM0090, section 3): reads, programs words, erases sectors.

A flash, this one or a simulated one, has ``view(at, count)``, ``program(at, data)`` and ``erase(sector)``; ``at``
counts from the beginning of the flash. The processor stands still while it erases: up to 2 s for 128 KiB.
"""

import machine
import uctypes

from shared.runtime import const

from .flash_map import BASE, sector_at

_KEYR = const(0x40023C04)
_SR = const(0x40023C0C)
_CR = const(0x40023C10)
_ACR = const(0x40023C00)

_BUSY = const(1 << 16)
# SR's error bits, and what they say
_ERRORS = (
    (1 << 4, "this place is protected"),
    (1 << 5, "not aligned"),
    (1 << 6, "not written in whole words"),
    (1 << 7, "the order of operations was wrong"),
    (1 << 1, "the operation failed"),
)
_ALL_ERRORS = const(0xF2)
_PROGRAM = const(1)
_ERASE = const(2)
_SECTOR_SHIFT = const(3)
_START = const(1 << 16)
_WORDS = const(2 << 8)  # 32 bits at a time, at 2.7 V or more
_LOCK_TOP = const(0x80)  # CR's highest byte with LOCK
_CACHES_ON = const(3 << 9)
_CACHES_RESET = const(3 << 11)


class ChipFlash:
    """The chip's own flash."""

    def view(self, at, count):
        """Return the bytes from ``at`` on as they lie in memory, without a copy."""
        return uctypes.bytearray_at(BASE + at, count)

    def program(self, at, data):
        """Write whole words into erased flash; OSError with a sentence if they do not read back."""
        if at % 4 or len(data) % 4:
            raise OSError(f"flash {at:#x}: only whole words can be written")
        self._unlock()
        try:
            machine.mem32[_CR] = _PROGRAM | _WORDS
            for place in range(0, len(data), 4):
                word = data[place] | data[place + 1] << 8 | data[place + 2] << 16 | data[place + 3] << 24
                machine.mem32[BASE + at + place] = word
                self._wait(at + place)
        finally:
            self._lock()
        if bytes(self.view(at, len(data))) != bytes(data):
            raise OSError(f"flash {at:#x}: reads back something else: was it erased, is it worn out?")

    def erase(self, sector):
        """Erase one sector to ones."""
        self._unlock()
        try:
            machine.mem32[_CR] = _ERASE | _WORDS | sector << _SECTOR_SHIFT
            machine.mem32[_CR] = _ERASE | _WORDS | sector << _SECTOR_SHIFT | _START
            self._wait(sector_at(sector))
        finally:
            self._lock()

    def _unlock(self):
        if machine.mem8[_CR + 3] & _LOCK_TOP:
            machine.mem32[_KEYR] = 0x45670123
            machine.mem32[_KEYR] = 0xCDEF89AB
        machine.mem32[_SR] = _ALL_ERRORS

    def _wait(self, at):
        while machine.mem32[_SR] & _BUSY:
            pass
        wrong = machine.mem32[_SR] & _ALL_ERRORS
        if wrong:
            words = [sentence for bit, sentence in _ERRORS if wrong & bit]
            raise OSError(f"flash {at:#x}: {', '.join(words)}")

    def _lock(self):
        """Lock the controller and drop what the caches hold of the flash as it was (section 3.6)."""
        machine.mem8[_CR + 3] = _LOCK_TOP
        before = machine.mem32[_ACR]
        machine.mem32[_ACR] = before & ~_CACHES_ON
        machine.mem32[_ACR] = before & ~_CACHES_ON | _CACHES_RESET
        machine.mem32[_ACR] = before & ~_CACHES_ON
        machine.mem32[_ACR] = before
