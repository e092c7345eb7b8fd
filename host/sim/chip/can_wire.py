"""The CAN bus outside the chip: frames, their length to the bit, arbitration with other nodes, disturbances."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...bus.can.load import bits_of, crc15
from .timeline import CORE_HZ

if TYPE_CHECKING:
    from .bxcan import BxCan

TAIL_BITS = 1 + 1 + 1 + 7  # CRC delimiter, acknowledge slot and delimiter, end of frame
PAUSE_BITS = 3
ERROR_BITS = 6 + 8  # error flag and delimiter, at least


@dataclass(frozen=True)
class Frame:
    """A classic CAN frame: identifier of 11 bits, or 29 if ``extended``; ``dlc`` counts for remote frames."""

    identifier: int
    data: bytes = b""
    extended: bool = False
    remote: bool = False
    dlc: int | None = None

    @property
    def length(self) -> int:
        return len(self.data) if self.dlc is None else self.dlc


def head(frame: Frame) -> list[int]:
    """Return the bits that take part in the arbitration: a lower list wins (ISO 11898-1; RTR, SRR and IDE included)."""
    if not frame.extended:
        return [*bits_of(frame.identifier, 11), int(frame.remote), 0]
    return [*bits_of(frame.identifier >> 18, 11), 1, 1, *bits_of(frame.identifier, 18), int(frame.remote)]


def stuffed(bits: list[int]) -> list[int]:
    """Put in the complement after every five equal bits."""
    out: list[int] = []
    for bit in bits:
        out.append(bit)
        if len(out) >= 5 and out[-5:] == [bit] * 5:
            out.append(1 - bit)
    return out


def frame_on_wire(frame: Frame) -> list[int]:
    """Return start, head, control, data and CRC with stuff bits."""
    bits = [0, *head(frame), *([0, 0] if frame.extended else [0]), *bits_of(frame.length, 4)]
    if not frame.remote:
        for byte in frame.data:
            bits += bits_of(byte, 8)
    return stuffed([*bits, *bits_of(crc15(bits), 15)])


def duration_bits(frame: Frame) -> int:
    """Return the bits of a frame on the wire, stuff bits included, the pause after it not."""
    return len(frame_on_wire(frame)) + TAIL_BITS


class CanWire:
    """A bus of ``rate_hz`` with the chip and other nodes on it.

    ``send`` queues frames of other nodes. ``sent`` holds (start, end, sender, frame) of what went through; sender is
    the chip's block or "wire". ``disturb`` counts frames to come that are hit by an error.
    """

    def __init__(self, can: BxCan) -> None:
        self.can, self.rate_hz = can, 1_000_000
        self.sent: list[tuple[int, int, str, Frame]] = []
        self.disturb = 0
        self.free_at = 0
        self._queue: list[Frame] = []
        self._listeners: list[Callable[[str, Frame], None]] = []
        self.busy = False

    @property
    def bit_cycles(self) -> float:
        return CORE_HZ / self.rate_hz

    def send(self, frame: Frame) -> None:
        """Have another node send a frame as soon as it wins the bus. Nodes' frames keep the order of arbitration."""
        self._queue.append(frame)
        self.can.chip.at(self.can.chip.now, self.offer)

    def on_frame(self, act: Callable[[str, Frame], None]) -> None:
        """Have ``act(sender, frame)`` called at the end of every frame."""
        self._listeners.append(act)

    def offer(self) -> None:
        """Start the frame that wins the bus, if the bus is free and there is one."""
        chip = self.can.chip
        if self.busy:
            return
        if chip.now < self.free_at:
            chip.at(self.free_at, self.offer)
            return
        mailbox = self.can.scheduled()
        own = None if mailbox is None else self.can.frame_in(mailbox)
        other = min(self._queue, key=head, default=None)
        if own is not None and (other is None or head(own) <= head(other)):
            self._begin(own, mailbox)
        elif other is not None:
            self._begin(other, None)

    def _begin(self, frame: Frame, mailbox: int | None) -> None:
        self.busy = True
        start = self.can.chip.now
        sender = "wire" if mailbox is None else self.can.name
        failed = self._fails()
        bits = duration_bits(frame) + (ERROR_BITS if failed else 0)
        end = start + round(bits * self.bit_cycles)
        self.free_at = end + round(PAUSE_BITS * self.bit_cycles)
        self.can.chip.at(end, lambda: self._end(start, sender, frame, mailbox, failed))

    def _fails(self) -> bool:
        """Tell whether something goes wrong with the frame that begins."""
        if self.disturb:
            self.disturb -= 1
            return True
        return not self.can.rate_matches(self.rate_hz)

    def _end(self, start: int, sender: str, frame: Frame, mailbox: int | None, failed: bool) -> None:
        self.busy = False
        if not failed:
            self.sent.append((start, self.can.chip.now, sender, frame))
            if mailbox is None:
                self._queue.remove(frame)
        self.can.frame_ended(frame, mailbox, failed)
        if not failed:
            for act in self._listeners:
                act(sender, frame)
        self.offer()
