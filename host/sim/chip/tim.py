"""TIM1, the advanced-control timer: RM0090 section 17. Counter, compare channels and events; see tim_output.py."""

from __future__ import annotations

from typing import ClassVar, Literal

from .pin_table import SIGNAL_ON
from .registers import Peripheral, Register
from .tim_output import BKE, OutputStage, dead_time_ticks
from .timeline import Due

CEN, UDIS, URS, OPM, DIR, ARPE = (1 << n for n in (0, 1, 2, 3, 4, 7))
UIF, COMIF, TIF, BIF = 1, 1 << 5, 1 << 6, 1 << 7
UG, COMG, TG, BG = 1, 1 << 5, 1 << 6, 1 << 7
BRK_IRQ, UP_IRQ, TRG_IRQ, CC_IRQ = 24, 25, 26, 27
CHANNELS = (1, 2, 3, 4)
# 17.4.7, OCxM
FROZEN, SET, CLEAR, TOGGLE, FORCE_LOW, FORCE_HIGH, PWM1, PWM2 = range(8)
# What each level of LOCK protects, 17.4.18: register -> bits.
LOCKED = {
    1: {"BDTR": 0x70FF, "CR2": 0x7F00},
    2: {"BDTR": 0x7CFF, "CR2": 0x7F00, "CCER": 0x2AAA},
    3: {"BDTR": 0x7CFF, "CR2": 0x7F00, "CCER": 0x2AAA, "CCMR1": 0x7878, "CCMR2": 0x7878},
}


class Tim(Peripheral):
    """An advanced-control timer. Times are cycles of the core; a tick is one step of the counter.

    ``boundaries`` holds every overflow and underflow as (cycle, "top" or "bottom"), ``updates`` every update event as
    (cycle, "top", "bottom" or "software"), ``effects`` every compare value that came to act as (channel, value, cycle
    of its write, cycle from which it acts). ``cc_trigger`` says what the line TIM1_CCx to the ADCs is, which the manual
    leaves open: the "output" OCx behind the output stage, or the "reference" OCxREF; a driver should work with both.
    """

    registers: ClassVar = (
        Register("CR1", 0x00, 0, 0x3FF),
        Register("CR2", 0x04, 0, 0x7FFD),
        Register("SMCR", 0x08, 0, 0xFFF7),
        Register("DIER", 0x0C, 0, 0x7FFF),
        Register("SR", 0x10, 0, 0, clear=0x1EFF),
        Register("EGR", 0x14, 0, 0xFF, readable=False),
        Register("CCMR1", 0x18, 0, 0xFFFF),
        Register("CCMR2", 0x1C, 0, 0xFFFF),
        Register("CCER", 0x20, 0, 0x3FFF),
        Register("CNT", 0x24, 0, 0xFFFF),
        Register("PSC", 0x28, 0, 0xFFFF),
        Register("ARR", 0x2C, 0xFFFF, 0xFFFF),  # 17.4.12: reset value 0xFFFF in recent revisions, 0 in old ones
        Register("RCR", 0x30, 0, 0xFF),
        *(Register(f"CCR{n}", 0x30 + 4 * n, 0, 0xFFFF) for n in CHANNELS),
        Register("BDTR", 0x44, 0, 0xFFFF),
        Register("DCR", 0x48, 0, 0x1F1F),
        Register("DMAR", 0x4C),
    )

    def power_up(self) -> None:
        self.out = OutputStage(self)
        self._due: list[Due] = []
        self._watching_break = False
        self.cc_trigger: Literal["output", "reference"] = "output"
        self.updates: list[tuple[int, str]] = []
        self.boundaries: list[tuple[int, str]] = []
        self.effects: list[tuple[int, int, int, int]] = []
        self._start_values()

    def _start_values(self) -> None:
        self.psc, self.arr, self.repetitions = 0, 0xFFFF, 0
        self.tick, self.dead_time, self.centred = 1, 0, False
        self.ccr = [0] * 5  # active registers; [0] is not used
        self.ref = [0] * 5
        self.position, self.since, self.running = 0, 0, False
        self.lock, self.lock_fixed = 0, False
        self.writes: dict[int, tuple[int, int]] = {}  # by channel: value and cycle of a write that does not act yet

    def reset(self) -> None:
        super().reset()
        self._cancel()
        self._start_values()
        self.out.reset()
        self._interrupt()

    # -- the counter: a position along one period, 17.3.2 --

    @property
    def length(self) -> int:
        """Steps of one period: 2 ARR up and down (0 to ARR-1, ARR to 1), ARR + 1 in one direction."""
        return 2 * self.arr if self.centred else self.arr + 1

    def _place(self) -> int:
        """Return the position in the period now."""
        if not self.running:
            return self.position
        return (self.position + (self.chip.now - self.since) // self.tick) % max(self.length, 1)

    def _count_at(self, position: int) -> tuple[int, int]:
        """Return counter and direction (1: down) at a position."""
        if self.centred:
            return (position, 0) if position < self.arr else (2 * self.arr - position, 1)
        down = self.value["CR1"] >> 4 & 1
        return (self.arr - position if down else position), down

    def _position_of(self, count: int, down: int) -> int:
        if self.centred:
            return (2 * self.arr - count) % max(self.length, 1) if down or count == self.arr else count
        return self.arr - count if down else count

    def read_CNT(self) -> int:
        return self._count_at(self._place())[0]

    def read_CR1(self) -> int:
        word = self.value["CR1"]
        if self.centred:
            word = word & ~DIR | DIR * self._count_at(self._place())[1]
        return word

    # -- running on to the next boundary --

    def _cancel(self) -> None:
        for due in self._due:
            due.cancel()
        self._due.clear()

    def _hold(self) -> None:
        """Take the counter's place as the new origin, so that its settings may change."""
        if self.running:
            steps = (self.chip.now - self.since) // self.tick
            self.position = (self.position + steps) % max(self.length, 1)
            self.since += steps * self.tick

    def _plan(self) -> None:
        """Ask to be called at every compare match and at the next boundary."""
        self._cancel()
        if not self.running or self.length == 0:
            return
        place, end = self.position, self._next_boundary(self.position)
        self._at_place(end, self._boundary)
        down = self._count_at(place)[1]
        for channel in CHANNELS:
            match = self._position_of(self.ccr[channel], down)
            inside = self.ccr[channel] <= self.arr and self._count_at(match)[1] == down
            if inside and place < match < end:
                self._at_place(match, lambda channel=channel: self._match(channel))  # type: ignore[misc]

    def _next_boundary(self, place: int) -> int:
        return self.arr if self.centred and place < self.arr else self.length

    def _at_place(self, place: int, act: object) -> None:
        self._due.append(self.chip.at(self.since + (place - self.position) * self.tick, act))  # type: ignore[arg-type]

    def _boundary(self) -> None:
        """The counter reaches ARR going up, or 0 going down: overflow or underflow (17.3.2)."""
        place = self._next_boundary(self.position) % self.length
        self.position, self.since = place, self.chip.now
        top = place == self.arr if self.centred else not self.value["CR1"] & DIR
        self.boundaries.append((self.chip.now, "top" if top else "bottom"))
        if self.repetitions:
            self.repetitions -= 1
        else:
            self._update("top" if top else "bottom")
            self.position = self.arr if self.centred and top else place  # the counter is loaded with the new ARR
        count = self._count_at(self.position)[0]
        for channel in CHANNELS:
            beyond = self.ccr[channel] > self.arr
            if (beyond and top) or (not beyond and self.ccr[channel] == count):
                self._match(channel)
        self._refresh_all()
        if self.length != 0:
            self._plan()

    def _match(self, channel: int) -> None:
        """CNT has reached CCRx: the flag, by CMS (17.4.1), and the reference of the channel."""
        compare, cms = self.ccr[channel], self.value["CR1"] >> 5 & 3
        at_end = compare == 0 or compare >= self.arr
        count, down = self._count_at(self._place())
        if at_end or cms in (0, 3) or (cms == 1) == bool(down):
            self._flag(1 << channel)
            if channel == 1 and self._mms == 3:
                self._pulse("TIM1_TRGO")
        self._on_match(channel)
        self._refresh(channel, count, down)

    def _on_match(self, channel: int) -> None:
        mode = self._mode(channel)
        if mode in (SET, CLEAR, TOGGLE):
            self.ref[channel] = {SET: 1, CLEAR: 0, TOGGLE: 1 - self.ref[channel]}[mode]
            self._ref_changed(channel)

    # -- update events, 17.3.3 --

    def _update(self, where: str) -> None:
        """An update event: preload registers become active, REP_CNT is loaded anew, UIF (17.3.1, 17.3.3)."""
        if self.value["CR1"] & UDIS:
            return
        self._load()
        self.updates.append((self.chip.now, where))
        self.chip.note(self.name, f"update at {where}")
        self._flag(UIF)
        self.out.automatic_enable()
        if self._mms == 2:
            self._pulse("TIM1_TRGO")
        if self.value["CR1"] & OPM:
            self.value["CR1"] &= ~CEN
            self.running = False

    def _load(self) -> None:
        self.psc = self.value["PSC"]
        self.arr = self.value["ARR"]
        self.repetitions = self.value["RCR"]
        self._scale()
        for channel, (value, written) in self.writes.items():
            self.effects.append((channel, value, written, self.chip.now))
        self.writes.clear()
        for channel in CHANNELS:
            self.ccr[channel] = self.value[f"CCR{channel}"]
        if self.arr == 0:
            self.complain("ARR", "0 stops the counter (17.4.12)")

    def write_EGR(self, _old: int, new: int) -> None:
        self.value["EGR"] = 0
        if new & UG:
            self._generate_update()
        for channel in CHANNELS:
            if new >> channel & 1:
                self._flag(1 << channel)
        if new & COMG:
            self.out.commutate()
            self._flag(COMIF)
        if new & BG:
            self.out.break_now()
        if new & TG:
            self._flag(TIF)

    def _generate_update(self) -> None:
        """UG: the counter starts anew, also its prescaler; UIF only if URS is 0 (17.4.6)."""
        self._hold()
        if not self.value["CR1"] & UDIS:
            self._load()
            self.updates.append((self.chip.now, "software"))
            if not self.value["CR1"] & URS:
                self._flag(UIF)
            self.out.automatic_enable()
        self.position, self.since = 0, self.chip.now
        if self._mms in (0, 2):
            self._pulse("TIM1_TRGO")
        self._refresh_all()
        self._plan()

    # -- compare channels, 17.3.6 to 17.3.9 --

    def _field(self, channel: int) -> int:
        """Return the byte of CCMR1 or CCMR2 for a channel."""
        return self.value["CCMR1" if channel < 3 else "CCMR2"] >> (8 if channel in (2, 4) else 0) & 0xFF

    def _mode(self, channel: int) -> int:
        return self._field(channel) >> 4 & 7

    def _preloaded(self, channel: int) -> int:
        return self._field(channel) & 8

    def _wanted(self, channel: int, count: int, down: int) -> int:
        """Return OCxREF as mode, counter and direction make it (17.3.10)."""
        mode, compare = self._mode(channel), self.ccr[channel]
        if mode >= PWM1:
            high = count <= compare if down else count < compare
            return int(high == (mode == PWM1))
        return mode - FORCE_LOW if mode in (FORCE_LOW, FORCE_HIGH) else self.ref[channel]

    def _refresh(self, channel: int, count: int, down: int) -> None:
        wanted = self._wanted(channel, count, down)
        if wanted != self.ref[channel]:
            self.ref[channel] = wanted
            self._ref_changed(channel)

    def _refresh_all(self) -> None:
        count, down = self._count_at(self._place())
        for channel in CHANNELS:
            self._refresh(channel, count, down)

    def _ref_changed(self, channel: int) -> None:
        if self._mms == channel + 3:
            self.chip.trigger("TIM1_TRGO", self.ref[channel])
        self.out.reference(channel)

    @property
    def _mms(self) -> int:
        return self.value["CR2"] >> 4 & 7

    def _pulse(self, line: str) -> None:
        self.chip.trigger(line, 1)
        self.chip.trigger(line, 0)

    # -- flags and interrupts --

    def _flag(self, bits: int) -> None:
        if bits & ~self.value["SR"]:
            self.value["SR"] |= bits
            self._interrupt()

    def _interrupt(self) -> None:
        """17.4.4, 17.4.5; vectors: table 61."""
        active = self.value["SR"] & self.value["DIER"]
        for number, bits in ((BRK_IRQ, BIF), (UP_IRQ, UIF), (TRG_IRQ, TIF | COMIF), (CC_IRQ, 0x1E)):
            self.chip.nvic.line(number, self.name, bool(active & bits))

    def write_SR(self, old: int, _new: int) -> None:
        """BIF stays while the break input is active (17.4.5)."""
        if self.out.break_active():
            self.value["SR"] |= old & BIF
        self._interrupt()

    def write_DIER(self, _old: int, new: int) -> None:
        if new & 0x7F00:
            self.complain("DIER", "DMA requests are not modelled")
        self._interrupt()

    # -- control registers --

    def write_CR1(self, old: int, new: int) -> None:
        """CMS and DIR may change while the counter stands; in centre-aligned mode DIR belongs to the counter."""
        changed, self.value["CR1"] = old ^ new, old
        self._hold()
        count, down = self._count_at(self.position)
        self.value["CR1"] = new
        self._scale()
        if changed & 0x60 and (old & CEN or changed & DIR):
            self.complain("CR1", "CMS changed while the counter runs, or together with DIR (17.4.1, 17.3.10)")
        if new & old & 0x60 and new & DIR != DIR * down:
            down = self._turned(new, down)
        else:
            down = new >> 4 & 1
        self.position = self._position_of(min(count, self.arr), down) % max(self.length, 1)
        if new & ~old & CEN:
            self._start()
        elif old & ~new & CEN:
            self.running = False
        if changed & 0x300:
            self.out.refresh_all()
        self._plan()

    def _turned(self, new: int, down: int) -> int:
        """DIR written in centre-aligned mode: 17.4.1 calls it read-only, 17.3.10 says that it counts at the start."""
        if self.running:
            return down  # a word written back: the counter has turned since it was read
        self.doubt("CR1", "DIR written in centre-aligned mode: read-only (17.4.1), or used at the start (17.3.10)")
        return new >> 4 & 1

    def _start(self) -> None:
        self.chip.need_full_speed(self.name)
        self.running, self.since = True, self.chip.now
        self._check_repetition()
        if self._mms == 1:
            self._pulse("TIM1_TRGO")
        self._refresh_all()

    def _check_repetition(self) -> None:
        if self.running and self.centred and self.value["RCR"] & 1 and not self.value["CR1"] & UDIS:
            self.doubt(
                "RCR",
                "odd in centre-aligned mode: 17.3.3 says the update comes at the overflow if RCR was written before "
                "the start, RM0440 says the underflow; the model counts REP_CNT down from its last load",
            )

    def write_RCR(self, _old: int, _new: int) -> None:
        self._check_repetition()

    def write_CR2(self, old: int, new: int) -> None:
        self._guard("CR2", old, new)
        self.chip.trigger("TIM1_TRGO", self.ref[self._mms - 3] if self._mms > 3 else 0)
        self.out.refresh_all()

    def write_SMCR(self, _old: int, new: int) -> None:
        if new & 7:
            self.complain("SMCR", "slave modes are not modelled")

    def write_CNT(self, _old: int, new: int) -> None:
        if self.running and self.centred:
            self.doubt("CNT", "written while the counter runs in centre-aligned mode: not recommended (17.3.10)")
        down = self._count_at(self._place())[1]
        self._hold()
        if new > self.arr:
            self.complain("CNT", f"{new} is beyond ARR, {self.arr}: direction is not updated (17.3.10)")
            new = self.arr
        self.position, self.since = self._position_of(new, down) % max(self.length, 1), self.chip.now
        self._refresh_all()
        self._plan()

    def write_ARR(self, _old: int, new: int) -> None:
        """Acts at once unless ARPE is set (17.3.1)."""
        if self.value["CR1"] & ARPE:
            return
        self._hold()
        count, down = self._count_at(self.position)
        if self.running and count > new:
            self.complain("ARR", f"{new} without ARPE while the counter is beyond it, at {count}")
        self.arr = new
        self.position = self._position_of(min(count, new), down) % max(self.length, 1)
        self._refresh_all()
        self._plan()

    def _write_compare(self, channel: int, new: int) -> None:
        """Acts at the next update if preloaded, else at once (17.4.14)."""
        if self._preloaded(channel):
            self.writes[channel] = new, self.chip.now
            return
        self.effects.append((channel, new, self.chip.now, self.chip.now))
        self._hold()
        self.ccr[channel] = new
        self._refresh(channel, *self._count_at(self.position))
        self._plan()

    def write_CCR1(self, _old: int, new: int) -> None:
        self._write_compare(1, new)

    def write_CCR2(self, _old: int, new: int) -> None:
        self._write_compare(2, new)

    def write_CCR3(self, _old: int, new: int) -> None:
        self._write_compare(3, new)

    def write_CCR4(self, _old: int, new: int) -> None:
        self._write_compare(4, new)

    def _write_mode(self, name: str, old: int, new: int) -> None:
        self._guard(name, old, new)
        if self.value[name] & 0x0303:
            self.complain(name, "input capture is not modelled")
        if self.value[name] & 0x8080:
            self.complain(name, "OCxCE needs ETRF, which is not modelled")
        self._hold()
        for channel in (1, 2) if name == "CCMR1" else (3, 4):
            if not self._preloaded(channel):
                self.ccr[channel] = self.value[f"CCR{channel}"]
        self._refresh_all()
        self._plan()

    def write_CCMR1(self, old: int, new: int) -> None:
        self._write_mode("CCMR1", old, new)

    def write_CCMR2(self, old: int, new: int) -> None:
        self._write_mode("CCMR2", old, new)

    def write_CCER(self, old: int, new: int) -> None:
        self._guard("CCER", old, new)
        self.out.enables_written()

    # -- break and lock, 17.3.12, 17.4.18 --

    def _guard(self, name: str, old: int, new: int) -> None:
        """Take back what LOCK protects."""
        bits = LOCKED.get(self.lock, {}).get(name, 0)
        if (old ^ new) & bits:
            self.complain(name, f"bits 0x{(old ^ new) & bits:X} are locked at LOCK level {self.lock} (17.4.18)")
            self.value[name] = new & ~bits | old & bits

    def write_BDTR(self, old: int, new: int) -> None:
        self._guard("BDTR", old, new)
        if self.lock_fixed and (old ^ new) & 0x300:
            self.complain("BDTR", "LOCK is fixed by the first write of BDTR after a reset (17.4.18)")
            self.value["BDTR"] = self.value["BDTR"] & ~0x300 | self.lock << 8
        self.lock, self.lock_fixed = self.value["BDTR"] >> 8 & 3, True
        self._scale()
        if self.value["BDTR"] & BKE:
            self._watch_break()
        self.out.main_enable_written(old)

    def _watch_break(self) -> None:
        """Look at the break pin from now on; what an input without a pin, or one that floats, does is open."""
        signal = f"{self.name}_BKIN"
        pin = self.chip.pins.pin_of(signal, self.name)
        if pin and self.chip.pins.level(pin) is None:
            self.complain("BDTR", f"break enabled while {pin} floats")
        if not self._watching_break:
            self._watching_break = True
            for (place, _), name in SIGNAL_ON.items():
                if name == signal:
                    self.chip.pins.watch(place, lambda _level: self.out.look_at_break())

    def _scale(self) -> None:
        """Work out what follows from the settings: cycles of a step, of the dead time; centre-aligned or not."""
        clock = self.chip.rcc.tim_apb2_cycles
        self.tick = (self.psc + 1) * clock
        self.centred = bool(self.value["CR1"] >> 5 & 3)
        # 17.4.18 DTG, 17.4.1 CKD
        self.dead_time = dead_time_ticks(self.value["BDTR"] & 0xFF) * (1, 2, 4, 4)[self.value["CR1"] >> 8 & 3] * clock
