"""The flash memory and its interface: RM0090 section 3, the STM32F405's 1 MiB, without option bytes and interrupts."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from .registers import Peripheral, Register
from .timeline import Due, cycles_of_ns

START, SIZE = 0x0800_0000, 1 << 20
SECTORS = (*(16,) * 4, 64, *(128,) * 7)  # KiB, table 5
KEYS = (0x4567_0123, 0xCDEF_89AB)
PGAERR, PGPERR, PGSERR, BSY = (1 << n for n in (5, 6, 7, 16))
PG, SER, STRT, LOCK = (1 << n for n in (0, 1, 16, 31))
# DS8626, flash memory at 2.7 to 3.6 V: sector erase in ms by PSIZE (x8, x16, x32), typical and longest; a word in ns.
ERASE_MS = {16: ((400, 300, 250), (800, 600, 500)), 64: ((1200, 700, 550), (2400, 1400, 1100)),
            128: ((2000, 1300, 1000), (4000, 2600, 2000))}  # fmt: skip
PROGRAM_NS = (16_000, 100_000)


def sector_range(sector: int) -> range:
    """Return the addresses of a sector (table 5)."""
    first = START + 1024 * sum(SECTORS[:sector])
    return range(first, first + 1024 * SECTORS[sector])


class Flash(Peripheral):
    """Flash interface and contents.

    ``step(what, address, value)`` is called before every program ("program") and erase ("erase"), and may raise to
    cut the power there; ``cut_power()`` leaves what is under way half done. ``longest`` takes the longest times of the
    data sheet instead of the typical ones.
    """

    write_sizes: ClassVar = (1, 2, 4)
    registers: ClassVar = (
        Register("ACR", 0x00, 0x705, 0x1F07),  # as start-up code leaves it
        Register("KEYR", 0x04, readable=False),
        Register("SR", 0x0C, 0, 0xF3),
        Register("CR", 0x10, LOCK, LOCK | STRT | 0x378 | SER | PG),
    )

    def power_up(self) -> None:
        self.contents = bytearray(b"\xff" * SIZE)
        self.step: Callable[[str, int, int], None] | None = None
        self.longest = False
        self._due = Due()
        self._half: Callable[[], None] | None = None

    def clear(self) -> None:
        self.cut_power()
        self.key_step = 0

    # -- memory --

    def holds(self, address: int) -> bool:
        return START <= address < START + SIZE

    def load(self, address: int, size: int) -> int:
        """Read; the bus waits while the flash is busy (3.6)."""
        self._wait()
        return int.from_bytes(self.contents[address - START : address - START + size], "little")

    def _wait(self) -> None:
        if self.chip.now < self.busy_until:
            self.chip.advance(self.busy_until - self.chip.now)

    def program(self, address: int, value: int, size: int) -> None:
        """A write to flash memory (3.6.4): with PG, in words of PSIZE; it can only clear bits."""
        self._wait()
        control = self.value["CR"]
        if not control & PG or control & LOCK:
            self._fail(PGSERR, f"0x{address:08X} written while PG is 0")
        elif size != 1 << (control >> 8 & 3):
            self._fail(PGPERR, f"0x{address:08X} written in {8 * size} bits, PSIZE says {8 << (control >> 8 & 3)}")
        elif address % size:
            self._fail(PGAERR, f"0x{address:08X} is not aligned to {size} bytes")
        elif not self.value["SR"] & (PGSERR | PGPERR | PGAERR):
            self._program(address, value, size)
        else:
            self.complain("SR", "programming with an error flag still set (3.6.4)")

    def _program(self, address: int, value: int, size: int) -> None:
        at = address - START
        old = int.from_bytes(self.contents[at : at + size], "little")
        if value & ~old:
            self.complain(
                "memory", f"0x{address:08X}: bits 0x{value & ~old:X} from 0 to 1, which only erasing can (3.6.4)"
            )
        if self.step:
            self.step("program", address, value)

        def done(word: int = old & value) -> None:
            self._set(at, word.to_bytes(size, "little"))

        half = (1 << 4 * size) - 1  # the lower half of the bits is programmed when the power goes
        self._start(round(cycles_of_ns(PROGRAM_NS[self.longest])), done, lambda: done(old & (value | ~half)))

    def _set(self, at: int, data: bytes) -> None:
        self.contents[at : at + len(data)] = data

    def _start(self, cycles: int, done: Callable[[], None], half: Callable[[], None]) -> None:
        self.busy_until, self._half = self.chip.now + cycles, half
        self.value["SR"] |= BSY

        def finish() -> None:
            done()
            self._half = None
            self.value["SR"] &= ~BSY
            self.value["CR"] &= ~STRT

        self._due = self.chip.at(self.busy_until, finish)

    def cut_power(self) -> None:
        """The power goes: what is under way is left half done."""
        self._due.cancel()
        if self._half:
            self._half()
        self._half, self.busy_until = None, 0

    def _fail(self, flag: int, reason: str) -> None:
        self.value["SR"] |= flag
        self.complain("memory", reason)

    # -- registers, 3.9 --

    def write_KEYR(self, _old: int, new: int) -> None:
        """A wrong key locks CR until the next reset, with a bus error (3.6.1)."""
        if self.key_step < 2 and new == KEYS[self.key_step]:
            self.key_step += 1
            if self.key_step == 2:
                self.value["CR"] &= ~LOCK
                self.key_step = 0
        else:
            self.key_step = 3
            self.complain("KEYR", f"wrong key 0x{new:08X}: locked until the next reset, bus error (3.6.1)")

    def write_SR(self, old: int, new: int) -> None:
        """Flags are cleared by writing 1 (3.9.5)."""
        self.value["SR"] = old & ~(new & 0xF3)

    def write_CR(self, old: int, new: int) -> None:
        if old & LOCK:
            self.refuse("CR", old, "written while locked (3.6.1)")
            return
        if self.chip.now < self.busy_until:
            self.refuse("CR", old, "written while BSY (3.9.7)")
            return
        if new & STRT:
            self._erase(new)

    def _erase(self, control: int) -> None:
        """Sector erase: SER, SNB, then STRT (3.6.3)."""
        sector = control >> 3 & 15
        if not control & SER:
            self.refuse("CR", control & ~STRT, "STRT without SER; mass erase is not modelled")
        elif sector >= len(SECTORS):
            self.refuse("CR", control & ~STRT, f"sector {sector} does not exist (table 5)")
        else:
            self._erase_sector(sector, min(control >> 8 & 3, 2))

    def _erase_sector(self, sector: int, parallel: int) -> None:
        addresses = sector_range(sector)
        if self.step:
            self.step("erase", addresses.start, sector)
        first, size = addresses.start - START, len(addresses)

        def done(length: int = size) -> None:
            self._set(first, b"\xff" * length)

        milliseconds = ERASE_MS[SECTORS[sector]][self.longest][parallel]
        self.chip.note(self.name, f"erase sector {sector}")
        self._start(round(cycles_of_ns(milliseconds * 1e6)), done, lambda: done(size // 2))
