"""PWR and SYSCFG as far as start-up code touches them: RM0090 sections 5.4 and 9.2."""

from typing import ClassVar

from .registers import Peripheral, Register

VOSRDY = 1 << 14


class Power(Peripheral):
    """Power control. The regulator is ready at once; low-power modes are left out."""

    registers: ClassVar = (Register("CR", 0x00, 0x4000, 0x43FF), Register("CSR", 0x04, VOSRDY, 0x0300))

    def write_CR(self, _old: int, new: int) -> None:
        """5.4.1: CWUF and CSBF are cleared by the hardware."""
        self.value["CR"] = new & ~0xC


class SystemConfiguration(Peripheral):
    """SYSCFG: EXTICR chooses the ports of external interrupts; the rest does nothing here."""

    registers: ClassVar = (
        Register("MEMRMP", 0x00, 0, 3),
        Register("PMC", 0x04, 0, 0x0080_0000),
        *(Register(f"EXTICR{n}", 0x04 + 4 * n, 0, 0xFFFF) for n in (1, 2, 3, 4)),
        Register("CMPCR", 0x20, 0, 1),
    )

    def write_EXTICR1(self, _old: int, _new: int) -> None:
        self.chip.exti.watch()

    def write_EXTICR2(self, _old: int, _new: int) -> None:
        self.chip.exti.watch()

    def write_EXTICR3(self, _old: int, _new: int) -> None:
        self.chip.exti.watch()

    def write_EXTICR4(self, _old: int, _new: int) -> None:
        self.chip.exti.watch()
