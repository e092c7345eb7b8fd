"""SPI1 and SPI3 as masters of 16-bit words, one after the other: RM0090 section 28."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from .rcc import APB1_CYCLES, APB2_CYCLES
from .registers import Peripheral, Register
from .timeline import CORE_HZ, Due

if TYPE_CHECKING:
    from .spi_slave import SpiSlave

CPHA, CPOL, MSTR, SPE, SSI, SSM, DFF = (1 << n for n in (0, 1, 2, 6, 8, 9, 11))
RATE = 7 << 3
RXNE, TXE, OVR, BSY = (1 << n for n in (0, 1, 6, 7))
BITS = 16


class Spi(Peripheral):
    """One SPI block. ``slaves`` are the chips on its wires; ``frames`` are (start, end, sent, received)."""

    registers: ClassVar = (
        Register("CR1", 0x00, 0, CPHA | CPOL | MSTR | RATE | SPE | SSI | SSM | DFF),
        Register("CR2", 0x04, 0, 0),
        Register("SR", 0x08, TXE, 0),
        Register("DR", 0x0C, 0, 0xFFFF),
    )

    def power_up(self) -> None:
        self.slaves: list[SpiSlave] = []
        self.frames: list[tuple[int, int, int, int]] = []
        self._due: list[Due] = []

    def clear(self) -> None:
        for due in self._due:
            due.cancel()
        self.shifting: int | None = None  # the word on the wire
        self.received, self.start = 0, 0
        self._due = []
        self.checked = False

    # -- settings, 28.5.1 --

    @property
    def bit_cycles(self) -> int:
        """Core cycles of one bit: PCLK / 2 to 256 (BR). SPI1 is on APB2."""
        bus = APB2_CYCLES if self.name == "SPI1" else APB1_CYCLES
        return bus << ((self.value["CR1"] >> 3 & 7) + 1)

    @property
    def hertz(self) -> float:
        return CORE_HZ / self.bit_cycles

    @property
    def mode(self) -> int:
        """Return the usual number of the mode: 2 CPOL + CPHA."""
        return 2 * bool(self.value["CR1"] & CPOL) + bool(self.value["CR1"] & CPHA)

    def write_CR1(self, old: int, new: int) -> None:
        if old & new & SPE and (old ^ new) & (DFF | CPOL | CPHA | RATE):
            self.complain("CR1", "DFF, CPOL, CPHA or BR changed while SPE is set (28.5.1)")
        if old & ~new & SPE and self.shifting is not None:
            self.complain("CR1", "SPE cleared while a frame is under way: wait for TXE, then for BSY to fall (28.3.8)")
            self.clear()
            self.value["SR"] = self.value["SR"] & RXNE | TXE
        if new & ~old & SPE:
            self.checked = False
            if not new & DFF or new & (MSTR | SSM | SSI) != MSTR | SSM | SSI:
                self.complain("CR1", "only a master of 16-bit words with SSM and SSI is modelled (28.3.10)")

    # -- transfers, 28.3.5, 28.3.7 --

    def write_DR(self, old: int, new: int) -> None:
        self.value["DR"] = old  # the two directions have buffers of their own
        if self.value["CR1"] & (SPE | MSTR) != SPE | MSTR:
            self.complain("DR", "written while SPE or MSTR is 0")
        elif self.shifting is not None:
            self.complain("DR", "written while a frame is under way: a word that waits is not modelled")
        else:
            self._shift(new)

    def _shift(self, word: int) -> None:
        self._check_pins()
        self.shifting, self.start = word, self.chip.now
        self.value["SR"] |= BSY
        end = self.start + BITS * self.bit_cycles
        # With CPHA the last bit is sampled at its second edge, half a bit before the end; without at its first.
        sampled = end - self.bit_cycles // 2 if self.value["CR1"] & CPHA else end - self.bit_cycles
        self._due = [self.chip.at(max(sampled, self.start), self._sampled), self.chip.at(end, self._ended)]
        for slave in self.slaves:
            slave.frame_begins(self)

    def _check_pins(self) -> None:
        if not self.checked:
            self.checked = True
            for wire in ("SCK", "MISO", "MOSI"):
                self.chip.pins.pin_of(f"{self.name}_{wire}", self.name)

    def _sampled(self) -> None:
        """The last bit is in: RXNE, or OVR if the last word has not been read (28.3.10)."""
        assert self.shifting is not None
        selected = [slave for slave in self.slaves if slave.selected]
        if len(selected) > 1:
            names = ", ".join(slave.name for slave in selected)
            self.complain("MISO", f"several slaves are selected: {names}")
        answers = [slave.exchange(self, self.shifting) for slave in selected]
        self.received = answers[0] if answers else 0xFFFF
        if not answers:
            self.chip.note(self.name, "frame with no slave selected")
        if self.value["SR"] & RXNE:
            self.value["SR"] |= OVR
            self.complain("DR", "overrun: the last word had not been read (28.3.10)")
        else:
            self.value["DR"] = self.received
            self.value["SR"] |= RXNE

    def _ended(self) -> None:
        assert self.shifting is not None
        self.frames.append((self.start, self.chip.now, self.shifting, self.received))
        self.chip.note(self.name, f"sent 0x{self.shifting:X}, received 0x{self.received:X}")
        self.shifting = None
        self.value["SR"] &= ~BSY

    def read_DR(self) -> int:
        self.value["SR"] &= ~RXNE
        return self.value["DR"]
