"""SPI1 to SPI3 as masters: RM0090 section 28. No DMA, CRC, TI frames, I2S or slave mode."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from .registers import Peripheral, Register
from .timeline import CORE_HZ, Due

if TYPE_CHECKING:
    from .spi_slave import SpiSlave

CPHA, CPOL, MSTR, SPE, LSBFIRST, SSI, SSM, DFF = (1 << n for n in (0, 1, 2, 6, 7, 8, 9, 11))
UNMODELLED_CR1 = 0xF400 | LSBFIRST
SSOE, ERRIE, RXNEIE, TXEIE = (1 << n for n in (2, 5, 6, 7))
RXNE, TXE, MODF, OVR, BSY = (1 << n for n in (0, 1, 5, 6, 7))
INTERRUPT = {"SPI1": 35, "SPI2": 36, "SPI3": 51}


class Spi(Peripheral):
    """One SPI block. ``slaves`` are the chips on its wires; ``frames`` are (start, end, sent, received)."""

    registers: ClassVar = (
        Register("CR1", 0x00, 0, 0xFFFF),
        Register("CR2", 0x04, 0, 0xF7),
        Register("SR", 0x08, 2, 0, clear=0x10),
        Register("DR", 0x0C, 0, 0xFFFF),
        Register("CRCPR", 0x10, 7, 0xFFFF),
        Register("RXCRCR", 0x14, 0, 0),
        Register("TXCRCR", 0x18, 0, 0),
        Register("I2SCFGR", 0x1C, 0, 0xFBF),
        Register("I2SPR", 0x20, 2, 0x3FF),
    )

    def power_up(self) -> None:
        self.slaves: list[SpiSlave] = []
        self.frames: list[tuple[int, int, int, int]] = []
        self._due: list[Due] = []
        self._idle()

    def _idle(self) -> None:
        self.waiting: int | None = None  # the word in the transmit buffer
        self.shifting: int | None = None  # the word on the wire
        self.received, self.start = 0, 0
        self._due = []
        self.ovr_step = 0
        self.checked = False

    def reset(self) -> None:
        self._abort()
        super().reset()
        self._interrupt()

    def _abort(self) -> None:
        for due in self._due:
            due.cancel()
        self._idle()

    # -- settings, 28.5.1 --

    @property
    def bits(self) -> int:
        return 16 if self.value["CR1"] & DFF else 8

    @property
    def bit_cycles(self) -> int:
        """Core cycles of one bit: PCLK / 2 to 256 (BR). SPI1 is on APB2."""
        rcc = self.chip.rcc
        bus = rcc.apb2_divider if self.name == "SPI1" else rcc.apb1_divider
        return bus << ((self.value["CR1"] >> 3 & 7) + 1)

    @property
    def hertz(self) -> float:
        return CORE_HZ / self.bit_cycles

    @property
    def mode(self) -> int:
        """Return the usual number of the mode: 2 CPOL + CPHA."""
        return 2 * bool(self.value["CR1"] & CPOL) + bool(self.value["CR1"] & CPHA)

    def write_CR1(self, old: int, new: int) -> None:
        self.value["SR"] &= ~MODF
        changed = old ^ new
        if new & UNMODELLED_CR1:
            self.complain("CR1", "CRC, one-wire, receive-only and LSB-first modes are not modelled")
        if old & new & SPE and changed & (DFF | CPOL | CPHA | 0x38):
            self.complain("CR1", "DFF, CPOL, CPHA or BR changed while SPE is set (28.5.1)")
        if old & ~new & SPE and self.shifting is not None:
            self.complain("CR1", "SPE cleared while a frame is under way: wait for TXE, then for BSY to fall (28.3.8)")
            self._abort()
            self.value["SR"] = self.value["SR"] & RXNE | TXE
        if new & ~old & SPE:
            self.checked = False
            self._check_master()

    def _check_master(self) -> None:
        """28.3.10: a master whose NSS is low falls back to being a slave."""
        word = self.value["CR1"]
        if not word & MSTR:
            self.complain("CR1", "slave mode is not modelled")
        elif self._nss_low():
            self.value["SR"] |= MODF
            self.value["CR1"] &= ~(MSTR | SPE)
            self.complain("CR1", "NSS is low (SSM without SSI, or the pin): mode fault (28.3.10)")

    def _nss_low(self) -> bool:
        word = self.value["CR1"]
        if word & SSM:
            return not word & SSI
        return not self.value["CR2"] & SSOE and self.chip.pins.input_level(f"{self.name}_NSS") == 0

    def write_CR2(self, _old: int, new: int) -> None:
        if new & 3:
            self.complain("CR2", "DMA is not modelled")
        self._interrupt()

    # -- transfers, 28.3.5, 28.3.7 --

    def write_DR(self, old: int, new: int) -> None:
        self.value["DR"] = old  # the two directions have buffers of their own
        if self.value["CR1"] & (SPE | MSTR) != SPE | MSTR:
            self.complain("DR", "written while SPE or MSTR is 0")
            return
        if self.waiting is not None:
            self.complain("DR", "written while TXE is 0: the word that waited is lost (28.3.7)")
        self.waiting = new & ((1 << self.bits) - 1)
        self.value["SR"] &= ~TXE
        if self.shifting is None:
            self._shift()
        self._interrupt()

    def _shift(self) -> None:
        """The word goes to the shift register and TXE comes back."""
        self._check_pins()
        self.shifting, self.waiting, self.start = self.waiting, None, self.chip.now
        self.value["SR"] |= TXE | BSY
        end = self.start + self.bits * self.bit_cycles
        # With CPHA the last bit is sampled at its second edge, half a bit before the end; without at its first.
        sampled = end - self.bit_cycles // 2 if self.value["CR1"] & CPHA else end - self.bit_cycles
        self._due = [self.chip.at(max(sampled, self.start), self._sampled), self.chip.at(end, self._ended)]
        for slave in self.slaves:
            slave.frame_begins(self)

    def _check_pins(self) -> None:
        if not self.checked:
            self.checked = True
            self.chip.need_full_speed(self.name)
            for wire in ("SCK", "MISO", "MOSI"):
                self.chip.pins.pin_of(f"{self.name}_{wire}", self.name)

    def _sampled(self) -> None:
        """The last bit is in: RXNE, or OVR if the last word has not been read (28.3.10)."""
        assert self.shifting is not None
        selected = [slave for slave in self.slaves if slave.selected]
        if len(selected) > 1:
            names = ", ".join(slave.name for slave in selected)
            self.complain("MISO", f"several slaves are selected: {names}")
        answers = [slave.exchange(self, self.shifting, self.bits) for slave in selected]
        self.received = answers[0] if answers else (1 << self.bits) - 1
        if not answers:
            self.chip.note(self.name, "frame with no slave selected")
        if self.value["SR"] & RXNE:
            self.value["SR"] |= OVR
            self.complain("DR", "overrun: the last word had not been read (28.3.10)")
        else:
            self.value["DR"] = self.received
            self.value["SR"] |= RXNE
        self._interrupt()

    def _ended(self) -> None:
        assert self.shifting is not None
        self.frames.append((self.start, self.chip.now, self.shifting, self.received))
        self.chip.note(self.name, f"sent 0x{self.shifting:X}, received 0x{self.received:X}")
        self.shifting = None
        if self.waiting is not None:
            self._shift()
        else:
            self.value["SR"] &= ~BSY
        self._interrupt()

    # -- reading --

    def read_DR(self) -> int:
        self.value["SR"] &= ~RXNE
        self.ovr_step = 1 if self.value["SR"] & OVR else 0
        self._interrupt()
        return self.value["DR"]

    def read_SR(self) -> int:
        """OVR goes by reading DR, then SR; MODF by reading SR, then writing CR1 (28.3.10)."""
        word = self.value["SR"]
        if self.ovr_step:
            self.value["SR"] &= ~OVR
            self.ovr_step = 0
            self._interrupt()
        return word

    def _interrupt(self) -> None:
        flags, enables = self.value["SR"], self.value["CR2"]
        active = (
            (flags & RXNE and enables & RXNEIE)
            or (flags & TXE and enables & TXEIE)
            or (flags & (OVR | MODF) and enables & ERRIE)
        )
        self.chip.nvic.line(INTERRUPT[self.name], self.name, bool(active))
