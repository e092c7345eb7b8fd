"""The output stage of TIM1: dead time, polarity, idle levels, break. RM0090 sections 17.3.11, 17.3.12, table 94."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .pins import Level

if TYPE_CHECKING:
    from .tim import Tim

MOE, BKP, BKE, OSSR, OSSI = (1 << n for n in (15, 13, 12, 11, 10))
BIF = 1 << 7
CHANNELS = (1, 2, 3)


def dead_time_ticks(code: int) -> int:
    """Return the dead time in steps of t_DTS for DTG[7:0] (17.4.18)."""
    if code < 0x80:
        return code
    if code < 0xC0:
        return (64 + (code & 0x3F)) * 2
    return (32 + (code & 0x1F)) * (8 if code < 0xE0 else 16)


class OutputStage:
    """From OCxREF to the levels of OCx and OCxN, per channel and in time."""

    def __init__(self, tim: Tim) -> None:
        self.tim = tim
        self._clear()

    def _clear(self) -> None:
        self.changed_at = [0] * 4  # when the reference, or what overrides it, last changed
        self.level: dict[str, Level] = {}

    def reset(self) -> None:
        self._clear()
        for channel in CHANNELS:
            self._set(f"CH{channel}", None)
            self._set(f"CH{channel}N", None)

    # -- what changes outputs --

    def reference(self, channel: int) -> None:
        """OCxREF has changed: one output goes off now, the other on after the dead time."""
        if self.tim.value["BDTR"] & MOE:  # otherwise the idle levels stand
            self.changed_at[channel] = self.tim.chip.now
            self.refresh(channel)

    def enables_written(self, old: int, new: int) -> None:
        for channel in CHANNELS:
            if (old ^ new) >> 4 * (channel - 1) & 5:
                self.changed_at[channel] = self.tim.chip.now
        self.refresh_all()

    def main_enable_written(self, old: int) -> None:
        if self.break_active():
            self.break_now()
            self.refresh_all()
        elif (old ^ self.tim.value["BDTR"]) & MOE:
            self._main_enable_changed()
        else:
            self.refresh_all()

    def _main_enable_changed(self) -> None:
        on = self.tim.value["BDTR"] & MOE
        self.tim.chip.note(self.tim.name, "MOE on" if on else "MOE off")
        self.changed_at = [self.tim.chip.now] * 4
        self.refresh_all()

    # -- break, 17.3.12 --

    def break_active(self) -> bool:
        word = self.tim.value["BDTR"]
        if not word & BKE:
            return False
        level = self.tim.chip.pins.input_level(f"{self.tim.name}_BKIN")
        return level == (1 if word & BKP else 0)

    def look_at_break(self) -> None:
        if self.break_active():
            self.break_now()

    def break_now(self) -> None:
        """MOE falls at once, without the clock (17.3.12)."""
        self.tim.chip.note(self.tim.name, "break")
        was_on = self.tim.value["BDTR"] & MOE
        self.tim.value["BDTR"] &= ~MOE
        if was_on:
            self._main_enable_changed()
        self.tim.flag(BIF)

    # -- levels --

    def refresh_all(self) -> None:
        for channel in CHANNELS:
            self.refresh(channel)

    def refresh(self, channel: int) -> None:
        """Set both outputs of a channel to what table 94 says, and come back when the dead time is over."""
        now = self.tim.chip.now
        end = self.changed_at[channel] + self.tim.dead_time
        if now < end:
            self.tim.chip.at(end, lambda: self._after_dead_time(channel, end))
        main, negative = self._levels(channel, settled=now >= end)
        if negative == 1:
            self._set(f"CH{channel}", main)
            self._set(f"CH{channel}N", negative)
        else:  # what goes off, goes off first
            self._set(f"CH{channel}N", negative)
            self._set(f"CH{channel}", main)
        self._check_pair(channel, main, negative)

    def _after_dead_time(self, channel: int, end: int) -> None:
        if end == self.changed_at[channel] + self.tim.dead_time:
            self.refresh(channel)

    def _enables(self, channel: int) -> tuple[int, int]:
        bits = self.tim.value["CCER"] >> 4 * (channel - 1)
        return bits & 1, bits >> 2 & 1

    def _active(self, channel: int, negative: int) -> int:
        """Return the level of OCx (or OCxN) that means on: CCxP, CCxNP (17.4.9)."""
        return 1 - (self.tim.value["CCER"] >> (4 * (channel - 1) + (3 if negative else 1)) & 1)

    def _levels(self, channel: int, settled: bool) -> tuple[Level, Level]:
        """Table 94: output control bits for complementary channels with break feature."""
        word, ref = self.tim.value["BDTR"], self.tim.ref[channel]
        main_on, negative_on = self._enables(channel)
        if not word & MOE:
            return self._idle(channel, settled)
        if main_on and negative_on:
            return self._pair(channel, ref, settled)
        off = bool(word & OSSR and (main_on or negative_on))
        main = self._shape(channel, 0, ref) if main_on else self._shape(channel, 0, 0) if off else None
        negative = self._shape(channel, 1, ref) if negative_on else self._shape(channel, 1, 0) if off else None
        return main, negative

    def _shape(self, channel: int, negative: int, on: int) -> int:
        active = self._active(channel, negative)
        return active if on else 1 - active

    def _pair(self, channel: int, ref: int, settled: bool) -> tuple[Level, Level]:
        """Complementary outputs with dead time (17.3.11): each goes on late, both go off at once."""
        return self._shape(channel, 0, int(ref and settled)), self._shape(channel, 1, int(not ref and settled))

    def _idle(self, channel: int, settled: bool) -> tuple[Level, Level]:
        """MOE is 0: not driven without OSSI; with it inactive at once, low after the dead time, as OISx and OISxN."""
        if not self.tim.value["BDTR"] & OSSI or not any(self._enables(channel)):
            return None, None
        active = self._active(channel, 0), self._active(channel, 1)
        if settled and active == (0, 0):
            self.tim.complain("CR2", f"OIS{channel} and OIS{channel}N both on (table 94): the model keeps both off")
        return (0, 0) if settled and active != (0, 0) else (1 - active[0], 1 - active[1])

    def _check_pair(self, channel: int, main: Level, negative: Level) -> None:
        """Shoot-through as the gates see it: both levels high."""
        if main == 1 and negative == 1:
            self.tim.complain(f"CH{channel}", "both outputs of the pair are high: shoot-through")

    def _set(self, output: str, level: Level) -> None:
        if self.level.get(output) == level:
            return
        self.level[output] = level
        name = self.tim.name
        self.tim.chip.note(f"{name} outputs", f"{output} = {'Z' if level is None else level}")
        self.tim.chip.pins.drive(f"{name}_{output}", level)
