"""The acceptance filters of bxCAN: RM0090 section 32.7.4."""

from __future__ import annotations

from dataclasses import dataclass

from .can_wire import Frame


def word_of(frame: Frame) -> int:
    """Return a frame's identifier as a 32-bit filter sees it: STID, EXID, IDE, RTR, 0 (figure 342)."""
    if frame.extended:
        return frame.identifier << 3 | 1 << 2 | frame.remote << 1
    return frame.identifier << 21 | frame.remote << 1


def half_of(frame: Frame) -> int:
    """Return it as a 16-bit filter sees it: STID, RTR, IDE, EXID[17:15] (figure 342)."""
    if frame.extended:
        return frame.identifier >> 18 << 5 | frame.remote << 4 | 1 << 3 | frame.identifier >> 15 & 7
    return frame.identifier << 5 | frame.remote << 4


@dataclass(frozen=True)
class Bank:
    """One filter bank: FSCx (wide: 32 bits), FBMx (a list, not masks), FFAx, FACTx and its two registers."""

    wide: bool
    listed: bool
    fifo: int
    active: bool
    words: tuple[int, int]

    @property
    def filters(self) -> int:
        """How many numbers the bank takes up, active or not."""
        return (1 if self.wide else 2) * (2 if self.listed else 1)

    def match(self, frame: Frame) -> int | None:
        """Return which filter of the bank takes a frame, None if none does."""
        if self.wide:
            seen, parts = word_of(frame), list(self.words)
        else:
            seen, parts = half_of(frame), [self.words[n // 2] >> 16 * (n % 2) & 0xFFFF for n in range(4)]
        if self.listed:
            return parts.index(seen) if seen in parts else None
        for n in range(0, len(parts), 2):
            identifier, mask = parts[n], parts[n + 1]
            if (seen ^ identifier) & mask == 0:
                return n // 2
        return None


def accept(banks: list[Bank], frame: Frame) -> tuple[int, int] | None:
    """Return the FIFO and the filter match index of a frame: wide before narrow, lists before masks, low numbers first.

    Filters are numbered per FIFO, those of inactive banks too.
    """
    next_number, best = [0, 0], None
    for bank in banks:
        found = bank.match(frame) if bank.active else None
        if found is not None:
            number = next_number[bank.fifo] + found
            rank = (not bank.wide, not bank.listed, number)
            if best is None or rank < best[0]:
                best = (rank, bank.fifo, number)
        next_number[bank.fifo] += bank.filters
    return None if best is None else best[1:]
