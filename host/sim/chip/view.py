"""A peripheral as an array of registers, as driver code on a pointer sees it; every access takes its time."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .chip import Chip


class View:
    """``view[0x34 >> 2] = value``: an array of 32-, 16- or 8-bit registers from an address on."""

    def __init__(self, chip: Chip, base: int, size: int, cost_cycles: int) -> None:
        self.chip, self.base, self.size, self.cost_cycles = chip, base, size, cost_cycles

    def __getitem__(self, index: int) -> int:
        self.chip.advance(self.cost_cycles)
        return self.chip.read(self.base + index * self.size, self.size)

    def __setitem__(self, index: int, value: int) -> None:
        self.chip.advance(self.cost_cycles)
        self.chip.write(self.base + index * self.size, value, self.size)
