"""The DRV8323S gate driver, after its data sheet (TI SLVSDJ3: sections 8.5 SPI, 8.6 register maps, 7.6 timing).

Locking its registers and clearing faults by a short low of ENABLE are left out. SDO and nFAULT have pull-ups.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .pins import Level
from .spi_slave import SpiSlave
from .timeline import Due, cycles_of_ns

if TYPE_CHECKING:
    from .chip import Chip

FAULT1, FAULT2, CONTROL, GATE_HS, GATE_LS, OCP, CSA = range(7)
RESET = {FAULT1: 0, FAULT2: 0, CONTROL: 0, GATE_HS: 0x3FF, GATE_LS: 0x7FF, OCP: 0x159, CSA: 0x283}
WRITABLE = {CONTROL: 0x3FF, GATE_HS: 0x7FF, GATE_LS: 0x7FF, OCP: 0x7FF, CSA: 0x7FF}
READ = 1 << 15
CLR_FLT = 1
FAULT, OTW = 1 << 10, 1 << 7
UNLOCKED = 3  # 8.6.3 LOCK
WAKE_NS = SLEEP_NS = 1_000_000  # t_WAKE, t_SLEEP


class Drv8323s(SpiSlave):
    """A gate driver. ``raise_fault(FAULT1, bit)`` makes a fault; nFAULT is pulled low on ``fault_pin``."""

    name = "DRV8323S"
    max_hz = 10_000_000
    select_to_clock_ns = 50.0  # t_SU_nSCS
    deselected_ns = 400.0  # t_HI_nSCS

    def __init__(self, chip: Chip, spi: str, select_pin: str, enable_pin: str, fault_pin: str) -> None:
        super().__init__(chip, spi, select_pin)
        self.fault_pin = fault_pin
        self.registers = dict(RESET)
        self.awake, self.ready_at = False, 0
        self._sleep_due = Due()
        chip.pins.watch(enable_pin, self._enable_changed)
        if chip.pins.level(enable_pin) == 1:
            self._enable_changed(1)
        self._show_fault()

    # -- ENABLE, 8.4.1 --

    def _enable_changed(self, level: Level) -> None:
        if level == 1:
            self._enabled()
        elif self.awake:
            self._sleep_due = self.chip.at(self.chip.now + round(cycles_of_ns(SLEEP_NS)), self._sleep)

    def _enabled(self) -> None:
        self._sleep_due.cancel()
        if self.awake:
            self.complain("ENABLE", "low for less than the 1 ms after which it sleeps")
        else:
            self.awake, self.ready_at = True, self.chip.now + round(cycles_of_ns(WAKE_NS))
            self.chip.at(self.ready_at, self._show_fault)
        self._show_fault()

    def _sleep(self) -> None:
        """Asleep the chip forgets its registers."""
        self.awake = False
        self.registers = dict(RESET)
        self._show_fault()

    @property
    def ready(self) -> bool:
        return self.awake and self.chip.now >= self.ready_at

    # -- faults, 8.3.6 --

    def raise_fault(self, register: int, bits: int) -> None:
        """Set fault bits; all but the temperature warning set FAULT and pull nFAULT low, until they are cleared."""
        self.registers[register] |= bits
        if bits & ~OTW or register == FAULT1 or self.registers[CONTROL] & OTW:
            self.registers[FAULT1] |= FAULT
        self._show_fault()

    def _clear_faults(self) -> None:
        self.registers[FAULT1] = self.registers[FAULT2] = 0
        self._show_fault()

    def _show_fault(self) -> None:
        """nFAULT is open drain. Asleep and until t_WAKE is over the data sheet leaves it open: here it is low."""
        low = bool(self.registers[FAULT1] & FAULT) or not self.ready
        self.chip.pins.drive_pin(self.fault_pin, 0 if low else 1)

    # -- SPI, 8.5.1 --

    def clock_to_deselect_ns(self) -> float:
        """t_H_nSCS."""
        return 50.0

    def answer(self) -> int:
        if not self.ready:
            self.complain("SPI", "selected while asleep or within 1 ms of ENABLE")
        return 0

    def respond(self, command: int) -> int:
        """The register's value follows the five command bits in the same word, in a write too."""
        return self.registers.get(command >> 11 & 15, 0) if self.ready else 0xFFFF

    def wrong_length(self) -> None:
        self.complain("SPI", "not 16 bits: ignored")

    def take(self, word: int) -> None:
        address, data = word >> 11 & 15, word & 0x7FF
        if word & READ or not self.ready:
            return
        if address not in WRITABLE:
            self.complain("SPI", f"write to register {address}, which is read-only or not there")
        else:
            self._write(address, data)

    def _write(self, address: int, data: int) -> None:
        if address == GATE_HS and data >> 8 & 7 != UNLOCKED:
            self.complain("SPI", "locking is not modelled (8.6.3)")
        if data & ~WRITABLE[address]:
            self.complain("SPI", f"reserved bits 0x{data & ~WRITABLE[address]:X} of register {address} written")
        self.registers[address] = data & WRITABLE[address]
        if address == CONTROL and data & CLR_FLT:
            self.registers[CONTROL] &= ~CLR_FLT
            self._clear_faults()
