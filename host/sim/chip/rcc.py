"""RCC, RM0090 section 7: clock gates and reset flags. The clocks are as start-up code leaves them: 168, 84, 42 MHz."""

from __future__ import annotations

from functools import partial
from typing import ClassVar

from .registers import Peripheral, Register

# Section 7.3.10 to 7.3.14: which blocks have a clock gate. Bits that are not in the masks are reserved.
AHB1 = 0x6074_11FF
APB1 = 0x36FE_C9FF
APB2 = 0x0007_5F33
# Section 7.3.21, RCC_CSR.
RESET_FLAGS = {"pin": 26, "power": 27, "software": 28, "iwdg": 29}
POWERED_UP = 0x0E00_0000  # power, brown-out and pin
# Cycles of the core in one of a bus (7.2): what blocks on it count in.
APB1_CYCLES, APB2_CYCLES = 4, 2
# Errata ES0182: a gate opens after two cycles on AHB, after 1 + prescaler on the others.
GATES = {"AHB1ENR": 2, "APB1ENR": 1 + APB1_CYCLES, "APB2ENR": 1 + APB2_CYCLES}


class Rcc(Peripheral):
    """Reset and clock control."""

    write_sizes: ClassVar = (1, 2, 4)
    registers: ClassVar = (
        Register("AHB1ENR", 0x30, 0x0010_0000, AHB1),
        Register("APB1ENR", 0x40, 0, APB1),
        Register("APB2ENR", 0x44, 0, APB2),
        Register("CSR", 0x74, POWERED_UP, 0),
    )

    def power_up(self) -> None:
        for register in GATES:
            self.on_write(register, partial(self._opened, register))

    def clear(self) -> None:
        self.opens_at: dict[tuple[str, int], int] = {}

    def reset(self) -> None:
        """Section 7.1: a reset sets all registers but the reset flags in CSR."""
        flags = self.value["CSR"]
        super().reset()
        self.value["CSR"] = flags

    def note_reset(self, cause: str) -> None:
        """Set the flags of a reset (7.1.1): every reset also pulls NRST, so the pin flag comes with it."""
        for name in (cause, "pin"):
            self.value["CSR"] |= 1 << RESET_FLAGS[name]

    def why_not_clocked(self, register: str, bit: int) -> str:
        """Return why a block does not answer, '' if it does."""
        if not self.value[register] >> bit & 1:
            return f"its clock is off: RCC_{register} bit {bit}"
        early = self.opens_at.get((register, bit), 0) - self.chip.now
        return f"accessed {early} cycles too soon after RCC_{register} (errata)" if early > 0 else ""

    def _opened(self, register: str, old: int, new: int) -> None:
        for bit in range(32):
            if (new & ~old) >> bit & 1:
                self.opens_at[register, bit] = self.chip.now + GATES[register]
