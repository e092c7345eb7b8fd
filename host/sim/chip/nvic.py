"""The interrupt controller of the Cortex-M4: PM0214 section 4.3, RM0090 section 12."""

from __future__ import annotations

from typing import ClassVar

from .registers import Peripheral

INTERRUPTS = 82  # table 61, STM32F405
PRIORITY_BITS = 0xF0  # 16 levels (12.1.1)
LEAST_URGENT = 0x100  # below any exception
ISER, IPR = 0x000, 0x300


class Nvic(Peripheral):
    """Interrupts by the number of their exception, which is the interrupt's + 16.

    Who runs the handlers asks ``waiting()``, then calls ``enter(exception)`` and ``leave()``.
    """

    read_sizes: ClassVar = (1, 2, 4)
    write_sizes: ClassVar = (1, 2, 4)

    def clear(self) -> None:
        self.enabled: set[int] = set()
        self.pending: set[int] = set()
        self.active: list[int] = []
        self.priority: dict[int, int] = {}
        self.lines: dict[int, set[str]] = {}

    # -- the blocks' side --

    def line(self, interrupt: int, source: str, high: bool) -> None:
        """A block raises or drops its request. A raised line makes the interrupt pending (PM0214 4.3.9)."""
        exception = interrupt + 16
        users = self.lines.setdefault(exception, set())
        if not high:
            users.discard(source)
        else:
            if not users:
                self._pend(exception)
            users.add(source)

    def _pend(self, exception: int) -> None:
        if exception not in self.pending:
            self.pending.add(exception)
            self.chip.note("NVIC", f"exception {exception} pending")

    # -- the core's side --

    def waiting(self) -> list[int]:
        """Return the pending exceptions that may interrupt what runs now, most urgent first."""
        if not self.pending:
            return []
        running = min((self.priority.get(exception, 0) for exception in self.active), default=LEAST_URGENT)
        ready = [e for e in self.pending & self.enabled if self.priority.get(e, 0) < running]
        return sorted(ready, key=lambda e: (self.priority.get(e, 0), e))

    def enter(self, exception: int) -> None:
        """The core takes an exception."""
        self.pending.discard(exception)
        self.active.append(exception)
        self.chip.note("NVIC", f"exception {exception} entered")

    def leave(self) -> int:
        """The core returns from the exception it runs. A line still high makes it pending again."""
        exception = self.active.pop()
        self.chip.note("NVIC", f"exception {exception} left")
        if self.lines.get(exception):
            self._pend(exception)
        return exception

    # -- registers: enabling and priorities --

    def read(self, offset: int, size: int) -> int:
        if offset >= IPR:
            return sum(self.priority.get(16 + offset - IPR + n, 0) << 8 * n for n in range(size))
        self.complain(f"+0x{offset:X}", "reading is not modelled")
        return 0

    def write(self, offset: int, value: int, size: int) -> None:
        if offset >= IPR:
            for n in range(size):
                self._write_priority(16 + offset - IPR + n, value >> 8 * n & 0xFF)
        elif offset < ISER + 0x20:
            first = 16 + (offset - ISER) * 8
            self._enable({first + n for n in range(8 * size) if value >> n & 1})
        else:
            self.complain(f"+0x{offset:X}", "only enabling and priorities are modelled")

    def _write_priority(self, exception: int, value: int) -> None:
        if value & ~PRIORITY_BITS:
            self.complain("IPR", f"priority 0x{value:02X}: only the upper four bits exist (12.1.1)")
        self.priority[exception] = value & PRIORITY_BITS

    def _enable(self, exceptions: set[int]) -> None:
        for exception in exceptions:
            if exception >= 16 + INTERRUPTS:
                self.complain("ISER", f"interrupt {exception - 16} does not exist (table 61)")
            else:
                self.enabled.add(exception)
