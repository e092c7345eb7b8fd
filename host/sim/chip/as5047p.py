"""The AS5047P magnetic position sensor, after its data sheet (ams, v1-xx: SPI interface, figures 9 to 20).

It tells its angle and its errors; settings and diagnostics are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from .spi_slave import SpiSlave

if TYPE_CHECKING:
    from .chip import Chip

NOP, ERRFL, ANGLECOM = 0, 1, 0x3FFF
FRERR, INVCOMM, PARERR = 1, 2, 4
READ, ERROR = 1 << 14, 1 << 14


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
        self.errors = 0
        self.next_data = 0

    def clock_to_deselect_ns(self) -> float:
        """t_H: half a clock, which is there when one waits for BSY."""
        return 0.5e9 / self.bus.hertz

    def answer(self) -> int:
        return with_parity(self.next_data & 0x3FFF | ERROR * bool(self.errors))

    def wrong_length(self) -> None:
        """Not 16 clocks: a framing error."""
        self._reject(FRERR)

    def _reject(self, error: int) -> None:
        self.errors |= error
        self.next_data = 0

    def take(self, word: int) -> None:
        address = word & 0x3FFF
        if word.bit_count() % 2:
            self._reject(PARERR)
        elif address == ERRFL and word & READ:
            self.next_data, self.errors = self.errors, 0
        elif address == ANGLECOM and word & READ:
            self.next_data = round(self.angle(self.chip.now)) & 0x3FFF
        elif address == NOP:
            self.next_data = 0
        else:
            self._reject(INVCOMM)
