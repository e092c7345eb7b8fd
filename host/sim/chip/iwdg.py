"""The independent watchdog: RM0090 section 21. Its clock, LSI, is 32 kHz, but 17 to 47 kHz by DS8626."""

from __future__ import annotations

from functools import partial
from typing import ClassVar

from .registers import Peripheral, Register
from .timeline import CORE_HZ, Due

RELOAD, UNLOCK, START = 0xAAAA, 0x5555, 0xCCCC
PVU, RVU = 1, 2
LSI_SLOWEST_HZ, LSI_FASTEST_HZ = 17_000, 47_000
UPDATE_LSI_CYCLES = 5  # 21.4.4


class Iwdg(Peripheral):
    """Resets the chip when it has not been fed in time. Once started it stops only by a reset."""

    registers: ClassVar = (
        Register("KR", 0x00, 0, 0xFFFF, readable=False),
        Register("PR", 0x04, 0, 7),
        Register("RLR", 0x08, 0xFFF, 0xFFF),
        Register("SR", 0x0C, 0, 0),
    )

    def power_up(self) -> None:
        self._due = Due()
        for name in ("PR", "RLR"):
            self.on_write(name, partial(self._setting, name))

    def clear(self) -> None:
        self._due.cancel()
        self.running, self.unlocked = False, False
        self.busy_until = {"PR": 0, "RLR": 0}

    @property
    def prescaler(self) -> int:
        """4, 8, ... 256 (21.4.2)."""
        return 4 << min(self.value["PR"], 6)

    def timeout_s(self, lsi_hz: float) -> float:
        """Return the time from a feed to the reset, in s, for a rate of LSI."""
        return (self.value["RLR"] + 1) * self.prescaler / lsi_hz

    @property
    def timeout_range_s(self) -> tuple[float, float]:
        """Return the shortest and the longest time-out over all chips, in s."""
        return self.timeout_s(LSI_FASTEST_HZ), self.timeout_s(LSI_SLOWEST_HZ)

    def write_KR(self, _old: int, new: int) -> None:
        """Any key but 0x5555 closes PR and RLR again (21.3.2)."""
        self.unlocked = new == UNLOCK
        if new == START:
            self.running = True
        if new == START or (new == RELOAD and self.running):
            self._feed()
        elif new not in (UNLOCK, RELOAD):
            self.complain("KR", f"0x{new:04X} is none of 0xAAAA, 0x5555, 0xCCCC")

    def _feed(self) -> None:
        self._due.cancel()
        self._due = self.chip.at(self.chip.now + round(self.timeout_s(self.chip.lsi_hz) * CORE_HZ), self._expire)
        self.chip.note(self.name, "fed")

    def _expire(self) -> None:
        self.chip.note(self.name, "time out")
        self.chip.reset("iwdg")

    def _setting(self, name: str, old: int, _new: int) -> None:
        """PR and RLR need the key, and the last change to have arrived in the LSI domain (21.4.4)."""
        if not self.unlocked:
            self.refuse(name, old, "written without the key 0x5555 (21.4.1)")
        elif self.chip.now < self.busy_until[name]:
            self.refuse(name, old, "written while the last change is under way: wait for SR (21.4.4)")
        else:
            self.busy_until[name] = self.chip.now + round(UPDATE_LSI_CYCLES * CORE_HZ / self.chip.lsi_hz)

    def read_SR(self) -> int:
        busy = {name: self.chip.now < until for name, until in self.busy_until.items()}
        return PVU * busy["PR"] | RVU * busy["RLR"]
