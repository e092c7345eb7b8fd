"""RCC, RM0090 section 7: clock gates, resets, reset flags, and the clock tree as far as start-up code looks at it."""

from __future__ import annotations

from typing import ClassVar

from .registers import Peripheral, Register
from .timeline import cycles_of_ns

# Section 7.3.10 to 7.3.14: which blocks have a clock gate. Bits that are not in the masks are reserved.
AHB1 = 0x6074_11FF
APB1 = 0x36FE_C9FF
APB2 = 0x0007_5F33
APB2_RESET = 0x0007_5933  # 7.3.9: one bit, ADCRST (8), resets all three ADCs
# Section 7.3.21, RCC_CSR.
RESET_FLAGS = {"bor": 25, "pin": 26, "power": 27, "software": 28, "iwdg": 29, "wwdg": 30, "low-power": 31}
RMVF = 1 << 24
# DS8626: start-up of the crystal oscillator (typical), of the PLL (longest), of LSI.
HSE_START_NS, PLL_LOCK_NS, LSI_START_NS, HSI_START_NS = 2_000_000, 300_000, 40_000, 4_000
PRESCALERS = (1, 1, 1, 1, 2, 4, 8, 16)


class Rcc(Peripheral):
    """Reset and clock control. ``hse_hz`` is the crystal of the board."""

    write_sizes: ClassVar = (1, 2, 4)
    registers: ClassVar = (
        Register("CR", 0x00, 0x0000_0083, 0x050D_00F9),
        Register("PLLCFGR", 0x04, 0x2400_3010, 0x0F43_7FFF | 0x2000_0000),
        Register("CFGR", 0x08, 0, 0xFFFF_FCF3),
        Register("CIR", 0x0C, 0, 0x00BF_3F00),
        Register("AHB1RSTR", 0x10, 0, 0x2060_11FF),
        Register("AHB2RSTR", 0x14, 0, 0xF1),
        Register("AHB3RSTR", 0x18, 0, 1),
        Register("APB1RSTR", 0x20, 0, APB1),
        Register("APB2RSTR", 0x24, 0, APB2_RESET),
        Register("AHB1ENR", 0x30, 0x0010_0000, AHB1),
        Register("AHB2ENR", 0x34, 0, 0xF1),
        Register("AHB3ENR", 0x38, 0, 1),
        Register("APB1ENR", 0x40, 0, APB1),
        Register("APB2ENR", 0x44, 0, APB2),
        Register("AHB1LPENR", 0x50, 0x7E67_91FF, 0x7E67_91FF),
        Register("AHB2LPENR", 0x54, 0xF1, 0xF1),
        Register("AHB3LPENR", 0x58, 1, 1),
        Register("APB1LPENR", 0x60, APB1, APB1),
        Register("APB2LPENR", 0x64, APB2, APB2),
        Register("BDCR", 0x70, 0, 0x0001_8305),
        Register("CSR", 0x74, 0x0E00_0000, 0x0100_0001, back=2),
        Register("SSCGR", 0x80, 0, 0xCFFF_FFFF),
        Register("PLLI2SCFGR", 0x84, 0x2000_3000, 0x7000_7FC0),
    )

    def __init__(self, *args: object, hse_hz: int, **more: object) -> None:
        super().__init__(*args, **more)  # type: ignore[arg-type]
        self.hse_hz = hse_hz
        self.ready_at: dict[str, int] = {}

    def reset(self) -> None:
        """Section 7.1: a reset sets all registers but the reset flags in CSR."""
        flags = self.value["CSR"] & 0xFE00_0000
        super().reset()
        self.value["CSR"] = flags
        self.ready_at.clear()

    def note_reset(self, cause: str) -> None:
        """Set the flags of a reset (7.1.1): every reset also pulls NRST, so the pin flag comes with it."""
        also = {"power": ("bor",)}.get(cause, ())
        for name in (cause, "pin", *also):
            self.value["CSR"] |= 1 << RESET_FLAGS[name]

    def start_at_full_speed(self) -> None:
        """Put the clock tree where start-up code leaves it: PLL at 168 MHz, APB1 / 4, APB2 / 2."""
        megahertz = self.hse_hz // 1_000_000
        self.value["CR"] = 0x0303_0083
        self.value["PLLCFGR"] = 7 << 24 | 1 << 22 | 336 << 6 | megahertz | 0x2000_0000
        self.value["CFGR"] = 4 << 13 | 5 << 10 | 2 << 2 | 2

    # -- clock gates --

    def why_not_clocked(self, register: str, bit: int) -> str:
        """Return why a block does not answer, '' if it does. ES0182: the gate opens after a few bus cycles."""
        if not self.value[register] >> bit & 1:
            return f"its clock is off: RCC_{register} bit {bit}"
        opens = self.ready_at.get(f"{register}.{bit}", 0)
        return f"accessed {opens - self.chip.now} cycles too soon after RCC_{register} (errata)" * (
            self.chip.now < opens
        )

    def _gate(self, register: str, old: int, new: int, delay: int) -> None:
        for bit in range(32):
            if (new & ~old) >> bit & 1:
                self.ready_at[f"{register}.{bit}"] = self.chip.now + delay

    def write_AHB1ENR(self, old: int, new: int) -> None:
        self._gate("AHB1ENR", old, new, 2)

    def write_APB1ENR(self, old: int, new: int) -> None:
        self._gate("APB1ENR", old, new, 1 + self.apb1_divider)

    def write_APB2ENR(self, old: int, new: int) -> None:
        self._gate("APB2ENR", old, new, 1 + self.apb2_divider)

    # -- resets --

    def _reset_blocks(self, register: str, old: int, new: int) -> None:
        """A block stays in reset while its bit is set; it is enough to put it there once."""
        enable = register.replace("RSTR", "ENR")
        for block in self.chip.blocks:
            if block.clock and block.clock[0] == enable and (new & ~old) >> self._reset_bit(block.clock) & 1:
                block.reset()

    def _reset_bit(self, clock: tuple[str, int]) -> int:
        return 8 if clock in (("APB2ENR", 9), ("APB2ENR", 10)) else clock[1]

    def write_AHB1RSTR(self, old: int, new: int) -> None:
        self._reset_blocks("AHB1RSTR", old, new)

    def write_APB1RSTR(self, old: int, new: int) -> None:
        self._reset_blocks("APB1RSTR", old, new)

    def write_APB2RSTR(self, old: int, new: int) -> None:
        self._reset_blocks("APB2RSTR", old, new)

    def write_CSR(self, _old: int, new: int) -> None:
        if new & RMVF:
            self.value["CSR"] &= ~(0xFE00_0000 | RMVF)
        self._start("LSI", bool(new & 1), LSI_START_NS)

    def read_CSR(self) -> int:
        return self.value["CSR"] | self._ready("LSI") << 1

    # -- oscillators and the clock tree, 7.2 --

    def _start(self, name: str, on: bool, start_ns: int) -> None:
        if on and name not in self.ready_at:
            self.ready_at[name] = self.chip.now + round(cycles_of_ns(start_ns))
        elif not on:
            self.ready_at.pop(name, None)

    def _ready(self, name: str) -> int:
        return int(name in self.ready_at and self.ready_at[name] <= self.chip.now)

    def write_CR(self, old: int, new: int) -> None:
        for name, bit, start_ns in (("HSI", 0, HSI_START_NS), ("HSE", 16, HSE_START_NS), ("PLL", 24, PLL_LOCK_NS)):
            if (old ^ new) >> bit & 1:
                self.value["CR"] &= ~(2 << bit)
                self._start(name, bool(new >> bit & 1), start_ns)
        if new & ~old & 1 << 24:
            self._check_pll()

    def read_CR(self) -> int:
        for name, bit in (("HSI", 0), ("HSE", 16), ("PLL", 24)):
            if self._ready(name):
                self.value["CR"] |= 2 << bit
        return self.value["CR"]

    def write_PLLCFGR(self, old: int, new: int) -> None:
        if self.value["CR"] >> 24 & 1 and old != new:
            self.refuse("PLLCFGR", old, "written while the PLL runs (7.3.2)")

    def pll_hz(self) -> float:
        """Return SYSCLK as PLLCFGR makes it (7.3.2)."""
        word = self.value["PLLCFGR"]
        source = self.hse_hz if word >> 22 & 1 else 16_000_000
        return source / max(word & 63, 1) * (word >> 6 & 511) / (2 * (word >> 16 & 3) + 2)

    def _check_pll(self) -> None:
        word = self.value["PLLCFGR"]
        source = self.hse_hz if word >> 22 & 1 else 16_000_000
        vco_in = source / max(word & 63, 1)
        vco_out = vco_in * (word >> 6 & 511)
        if word & 63 < 2 or not 950_000 <= vco_in <= 2_100_000 or not 100_000_000 <= vco_out <= 432_000_000:
            self.complain("PLLCFGR", f"VCO input {vco_in:.0f} Hz or output {vco_out:.0f} Hz out of range (7.3.2)")
        if round(self.pll_hz()) != 168_000_000:
            self.complain("PLLCFGR", f"gives {self.pll_hz():.0f} Hz; this model counts in cycles of 168 MHz")

    def read_CFGR(self) -> int:
        """SWS follows SW once the chosen clock is ready (7.3.3)."""
        want = self.value["CFGR"] & 3
        if self.read_CR() & {0: 2, 1: 1 << 17, 2: 1 << 25}.get(want, 0):
            self.value["CFGR"] = self.value["CFGR"] & ~0xC | want << 2
        return self.value["CFGR"]

    def write_CFGR(self, _old: int, new: int) -> None:
        if new & 3 == 2:
            self.chip.flash.check_latency()
        if new >> 4 & 15 >= 8:
            self.complain("CFGR", "AHB prescaler other than 1 is not modelled")
        if self.apb1_divider < 4 or self.apb2_divider < 2:
            self._check_bus_speed()

    def _check_bus_speed(self) -> None:
        if self.value["CFGR"] & 3 == 2:
            self.complain("CFGR", "APB1 above 42 MHz or APB2 above 84 MHz (7.3.3)")

    @property
    def on_pll(self) -> bool:
        return self.read_CFGR() >> 2 & 3 == 2

    @property
    def apb1_divider(self) -> int:
        return PRESCALERS[self.value["CFGR"] >> 10 & 7]

    @property
    def apb2_divider(self) -> int:
        return PRESCALERS[self.value["CFGR"] >> 13 & 7]

    @property
    def tim_apb2_cycles(self) -> int:
        """Core cycles of one clock of TIM1: twice APB2 unless its prescaler is 1 (7.2)."""
        return max(self.apb2_divider // 2, 1)
