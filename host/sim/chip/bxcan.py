"""CAN1: RM0090 section 32 (bxCAN). Time-triggered communication and CAN2 are left out."""

from __future__ import annotations

from typing import ClassVar

from .can_filter import Bank, accept
from .can_wire import CanWire, Frame, head
from .registers import Peripheral, Register
from .timeline import CORE_HZ

INRQ, SLEEP, TXFP, RFLM, NART, ABOM, RESET = (1 << n for n in (0, 1, 2, 3, 4, 6, 15))
INAK, SLAK, ERRI, WKUI, SLAKI = (1 << n for n in range(5))
RQCP, TXOK, ALST, TERR, ABRQ = (1 << n for n in (0, 1, 2, 3, 7))
FULL, FOVR, RFOM = 8, 16, 32
TXRQ = 1
EWGF, EPVF, BOFF = 1, 2, 4
ACK_ERROR, BIT_RECESSIVE_ERROR, STUFF_ERROR = 3, 4, 1  # 32.9.2 LEC
TX_IRQ, RX0_IRQ, RX1_IRQ, SCE_IRQ = 19, 20, 21, 22
LBKM, SILM = 1 << 30, 1 << 31
BANKS = 28
CAN1_BANKS_FIELD = 8  # CAN2SB in FMR
RATE_TOLERANCE = 0.005


class BxCan(Peripheral):
    """One controller, on ``wire``. ``received`` holds (cycle, FIFO, frame) of what the filters let in."""

    read_sizes: ClassVar = (4,)
    write_sizes: ClassVar = (4,)
    registers: ClassVar = (
        Register("MCR", 0x00, 0x0001_0002, 0x0001_80FF),
        Register("MSR", 0x04, 0x0000_0C02, 0x1C, back=0x0F03),
        Register("TSR", 0x08, 0x1C00_0000, 0x008F_8F8F, back=0xFF00_0000),
        Register("RF0R", 0x0C, 0, 0x38, back=3),
        Register("RF1R", 0x10, 0, 0x38, back=3),
        Register("IER", 0x14, 0, 0x0003_8F7F),
        Register("ESR", 0x18, 0, 0x70, back=0xFFFF_0007),
        Register("BTR", 0x1C, 0x0123_0000, 0xC37F_03FF),
        *(
            Register(f"{name}{box}R", 0x180 + 16 * box + 4 * n, 0, mask)
            for box in range(3)
            for n, (name, mask) in enumerate(
                (("TI", 0xFFFF_FFFF), ("TDT", 0xFFFF_010F), ("TDL", 0xFFFF_FFFF), ("TDH", 0xFFFF_FFFF))
            )
        ),
        *(
            Register(f"{name}{fifo}R", 0x1B0 + 16 * fifo + 4 * n, 0, 0)
            for fifo in range(2)
            for n, name in enumerate(("RI", "RDT", "RDL", "RDH"))
        ),
        Register("FMR", 0x200, 0x2A1C_0E01, 0x3F01),
        Register("FM1R", 0x204, 0, 0x0FFF_FFFF),
        Register("FS1R", 0x20C, 0, 0x0FFF_FFFF),
        Register("FFA1R", 0x214, 0, 0x0FFF_FFFF),
        Register("FA1R", 0x21C, 0, 0x0FFF_FFFF),
        *(Register(f"F{bank}R{n + 1}", 0x240 + 8 * bank + 4 * n) for bank in range(BANKS) for n in range(2)),
    )

    def power_up(self) -> None:
        self.wire = CanWire(self)
        self.received: list[tuple[int, int, Frame]] = []
        self._start_values()

    def _start_values(self) -> None:
        self.pending: list[int] = []  # mailboxes in the order of their requests
        self.aborting: set[int] = set()
        self.sending: int | None = None
        self.fifo: list[list[tuple[Frame, int]]] = [[], []]
        self.tec, self.rec, self.bus_off, self.lec = 0, 0, False, 0
        self.mode = "sleep"
        self.epoch = getattr(self, "epoch", 0) + 1  # changes of mode under way belong to one epoch
        self.checked_pins = False

    def reset(self) -> None:
        super().reset()
        self._start_values()
        for number in (TX_IRQ, RX0_IRQ, RX1_IRQ, SCE_IRQ):
            self.chip.nvic.line(number, self.name, False)

    # -- bit timing, 32.7.7 --

    @property
    def quanta(self) -> int:
        """Time quanta of one bit: SYNC_SEG + BS1 + BS2."""
        word = self.value["BTR"]
        return 3 + (word >> 16 & 15) + (word >> 20 & 7)

    @property
    def bit_rate_hz(self) -> float:
        return CORE_HZ / self.chip.rcc.apb1_divider / ((self.value["BTR"] & 0x3FF) + 1) / self.quanta

    @property
    def sample_point(self) -> float:
        """Return where in a bit it is sampled, 0 to 1."""
        return (2 + (self.value["BTR"] >> 16 & 15)) / self.quanta

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
    def loops_back(self) -> bool:
        return bool(self.value["BTR"] & LBKM)

    @property
    def acknowledges(self) -> bool:
        """Tell whether the chip acknowledges what others send: normal mode, not silent, not looped back."""
        return self.mode == "normal" and not self.value["BTR"] & (LBKM | SILM) and not self.bus_off

    def write_MCR(self, _old: int, new: int) -> None:
        if new & RESET:
            self.reset()
            return
        if new & 1 << 7:
            self.complain("MCR", "time-triggered communication is not modelled")
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
                self._arrived(mode)

        self.chip.at(self.chip.now + max(cycles, self.chip.rcc.apb1_divider), arrive)

    def _arrived(self, mode: str) -> None:
        self.mode = mode
        self.chip.note(self.name, mode)
        if mode == "sleep":
            self.value["MSR"] |= SLAKI
        if mode == "normal" and self.bus_off and not self.value["MCR"] & ABOM:
            self._recover()
        self._interrupt()
        self.wire.offer()

    def _leave(self) -> None:
        """Initialization ends when 11 recessive bits in a row have been seen (32.4.1, 32.4.2)."""
        self._check_pins()
        if self.wire.stuck and not self.loops_back:
            self.complain("MCR", "the bus is not recessive: initialization mode is not left (32.4.2)")
            return
        self._go("normal", round(11 * CORE_HZ / self.bit_rate_hz))

    def _check_pins(self) -> None:
        if not self.checked_pins and not self.loops_back:
            self.checked_pins = True
            self.chip.pins.pin_of("CAN1_RX", self.name)
            self.chip.pins.pin_of("CAN1_TX", self.name)

    def read_MSR(self) -> int:
        word = self.value["MSR"] & ~(INAK | SLAK)
        return word | INAK * (self.mode == "initialization") | SLAK * (self.mode == "sleep")

    def write_MSR(self, old: int, new: int) -> None:
        """ERRI, WKUI and SLAKI are cleared by writing 1."""
        self.value["MSR"] = old & ~(new & (ERRI | WKUI | SLAKI))
        self._interrupt()

    # -- transmission, 32.7.1 --

    def write(self, offset: int, value: int, size: int) -> None:
        """A mailbox that is not empty cannot be written, nor an active filter."""
        if 0x180 <= offset < 0x1B0 and (offset - 0x180) // 16 in self.pending:
            self.complain(self.by_offset[offset & ~3].name, "written while the mailbox is not empty (32.7.1)")
        elif 0x204 <= offset < 0x21C and not self.value["FMR"] & 1:
            self.complain(self.by_offset[offset & ~3].name, "written while FINIT is 0 (32.9.4)")
        elif 0x240 <= offset < 0x320 and self._filter_in_use((offset - 0x240) // 8):
            self.complain(self.by_offset[offset & ~3].name, "written while its bank is active and FINIT is 0 (32.9.4)")
        else:
            super().write(offset, value, size)

    def _filter_in_use(self, bank: int) -> bool:
        return not self.value["FMR"] & 1 and bool(self.value["FA1R"] >> bank & 1)

    def _requested(self, box: int, new: int) -> None:
        if new & TXRQ:
            self.pending.append(box)
            self.value["TSR"] &= ~((RQCP | TXOK | ALST | TERR) << 8 * box)
            self._interrupt()
            if self.mode == "normal":
                self.wire.offer()

    def write_TI0R(self, _old: int, new: int) -> None:
        self._requested(0, new)

    def write_TI1R(self, _old: int, new: int) -> None:
        self._requested(1, new)

    def write_TI2R(self, _old: int, new: int) -> None:
        self._requested(2, new)

    def frame_in(self, box: int) -> Frame:
        """Return the frame of a transmit mailbox."""
        word, length = self.value[f"TI{box}R"], min(self.value[f"TDT{box}R"] & 15, 8)
        extended, remote = bool(word & 4), bool(word & 2)
        data = (self.value[f"TDL{box}R"] | self.value[f"TDH{box}R"] << 32).to_bytes(8, "little")[:length]
        return Frame(word >> 3 if extended else word >> 21, b"" if remote else data, extended, remote, length)

    def _by_priority(self) -> list[int]:
        """32.7.1: by request with TXFP, else by identifier, then by mailbox number."""
        if self.value["MCR"] & TXFP:
            return list(self.pending)
        return sorted(self.pending, key=lambda box: (head(self.frame_in(box)), box))

    def scheduled(self) -> int | None:
        """Return the mailbox that goes next, None if nothing may be sent."""
        if self.mode != "normal" or self.bus_off or not self.pending:
            return None
        if self.value["BTR"] & SILM and not self.loops_back:
            return None
        return self._by_priority()[0]

    def lost_arbitration(self, box: int) -> None:
        self.value["TSR"] |= ALST << 8 * box
        if self.value["MCR"] & NART or box in self.aborting:
            self._finish(box, 0)

    def _finish(self, box: int, flags: int) -> None:
        """The mailbox is empty again."""
        self.pending.remove(box)
        self.aborting.discard(box)
        self.value[f"TI{box}R"] &= ~TXRQ
        self.value["TSR"] = self.value["TSR"] & ~(ABRQ << 8 * box) | (RQCP | flags) << 8 * box
        self._interrupt()

    def write_TSR(self, old: int, new: int) -> None:
        """Flags are cleared by writing 1 to RQCP (or to themselves); ABRQ aborts (32.9.2)."""
        word = old
        for box in range(3):
            part = new >> 8 * box
            clear = RQCP | TXOK | ALST | TERR if part & RQCP else part & (TXOK | ALST | TERR)
            word &= ~(clear << 8 * box)
        self.value["TSR"] = word
        for box in range(3):
            if new >> 8 * box & ABRQ and box in self.pending:
                self._abort(box)
        self._interrupt()

    def _abort(self, box: int) -> None:
        """A frame on the wire is not cut short; it is not repeated, though."""
        if self.sending == box:
            self.aborting.add(box)
            self.value["TSR"] |= ABRQ << 8 * box
        else:
            self._finish(box, 0)

    def read_TSR(self) -> int:
        """CODE: the next free mailbox, or that of lowest priority; LOWx with more than one pending."""
        word = self.value["TSR"] & 0x00FF_FFFF
        free = [box for box in range(3) if box not in self.pending]
        order = self._by_priority()
        code = free[0] if free else order[-1]
        low = 1 << 29 + order[-1] if len(order) > 1 else 0
        return word | code << 24 | sum(1 << 26 + box for box in free) | low

    # -- what happens on the wire --

    def frame_ended(self, frame: Frame, box: int | None, failed: str) -> None:
        """A frame of the chip (``box``) or of another node is over."""
        self.sending = None
        if box is None:
            self._heard(frame, failed)
        elif box in self.pending:
            self._sent(frame, box, failed)
        self._interrupt()

    def _sent(self, frame: Frame, box: int, failed: str) -> None:
        if not failed:
            self.tec = max(self.tec - 1, 0)
            self.lec = 0
            self._finish(box, TXOK)
            if self.loops_back:
                self._store(frame)
            return
        # An error-passive node that only lacks an acknowledge does not count on (ISO 11898-1).
        if not (failed == "acknowledge" and self.tec > 127):
            self.tec += 8
        self.value["TSR"] |= TERR << 8 * box
        self._error(ACK_ERROR if failed == "acknowledge" else BIT_RECESSIVE_ERROR)
        if self.value["MCR"] & NART or box in self.aborting:
            self._finish(box, TERR)
        if self.tec > 255:
            self._go_bus_off()

    def _heard(self, frame: Frame, failed: str) -> None:
        if self.mode != "normal" or self.bus_off or self.loops_back:
            return
        if failed:
            self.rec = min(self.rec + 1, 255)
            self._error(STUFF_ERROR)
        else:
            self.rec = 120 if self.rec > 127 else max(self.rec - 1, 0)
            self.lec = 0
            self._store(frame)

    def _error(self, code: int) -> None:
        self.lec = code
        enable, flags = self.value["IER"], self.error_flags
        if enable & 1 << 11 or flags & (enable >> 8 & 7):
            self.value["MSR"] |= ERRI

    @property
    def error_flags(self) -> int:
        worst = max(self.tec, self.rec)
        return EWGF * (worst >= 96) | EPVF * (worst > 127) | BOFF * self.bus_off

    def read_ESR(self) -> int:
        return self.error_flags | self.lec << 4 | min(self.tec, 255) << 16 | min(self.rec, 255) << 24

    def write_ESR(self, _old: int, new: int) -> None:
        self.lec = new >> 4 & 7

    def _go_bus_off(self) -> None:
        """Recovery (32.7.6): with ABOM by itself, else after initialization mode; 128 times 11 recessive bits."""
        self.bus_off = True
        self.chip.note(self.name, "bus off")
        self._error(self.lec)
        if self.value["MCR"] & ABOM:
            self._recover()

    def _recover(self) -> None:
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
        """Return the filter banks of CAN1: those below CAN2SB."""
        count = min(self.value["FMR"] >> CAN1_BANKS_FIELD & 0x3F, BANKS)
        value = self.value
        return [
            Bank(
                bool(value["FS1R"] >> n & 1),
                bool(value["FM1R"] >> n & 1),
                value["FFA1R"] >> n & 1,
                bool(value["FA1R"] >> n & 1),
                (value[f"F{n}R1"], value[f"F{n}R2"]),
            )
            for n in range(count)
        ]

    def _store(self, frame: Frame) -> None:
        """While FINIT is 1 nothing is received. A full FIFO loses the newest or, without RFLM, its last message."""
        accepted = None if self.value["FMR"] & 1 else accept(self.banks(), frame)
        if accepted is None:
            return
        number, index = accepted
        fifo, flags = self.fifo[number], f"RF{number}R"
        self.received.append((self.chip.now, number, frame))
        if len(fifo) == 3:
            self.value[flags] |= FOVR
            self.chip.note(self.name, f"overrun of FIFO {number}")
            if self.value["MCR"] & RFLM:
                return
            fifo.pop()
        fifo.append((frame, index))
        if len(fifo) == 3:
            self.value[flags] |= FULL
        self._show(number)

    def _show(self, number: int) -> None:
        """Put the oldest message into the output mailbox."""
        if not self.fifo[number]:
            return
        frame, index = self.fifo[number][0]
        word = frame.identifier << 3 | 4 if frame.extended else frame.identifier << 21
        data = int.from_bytes(frame.data.ljust(8, b"\0"), "little")
        self.value[f"RI{number}R"] = word | frame.remote << 1
        self.value[f"RDT{number}R"] = frame.length | index << 8
        self.value[f"RDL{number}R"] = data & 0xFFFF_FFFF
        self.value[f"RDH{number}R"] = data >> 32

    def _write_fifo(self, number: int, old: int, new: int) -> None:
        self.value[f"RF{number}R"] = old & ~(new & (FULL | FOVR)) & (FULL | FOVR)
        if new & RFOM:
            if self.fifo[number]:
                self.fifo[number].pop(0)
                self._show(number)
            else:
                self.complain(f"RF{number}R", "RFOM while the FIFO is empty")
        self._interrupt()

    def write_RF0R(self, old: int, new: int) -> None:
        self._write_fifo(0, old, new)

    def write_RF1R(self, old: int, new: int) -> None:
        self._write_fifo(1, old, new)

    def read_RF0R(self) -> int:
        return self.value["RF0R"] | len(self.fifo[0])

    def read_RF1R(self) -> int:
        return self.value["RF1R"] | len(self.fifo[1])

    # -- interrupts, 32.8 --

    def write_IER(self, _old: int, _new: int) -> None:
        self._interrupt()

    def _interrupt(self) -> None:
        enable, nvic = self.value["IER"], self.chip.nvic
        nvic.line(TX_IRQ, self.name, bool(enable & 1 and self.value["TSR"] & 0x0001_0101))
        for number, irq, shift in ((0, RX0_IRQ, 1), (1, RX1_IRQ, 4)):
            flags = self.value[f"RF{number}R"]
            wanted = enable >> shift
            active = (
                (wanted & 1 and self.fifo[number]) or (wanted & 2 and flags & FULL) or (wanted & 4 and flags & FOVR)
            )
            nvic.line(irq, self.name, bool(active))
        status = self.value["MSR"]
        changes = (enable & 1 << 15 and status & ERRI) or (enable & 1 << 16 and status & WKUI)
        nvic.line(SCE_IRQ, self.name, bool(changes or (enable & 1 << 17 and status & SLAKI)))
