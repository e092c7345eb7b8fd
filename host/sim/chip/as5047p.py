"""The AS5047P magnetic position sensor, after its data sheet (ams, v1-xx: SPI interface, figures 9 to 20)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from .spi_slave import SpiSlave

if TYPE_CHECKING:
    from .chip import Chip

NOP, ERRFL, PROG, DIAAGC, MAG, ANGLEUNC, ANGLECOM = 0, 1, 3, 0x3FFC, 0x3FFD, 0x3FFE, 0x3FFF
ZPOSM, ZPOSL, SETTINGS1, SETTINGS2 = 0x16, 0x17, 0x18, 0x19
WRITABLE = {PROG: 0x4D, ZPOSM: 0xFF, ZPOSL: 0xFF, SETTINGS1: 0xFF, SETTINGS2: 0xFF}
FRERR, INVCOMM, PARERR = 1, 2, 4
READ, ERROR = 1 << 14, 1 << 14
LOOP_FINISHED = 1 << 8


def with_parity(word: int) -> int:
    """Return a word of 15 bits with bit 15 making the number of ones even."""
    return word & 0x7FFF | (word & 0x7FFF).bit_count() % 2 << 15


class As5047p(SpiSlave):
    """A sensor whose angle, 0 to 16383, is ``angle(cycle)``.

    A command is carried out when the chip is deselected, and answered in the next word. A bad command sets a bit in
    ERRFL; every answer then has the error flag until ERRFL has been read.
    """

    max_hz = 10_000_000
    select_to_clock_ns = 350.0  # t_L
    deselected_ns = 350.0  # t_CSn

    def __init__(self, chip: Chip, spi: str, select_pin: str, angle: Callable[[int], float], name: str = "AS5047P"):
        super().__init__(chip, spi, select_pin)
        self.name, self.angle = name, angle
        self.registers = {PROG: 0, ZPOSM: 0, ZPOSL: 0, SETTINGS1: 1, SETTINGS2: 0}
        self.agc, self.diagnostics, self.magnitude = 0x80, LOOP_FINISHED, 0x0F00
        self.errors = 0
        self.next_data = 0
        self.writing: int | None = None  # the register that the next word goes to

    def clock_to_deselect_ns(self) -> float:
        """t_H: half a clock, which is there when one waits for BSY."""
        return 0.5e9 / self.bus.hertz

    def answer(self) -> int:
        return with_parity(self.next_data & 0x3FFF | ERROR * bool(self.errors))

    def wrong_length(self, bits: int) -> None:
        """Not 16 clocks: a framing error."""
        self.errors |= FRERR
        self.next_data, self.writing = 0, None

    def take(self, word: int) -> None:
        if word.bit_count() % 2:
            self._reject(PARERR)
        elif self.writing is not None:
            self._write(word & 0x3FFF)
        else:
            self._command(word & 0x3FFF, bool(word & READ))

    def _reject(self, error: int) -> None:
        self.errors |= error
        self.next_data, self.writing = 0, None

    def _write(self, data: int) -> None:
        """The word after a write command; the next answer shows what the register now holds."""
        assert self.writing is not None
        self.registers[self.writing] = data & WRITABLE[self.writing]
        self.next_data, self.writing = self.registers[self.writing], None

    def _command(self, address: int, reading: bool) -> None:
        if address == NOP:
            self.next_data = 0
        elif reading:
            self._read(address)
        elif address in WRITABLE:
            self.next_data, self.writing = self.registers[address], address
        else:
            self._reject(INVCOMM)

    def _read(self, address: int) -> None:
        if address in (ANGLECOM, ANGLEUNC):
            self.next_data = self._angle()
        elif address == ERRFL:
            self.next_data, self.errors = self.errors, 0
        elif address == DIAAGC:
            self.next_data = self.diagnostics | self.agc
        elif address == MAG:
            self.next_data = self.magnitude
        elif address in self.registers:
            self.next_data = self.registers[address]
        else:
            self._reject(INVCOMM)

    def _angle(self) -> int:
        """The angle when the command is carried out, less the zero position, turned round by DIR."""
        zero = self.registers[ZPOSM] << 6 | self.registers[ZPOSL] & 0x3F
        angle = round(self.angle(self.chip.now)) - zero
        return (-angle if self.registers[SETTINGS1] & 4 else angle) & 0x3FFF
