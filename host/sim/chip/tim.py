"""TIM1, the advanced-control timer: RM0090 section 17, as far as it drives a bridge. Outputs: see tim_output.py.

Modelled are centre-aligned counting, PWM mode 1 on three channels with their complements, update events with
repetition as TRGO and as interrupt, and the break input.
"""

from __future__ import annotations

from functools import partial
from typing import ClassVar

from .pin_table import SIGNAL_ON
from .registers import Peripheral, Register
from .tim_output import BKE, BKP, MOE, OSSI, OSSR, OutputStage, dead_time_ticks
from .timeline import Due

CEN, DIR, CMS, ARPE = 1, 1 << 4, 3 << 5, 1 << 7
UIF, BIF, UG = 1, 1 << 7, 1
UPDATE_IS_TRGO = 2 << 4  # 17.4.2, MMS
UP_IRQ = 25  # table 61
CHANNELS = (1, 2, 3)
FROZEN, PWM1 = 0, 6  # 17.4.7, OCxM


class Tim(Peripheral):
    """An advanced-control timer. Times are cycles of the core, which are also the steps of the counter.

    ``updates`` holds every update event as (cycle, "top", "bottom" or "software"), ``effects`` every compare value that
    came to act as (channel, value, cycle of its write, cycle from which it acts).
    """

    registers: ClassVar = (
        Register("CR1", 0x00, 0, CEN | CMS | ARPE, back=DIR),
        Register("CR2", 0x04, 0, UPDATE_IS_TRGO),
        Register("SMCR", 0x08, 0, 0),
        Register("DIER", 0x0C, 0, UIF),
        Register("SR", 0x10, 0, 0, clear=UIF | BIF),
        Register("EGR", 0x14, 0, UG, readable=False),
        Register("CCMR1", 0x18, 0, 0x7878),
        Register("CCMR2", 0x1C, 0, 0x0078),
        Register("CCER", 0x20, 0, 0x0FFF),
        Register("CNT", 0x24, 0, 0),
        Register("PSC", 0x28, 0, 0),
        Register("ARR", 0x2C, 0xFFFF, 0xFFFF),  # 17.4.12: reset value 0xFFFF in recent revisions, 0 in old ones
        Register("RCR", 0x30, 0, 0xFF),
        *(Register(f"CCR{n}", 0x30 + 4 * n, 0, 0xFFFF) for n in CHANNELS),
        Register("BDTR", 0x44, 0, MOE | BKP | BKE | OSSR | OSSI | 0xFF),
    )

    def power_up(self) -> None:
        self.out = OutputStage(self)
        self._due: list[Due] = []
        self._watching_break = False
        self.updates: list[tuple[int, str]] = []
        self.effects: list[tuple[int, int, int, int]] = []
        for channel in CHANNELS:
            self.on_write(f"CCR{channel}", partial(self._write_compare, channel))
        for name in ("CCMR1", "CCMR2"):
            self.on_write(name, self._write_modes)
        self.on_write("CCER", self.out.enables_written)

    def clear(self) -> None:
        self._cancel()
        self.arr, self.repetitions, self.dead_time = 0xFFFF, 0, 0
        self.ccr = [0] * 4  # active registers; [0] is not used
        self.ref = [0] * 4
        self.position, self.since, self.running = 0, 0, False
        self.writes: dict[int, tuple[int, int]] = {}  # by channel: value and cycle of a write that does not act yet

    def reset(self) -> None:
        super().reset()
        self.out.reset()
        self._interrupt()

    # -- the counter: a position along one period, 0 to ARR-1 up, ARR to 1 down, 17.3.2 --

    @property
    def length(self) -> int:
        """Steps of one period."""
        return 2 * self.arr

    def _place(self) -> int:
        """Return the position in the period now."""
        gone = self.chip.now - self.since if self.running else 0
        return (self.position + gone) % max(self.length, 1)

    def _count_at(self, position: int) -> tuple[int, int]:
        """Return counter and direction (1: down) at a position."""
        return (position, 0) if position < self.arr else (2 * self.arr - position, 1)

    def _position_of(self, count: int, down: int) -> int:
        return (2 * self.arr - count) % max(self.length, 1) if down or count == self.arr else count

    def read_CNT(self) -> int:
        return self._count_at(self._place())[0]

    def read_CR1(self) -> int:
        return self.value["CR1"] | DIR * self._count_at(self._place())[1]

    # -- running on to the next boundary --

    def _cancel(self) -> None:
        for due in self._due:
            due.cancel()
        self._due.clear()

    def _hold(self) -> None:
        """Take the counter's place as the new origin, so that its settings may change."""
        self.position, self.since = self._place(), self.chip.now

    def _plan(self) -> None:
        """Ask to be called at every compare match and at the next boundary."""
        self._cancel()
        if not self.running or self.length == 0:
            return
        place, end = self.position, self._next_boundary()
        self._due.append(self.chip.at(self.since + end - place, self._boundary))
        down = self._count_at(place)[1]
        for channel in CHANNELS:
            match = self._position_of(self.ccr[channel], down)
            inside = self.ccr[channel] <= self.arr and self._count_at(match)[1] == down
            if inside and place < match < end:
                self._due.append(self.chip.at(self.since + match - place, partial(self._refresh, channel)))

    def _next_boundary(self) -> int:
        return self.arr if self.position < self.arr else self.length

    def _boundary(self) -> None:
        """The counter reaches ARR going up, or 0 going down: overflow or underflow (17.3.2)."""
        place = self._next_boundary() % self.length
        self.position, self.since = place, self.chip.now
        top = place == self.arr
        if self.repetitions:
            self.repetitions -= 1
        else:
            self._update("top" if top else "bottom")
            self.position = self.arr if top else 0  # the counter is loaded with the new ARR
        self._refresh_all()
        self._plan()

    # -- update events, 17.3.3 --

    def _update(self, where: str) -> None:
        """An update event: preload registers become active, REP_CNT is loaded anew, UIF (17.3.1, 17.3.3)."""
        self.arr, self.repetitions = self.value["ARR"], self.value["RCR"]
        for channel, (value, written) in self.writes.items():
            self.effects.append((channel, value, written, self.chip.now))
        self.writes.clear()
        for channel in CHANNELS:
            self.ccr[channel] = self.value[f"CCR{channel}"]
        if self.arr == 0:
            self.complain("ARR", "0 stops the counter (17.4.12)")
        self.updates.append((self.chip.now, where))
        self.chip.note(self.name, f"update at {where}")
        self.flag(UIF)
        if self.value["CR2"] & UPDATE_IS_TRGO:
            self.chip.trigger_adcs()

    def write_EGR(self, _old: int, new: int) -> None:
        """UG: an update, and the counter starts anew (17.4.6)."""
        self.value["EGR"] = 0
        if new & UG:
            self._update("software")
            self.position, self.since = 0, self.chip.now
            self._refresh_all()
            self._plan()

    # -- compare channels, 17.3.6 to 17.3.9 --

    def _field(self, channel: int) -> int:
        """Return the byte of CCMR1 or CCMR2 for a channel."""
        return (self.value["CCMR1"] | self.value["CCMR2"] << 16) >> 8 * (channel - 1) & 0xFF

    def _mode(self, channel: int) -> int:
        return self._field(channel) >> 4

    def _preloaded(self, channel: int) -> int:
        return self._field(channel) & 8

    def _refresh(self, channel: int) -> None:
        """Set OCxREF as mode, counter and direction make it (17.3.10)."""
        count, down = self._count_at(self._place())
        compare = self.ccr[channel]
        wanted = int(count <= compare if down else count < compare)
        if self._mode(channel) == PWM1 and wanted != self.ref[channel]:
            self.ref[channel] = wanted
            self.out.reference(channel)

    def _refresh_all(self) -> None:
        for channel in CHANNELS:
            self._refresh(channel)

    # -- flags and the interrupt --

    def flag(self, bits: int) -> None:
        """Set flags of SR."""
        self.value["SR"] |= bits
        self._interrupt()

    def _interrupt(self) -> None:
        """17.4.4, 17.4.5."""
        self.chip.nvic.line(UP_IRQ, self.name, bool(self.value["SR"] & self.value["DIER"] & UIF))

    def write_SR(self, old: int, _new: int) -> None:
        """BIF stays while the break input is active (17.4.5)."""
        if self.out.break_active():
            self.value["SR"] |= old & BIF
        self._interrupt()

    def write_DIER(self, _old: int, _new: int) -> None:
        self._interrupt()

    # -- control registers --

    def write_CR1(self, old: int, new: int) -> None:
        self._hold()
        if (old ^ new) & CMS and old & CEN:
            self.complain("CR1", "CMS changed while the counter runs (17.4.1)")
        self.running = bool(new & CEN)
        if new & ~old & CEN:
            if not new & CMS:
                self.complain("CR1", "only centre-aligned counting is modelled")
            self._check_repetition()
            self._refresh_all()
        self._plan()

    def _check_repetition(self) -> None:
        if self.running and self.value["RCR"] & 1:
            self.doubt(
                "RCR",
                "odd in centre-aligned mode: 17.3.3 says the update comes at the overflow if RCR was written before "
                "the start, RM0440 says the underflow; the model counts REP_CNT down from its last load",
            )

    def write_RCR(self, _old: int, _new: int) -> None:
        self._check_repetition()

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

    def _write_compare(self, channel: int, _old: int, new: int) -> None:
        """Acts at the next update if preloaded, else at once (17.4.14)."""
        if self._preloaded(channel):
            self.writes[channel] = new, self.chip.now
            return
        self.effects.append((channel, new, self.chip.now, self.chip.now))
        self._hold()
        self.ccr[channel] = new
        self._refresh(channel)
        self._plan()

    def _write_modes(self, _old: int, _new: int) -> None:
        self._hold()
        for channel in CHANNELS:
            if self._mode(channel) not in (FROZEN, PWM1):
                self.complain(f"CH{channel}", "only PWM mode 1 is modelled")
            if not self._preloaded(channel):
                self.ccr[channel] = self.value[f"CCR{channel}"]
        self._refresh_all()
        self._plan()

    # -- break, 17.3.12, 17.4.18 --

    def write_BDTR(self, old: int, new: int) -> None:
        self.dead_time = dead_time_ticks(new & 0xFF)
        if new & BKE:
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
