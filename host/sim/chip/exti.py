"""External interrupts on pins: RM0090 sections 12.2 and 12.3; the ports are chosen in SYSCFG (9.2). Lines 0 to 15."""

from __future__ import annotations

from typing import ClassVar

from .gpio import PORTS
from .pins import Level
from .registers import Peripheral, Register

LINES = 0x007F_FFFF
PIN_LINES = 16
# Table 61: which interrupt a line raises.
GROUPS = ((6, 0x1), (7, 0x2), (8, 0x4), (9, 0x8), (10, 0x10), (23, 0x3E0), (40, 0xFC00))


class Exti(Peripheral):
    """Edges of pins set bits in PR, and raise interrupts where IMR lets them."""

    write_sizes: ClassVar = (4,)
    registers: ClassVar = (
        *(Register(name, 4 * n, 0, LINES) for n, name in enumerate(("IMR", "EMR", "RTSR", "FTSR", "SWIER", "PR"))),
    )

    def power_up(self) -> None:
        self._watched: set[str] = set()

    def reset(self) -> None:
        super().reset()
        self._interrupt()

    def _pin(self, line: int) -> str:
        port = self.chip.syscfg.value[f"EXTICR{line // 4 + 1}"] >> 4 * (line % 4) & 15
        return f"P{PORTS[port]}{line}" if port < len(PORTS) else ""

    def watch(self) -> None:
        """Watch the pins of the lines that look for an edge."""
        wanted = self.value["RTSR"] | self.value["FTSR"]
        for line in range(PIN_LINES):
            pin = self._pin(line)
            if wanted >> line & 1 and pin and pin not in self._watched:
                self._watched.add(pin)
                self.chip.pins.watch(pin, lambda level, line=line, pin=pin: self._edge(line, pin, level))  # type: ignore[misc]

    def _edge(self, line: int, pin: str, level: Level) -> None:
        looked_for = self.value["RTSR" if level == 1 else "FTSR"] >> line & 1
        if level is not None and looked_for and pin == self._pin(line):
            self._raise(1 << line)

    def _raise(self, bits: int) -> None:
        self.value["PR"] |= bits
        self.chip.note(self.name, f"lines 0x{bits:X}")
        self._interrupt()

    def _interrupt(self) -> None:
        active = self.value["PR"] & self.value["IMR"]
        for number, lines in GROUPS:
            self.chip.nvic.line(number, self.name, bool(active & lines))

    def write_IMR(self, _old: int, _new: int) -> None:
        self._interrupt()

    def write_RTSR(self, _old: int, _new: int) -> None:
        self.watch()

    def write_FTSR(self, _old: int, _new: int) -> None:
        self.watch()

    def write_SWIER(self, old: int, new: int) -> None:
        self._raise(new & ~old)

    def write_PR(self, old: int, new: int) -> None:
        """Cleared by writing 1, which clears SWIER too (12.3.5, 12.3.6)."""
        self.value["PR"] = old & ~new
        self.value["SWIER"] &= ~new
        self._interrupt()
