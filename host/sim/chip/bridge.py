"""What the motor sees of the pins: which transistor is on when, and whether the ADC samples while the low side is."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from .adc import Sample
from .pins import Level

if TYPE_CHECKING:
    from .chip import Chip


@dataclass
class Phase:
    """One half bridge: its pins, and when its low side was on as [from, to) in cycles."""

    name: str
    high_pin: str
    low_pin: str
    high: bool = False
    low: bool = False
    low_since: int = 0
    low_windows: list[tuple[int, int]] = field(default_factory=list)


@dataclass(frozen=True)
class SampleCheck:
    """One current sample against the low-side window of its phase. Margins in cycles; negative: outside."""

    phase: str
    sample: Sample
    window: tuple[int, int] | None
    before: int
    after: int

    def inside(self, settling: int = 0) -> bool:
        """Tell whether it began ``settling`` cycles after the low side came on, and ended before that went off."""
        return self.window is not None and self.before >= settling and self.after >= 0


def place(phase: str, sample: Sample, windows: list[tuple[int, int]]) -> SampleCheck:
    """Find the window that a sample begins in."""
    at = bisect_right(windows, sample.trigger, key=lambda window: window[0]) - 1
    if at < 0 or windows[at][1] <= sample.trigger:
        return SampleCheck(phase, sample, None, -1, -1)
    begin, end = windows[at]
    return SampleCheck(phase, sample, (begin, end), sample.trigger - begin, end - sample.latest)


class HalfBridges:
    """Watches the gate pins of the phases: ``{"a": ("PA8", "PB13"), ...}``, high side first; a high pin means on."""

    def __init__(self, chip: Chip, phases: dict[str, tuple[str, str]]) -> None:
        self.chip = chip
        self.phases = {name: Phase(name, high, low) for name, (high, low) in phases.items()}
        for phase in self.phases.values():
            chip.pins.watch(phase.high_pin, lambda level, phase=phase: self._high(phase, level))  # type: ignore[misc]
            chip.pins.watch(phase.low_pin, lambda level, phase=phase: self._low(phase, level))  # type: ignore[misc]
            self._high(phase, chip.pins.level(phase.high_pin))
            self._low(phase, chip.pins.level(phase.low_pin))

    def _high(self, phase: Phase, level: Level) -> None:
        phase.high = level == 1
        self._check(phase)

    def _low(self, phase: Phase, level: Level) -> None:
        on = level == 1
        if on and not phase.low:
            phase.low_since = self.chip.now
        elif phase.low and not on:
            phase.low_windows.append((phase.low_since, self.chip.now))
        phase.low = on
        self._check(phase)

    def _check(self, phase: Phase) -> None:
        if phase.high and phase.low:
            self.chip.complain("bridge", phase.name, f"{phase.high_pin} and {phase.low_pin} both high: shoot-through")

    def low_windows(self, name: str) -> list[tuple[int, int]]:
        """Return when a low side was on, the window still open included."""
        phase = self.phases[name]
        return phase.low_windows + ([(phase.low_since, self.chip.now)] if phase.low else [])

    def check_samples(self, channels: dict[tuple[str, int], str]) -> list[SampleCheck]:
        """Return for every conversion of ``{("ADC1", 10): "a", ...}`` how it lies in its phase's low-side window."""
        windows = {name: self.low_windows(name) for name in self.phases}
        checks = []
        for adc in self.chip.adcs.values():
            for sample in adc.samples:
                phase = channels.get((sample.adc, sample.channel))
                if phase is not None:
                    checks.append(place(phase, sample, windows[phase]))
        return sorted(checks, key=lambda check: check.sample.trigger)
