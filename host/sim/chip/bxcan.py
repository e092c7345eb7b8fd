"""CAN1: RM0090 section 32 (bxCAN), polled: frames out by mailboxes, frames in through masks of 16 bits and two FIFOs.

Left out: interrupts, aborting, single shots, loop-back and silent modes, order by request, locked FIFOs.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

from .can_wire import CanWire, Frame, head
from .rcc import APB1_CYCLES
from .registers import ALL, Peripheral, Register
from .timeline import CORE_HZ

INRQ, SLEEP, ABOM = 1, 2, 1 << 6
INAK, SLAK = 1, 2
FULL, FOVR, RFOM = 8, 16, 32
TXRQ = 1
STANDARD = 0x7FF << 21  # of TIxR
EWGF, EPVF, BOFF = 1, 2, 4
BOXES = range(3)
BANKS = 14  # CAN1's own (FMR, CAN2SB)
RATE_TOLERANCE = 0.005


def half_of(frame: Frame) -> int:
    """Return a frame's identifier as a 16-bit filter sees it: STID, RTR, IDE, EXID[17:15] (32.7.4, figure 342)."""
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


class BxCan(Peripheral):
    """One controller, on ``wire``. ``received`` holds (cycle, FIFO, frame) of what the filters let in."""

    read_sizes: ClassVar = (4,)
    write_sizes: ClassVar = (4,)
    registers: ClassVar = (
        Register("MCR", 0x00, SLEEP, INRQ | SLEEP | ABOM),
        Register("MSR", 0x04, 0x0000_0C00, 0),
        Register("TSR", 0x08, 0, 0),
        Register("RF0R", 0x0C, 0, RFOM | FOVR | FULL, back=3),
        Register("RF1R", 0x10, 0, RFOM | FOVR | FULL, back=3),
        Register("ESR", 0x18, 0, 0),
        Register("BTR", 0x1C, 0x0123_0000, 0x037F_03FF),
        *(Register(f"{name}{box}R", 0x180 + 16 * box + 4 * n, 0, mask) for box in BOXES
          for n, (name, mask) in enumerate((("TI", STANDARD | TXRQ), ("TDT", 15), ("TDL", ALL), ("TDH", ALL)))),
        *(Register(f"{name}{fifo}R", 0x1B0 + 16 * fifo + 4 * n, 0, 0) for fifo in range(2)
          for n, name in enumerate(("RI", "RDT", "RDL", "RDH"))),
        Register("FMR", 0x200, 0x2A1C_0E01, 1),
        Register("FM1R", 0x204, 0, 0),
        Register("FS1R", 0x20C, 0, 0),
        Register("FFA1R", 0x214, 0, (1 << BANKS) - 1),
        Register("FA1R", 0x21C, 0, (1 << BANKS) - 1),
        *(Register(f"F{bank}R{n + 1}", 0x240 + 8 * bank + 4 * n) for bank in range(BANKS) for n in range(2)),
    )  # fmt: skip

    def power_up(self) -> None:
        self.wire = CanWire(self)
        self.received: list[tuple[int, int, Frame]] = []
        for box in BOXES:
            self.on_write(f"TI{box}R", partial(self._requested, box))
        for fifo in range(2):
            self.on_write(f"RF{fifo}R", partial(self._write_fifo, fifo))
        self.epoch = 0

    def clear(self) -> None:
        self.pending: list[int] = []  # mailboxes with a frame to send
        self.fifo: list[list[Frame]] = [[], []]
        self.tec, self.rec, self.bus_off = 0, 0, False
        self.mode = "sleep"
        self.epoch += 1  # changes of mode under way belong to one epoch
        self.checked_pins = False

    # -- bit timing, 32.7.7 --

    @property
    def quanta(self) -> int:
        """Time quanta of one bit: SYNC_SEG + BS1 + BS2."""
        word = self.value["BTR"]
        return 3 + (word >> 16 & 15) + (word >> 20 & 7)

    @property
    def bit_rate_hz(self) -> float:
        return CORE_HZ / APB1_CYCLES / ((self.value["BTR"] & 0x3FF) + 1) / self.quanta

    def rate_matches(self, rate_hz: float) -> bool:
        if abs(self.bit_rate_hz / rate_hz - 1) <= RATE_TOLERANCE or self.mode != "normal":
            return True
        self.complain("BTR", f"{self.bit_rate_hz:.0f} bit/s on a bus of {rate_hz}")
        return False

    def write_BTR(self, old: int, new: int) -> None:
        if self.mode != "initialization":
            self.refuse("BTR", old, "written outside initialization mode (32.9.2)")
        elif (new >> 24 & 3) > (new >> 20 & 7):
            self.complain("BTR", "SJW is longer than BS2, which CAN does not allow (ISO 11898-1)")

    # -- modes, 32.4, 32.5 --

    @property
    def takes_part(self) -> bool:
        """Tell whether the chip sends and hears."""
        return self.mode == "normal" and not self.bus_off

    def write_MCR(self, _old: int, new: int) -> None:
        if new & INRQ and not new & SLEEP:
            self._go("initialization", 0)
        elif new & SLEEP and not new & INRQ:
            self._go("sleep", 0)
        elif not new & SLEEP:
            self._leave()

    def _go(self, mode: str, cycles: int) -> None:
        """Change the mode when the frame under way is over, and after ``cycles``."""
        if self.mode == mode:
            return
        self.epoch += 1
        epoch = self.epoch

        def arrive() -> None:
            if epoch != self.epoch:
                return
            if self.wire.busy:
                self.chip.at(max(self.wire.free_at, self.chip.now + 1), arrive)
            else:
                self.mode = mode
                self.chip.note(self.name, mode)
                self.wire.offer()

        self.chip.at(self.chip.now + max(cycles, APB1_CYCLES), arrive)

    def _leave(self) -> None:
        """Initialization ends when 11 recessive bits in a row have been seen (32.4.1, 32.4.2)."""
        if not self.checked_pins:
            self.checked_pins = True
            self.chip.pins.pin_of("CAN1_RX", self.name)
            self.chip.pins.pin_of("CAN1_TX", self.name)
        self._go("normal", round(11 * CORE_HZ / self.bit_rate_hz))

    def read_MSR(self) -> int:
        return self.value["MSR"] | INAK * (self.mode == "initialization") | SLAK * (self.mode == "sleep")

    # -- transmission, 32.7.1 --

    def write(self, offset: int, value: int, size: int) -> None:
        """A mailbox that is not empty cannot be written, nor an active filter."""
        if 0x180 <= offset < 0x1B0 and (offset - 0x180) // 16 in self.pending:
            self.complain(self.by_offset[offset & ~3].name, "written while the mailbox is not empty (32.7.1)")
        elif 0x204 <= offset < 0x21C and not self.value["FMR"] & 1:
            self.complain(self.by_offset[offset & ~3].name, "written while FINIT is 0 (32.9.4)")
        elif 0x240 <= offset < 0x240 + 8 * BANKS and self._filter_in_use((offset - 0x240) // 8):
            self.complain(self.by_offset[offset & ~3].name, "written while its bank is active and FINIT is 0 (32.9.4)")
        else:
            super().write(offset, value, size)

    def _filter_in_use(self, bank: int) -> bool:
        return not self.value["FMR"] & 1 and bool(self.value["FA1R"] >> bank & 1)

    def _requested(self, box: int, _old: int, new: int) -> None:
        if new & TXRQ:
            self.pending.append(box)
            if self.mode == "normal":
                self.wire.offer()

    def frame_in(self, box: int) -> Frame:
        """Return the frame of a transmit mailbox."""
        length = min(self.value[f"TDT{box}R"], 8)
        data = (self.value[f"TDL{box}R"] | self.value[f"TDH{box}R"] << 32).to_bytes(8, "little")[:length]
        return Frame(self.value[f"TI{box}R"] >> 21, data)

    def scheduled(self) -> int | None:
        """Return the mailbox that goes next, by identifier and number (32.7.1); None if nothing may be sent."""
        if not self.takes_part or not self.pending:
            return None
        return min(self.pending, key=lambda box: (head(self.frame_in(box)), box))

    def read_TSR(self) -> int:
        """TME0 to TME2: the mailboxes that are empty."""
        return sum(1 << 26 + box for box in BOXES if box not in self.pending)

    # -- what happens on the wire --

    def frame_ended(self, frame: Frame, box: int | None, failed: bool) -> None:
        """A frame of the chip (``box``) or of another node is over."""
        if box is None:
            self._heard(frame, failed)
        elif box in self.pending:
            self._sent(box, failed)

    def _sent(self, box: int, failed: bool) -> None:
        if not failed:
            self.tec = max(self.tec - 1, 0)
            self.pending.remove(box)
            self.value[f"TI{box}R"] &= ~TXRQ
            return
        self.tec += 8
        if self.tec > 255:
            self._go_bus_off()

    def _heard(self, frame: Frame, failed: bool) -> None:
        if not self.takes_part:
            return
        if failed:
            self.rec = min(self.rec + 1, 255)
        else:
            self.rec = 120 if self.rec > 127 else max(self.rec - 1, 0)
            self._store(frame)

    def read_ESR(self) -> int:
        worst = max(self.tec, self.rec)
        flags = EWGF * (worst >= 96) | EPVF * (worst > 127) | BOFF * self.bus_off
        return flags | min(self.tec, 255) << 16 | min(self.rec, 255) << 24

    def _go_bus_off(self) -> None:
        """Recovery (32.7.6): with ABOM by itself, after 128 times 11 recessive bits; without it never, here."""
        self.bus_off = True
        self.chip.note(self.name, "bus off")
        if not self.value["MCR"] & ABOM:
            return
        self.epoch += 1
        epoch = self.epoch

        def back() -> None:
            if epoch == self.epoch:
                self.bus_off, self.tec, self.rec = False, 0, 0
                self.chip.note(self.name, "back on the bus")
                self.wire.offer()

        self.chip.at(self.chip.now + round(128 * 11 * CORE_HZ / self.bit_rate_hz), back)

    # -- reception, 32.7.3 and 32.7.4 --

    def banks(self) -> list[Bank]:
        """Return the filter banks that are active."""
        value = self.value
        return [Bank(value["FFA1R"] >> n & 1, (value[f"F{n}R1"], value[f"F{n}R2"]))
                for n in range(BANKS) if value["FA1R"] >> n & 1]  # fmt: skip

    def _store(self, frame: Frame) -> None:
        """While FINIT is 1 nothing is received. A full FIFO loses its last message."""
        number = None if self.value["FMR"] & 1 else accept(self.banks(), frame)
        if number is None:
            return
        fifo, flags = self.fifo[number], f"RF{number}R"
        self.received.append((self.chip.now, number, frame))
        if len(fifo) == 3:
            self.value[flags] |= FOVR
            self.chip.note(self.name, f"overrun of FIFO {number}")
            fifo.pop()
        fifo.append(frame)
        if len(fifo) == 3:
            self.value[flags] |= FULL
        self._show(number)

    def _show(self, number: int) -> None:
        """Put the oldest message into the output mailbox."""
        if not self.fifo[number]:
            return
        frame = self.fifo[number][0]
        word = frame.identifier << 3 | 4 if frame.extended else frame.identifier << 21
        data = int.from_bytes(frame.data.ljust(8, b"\0"), "little")
        self.value[f"RI{number}R"] = word | frame.remote << 1
        self.value[f"RDT{number}R"] = frame.length
        self.value[f"RDL{number}R"] = data & 0xFFFF_FFFF
        self.value[f"RDH{number}R"] = data >> 32

    def _write_fifo(self, number: int, old: int, new: int) -> None:
        self.value[f"RF{number}R"] = old & ~new & (FULL | FOVR)
        if new & RFOM:
            if self.fifo[number]:
                self.fifo[number].pop(0)
                self._show(number)
            else:
                self.complain(f"RF{number}R", "RFOM while the FIFO is empty")

    def read_RF0R(self) -> int:
        return self.value["RF0R"] | len(self.fifo[0])

    def read_RF1R(self) -> int:
        return self.value["RF1R"] | len(self.fifo[1])
