"""The acceptance filters of bxCAN that are modelled: masks of 16 bits (RM0090 section 32.7.4)."""

from __future__ import annotations

from dataclasses import dataclass

from .can_wire import Frame


def half_of(frame: Frame) -> int:
    """Return a frame's identifier as a 16-bit filter sees it: STID, RTR, IDE, EXID[17:15] (figure 342)."""
    if frame.extended:
        return frame.identifier >> 18 << 5 | frame.remote << 4 | 1 << 3 | frame.identifier >> 15 & 7
    return frame.identifier << 5 | frame.remote << 4


@dataclass(frozen=True)
class Bank:
    """One active filter bank: FFAx and its two registers, each a mask above an identifier."""

    fifo: int
    words: tuple[int, int]

    def takes(self, frame: Frame) -> bool:
        """Tell whether one of the two filters takes a frame."""
        return any((half_of(frame) ^ word) & word >> 16 == 0 for word in self.words)


def accept(banks: list[Bank], frame: Frame) -> int | None:
    """Return the FIFO that a frame goes to, of the first bank that takes it; None if none does."""
    return next((bank.fifo for bank in banks if bank.takes(frame)), None)
