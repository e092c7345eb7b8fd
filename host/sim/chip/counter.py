"""A general-purpose timer that only counts up, TIM5 as a clock: RM0090 section 18. Its channels are left out."""

from __future__ import annotations

from typing import ClassVar

from .registers import ALL, Peripheral, Register

CEN = 1
CYCLES = 2  # of the core per count of the timer's clock: 84 MHz while APB1 is divided by 4 (7.2, figure 21)


class Counter(Peripheral):
    """CNT runs to ARR and starts again at 0. PSC acts from the next update on (18.3.1); UG makes one."""

    registers: ClassVar = (
        Register("CR1", 0x00, 0, CEN),
        Register("EGR", 0x14, 0, 1, readable=False),
        Register("CNT", 0x24, 0, ALL),
        Register("PSC", 0x28, 0, 0xFFFF),
        Register("ARR", 0x2C, ALL, ALL),
    )

    def clear(self) -> None:
        self._began, self._from, self._divider = 0, 0, 1

    def read_CNT(self) -> int:
        if not self.value["CR1"] & CEN:
            return self._from
        passed = (self.chip.now - self._began) // (CYCLES * self._divider)
        return (self._from + passed) % (self.value["ARR"] + 1)

    def write_CNT(self, _old: int, new: int) -> None:
        self._begin(new)

    def write_CR1(self, old: int, new: int) -> None:
        if (old ^ new) & CEN:
            self.value["CR1"] = old
            count = self.read_CNT()
            self.value["CR1"] = new
            self._begin(count)

    def write_EGR(self, _old: int, new: int) -> None:
        if new & 1:
            self._divider = self.value["PSC"] + 1
            self._begin(0)

    def _begin(self, count: int) -> None:
        self._began, self._from = self.chip.now, count
