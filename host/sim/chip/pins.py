"""The pins of the chip: who drives each, at what level it is, and who watches it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from .pin_table import ANALOG_PIN, SIGNAL_ON, SIGNALS

if TYPE_CHECKING:
    from .chip import Chip

Level = int | None  # None: driven by nobody
INPUT, OUTPUT, ALTERNATE, ANALOG = range(4)


class Pins:
    """Levels of all pins. A test drives a pin from outside with ``drive_pin``, a block of the chip by its signal."""

    def __init__(self, chip: Chip) -> None:
        self.chip = chip
        self._signal_level: dict[str, Level] = {}
        self._outside: dict[str, Level] = {}
        self._watchers: dict[str, list[Callable[[Level], None]]] = {}
        self._last: dict[str, Level] = {}
        self._carriers: dict[str, list[str]] | None = None

    # -- questions --

    def carriers(self, signal: str) -> list[str]:
        """Return the pins whose GPIO port has the signal's alternate function selected."""
        if self._carriers is None:
            self._carriers = {name: [] for name in SIGNALS}
            for (pin, number), name in SIGNAL_ON.items():
                port = self.chip.port(pin)
                if port.mode(pin) == ALTERNATE and port.function(pin) == number:
                    self._carriers[name].append(pin)
        return self._carriers[signal]

    def pin_of(self, signal: str, user: str = "") -> str | None:
        """Return the one pin that carries a signal; a complaint and None (or the first) if none or several do."""
        if signal not in SIGNALS:
            raise ValueError(f"signal {signal!r} is not in the table; it has {', '.join(sorted(SIGNALS))}")
        found = self.carriers(signal)
        if len(found) != 1:
            what = "no pin carries it" if not found else f"carried by several pins: {', '.join(found)}"
            self.chip.complain(user or "GPIO", signal, f"{what} (8.3.2)")
        return found[0] if found else None

    def check_analog(self, adc: str, channel: int) -> None:
        """Complain unless the pin of an ADC channel is in analog mode (8.3.12)."""
        pin = ANALOG_PIN[adc, channel]
        if self.chip.port(pin).mode(pin) != ANALOG:
            self.chip.complain(adc, f"IN{channel}", f"{pin} is not in analog mode (8.3.12)")

    def level(self, pin: str) -> Level:
        """Return 0, 1, or None if nobody drives the pin and no resistor pulls it."""
        port, driven = self.chip.port(pin), None
        mode = port.mode(pin)
        if mode == ANALOG:
            return self._outside.get(pin)
        if mode == OUTPUT:
            driven = port.output(pin)
        elif mode == ALTERNATE:
            driven = self._signal_level.get(SIGNAL_ON.get((pin, port.function(pin)), ""))
        if driven == 1 and port.open_drain(pin):
            driven = None
        if driven is not None:
            return driven
        outside = self._outside.get(pin)
        return port.pull(pin) if outside is None else outside

    def input_level(self, signal: str) -> Level:
        """Return the level a block sees on one of its inputs; None if no pin carries it."""
        found = self.carriers(signal)
        return self.level(found[0]) if found else None

    # -- changes --

    def watch(self, pin: str, act: Callable[[Level], None]) -> None:
        """Have ``act(level)`` called at every change of a pin."""
        self._watchers.setdefault(pin, []).append(act)
        self._last[pin] = self.level(pin)

    def drive_pin(self, pin: str, level: Level) -> None:
        """Drive a pin from outside the chip; None lets go."""
        self._outside[pin] = level
        self.refresh(pin)

    def drive(self, signal: str, level: Level) -> None:
        """Set the level that a block of the chip gives one of its signals; None: it does not drive it."""
        if self._signal_level.get(signal) == level:
            return
        self._signal_level[signal] = level
        for pin in self.carriers(signal):
            self.refresh(pin)

    def refresh(self, pin: str) -> None:
        """Tell those who watch a pin if its level has changed."""
        watchers = self._watchers.get(pin)
        if not watchers:
            return
        level = self.level(pin)
        if level != self._last[pin]:
            self._last[pin] = level
            for act in watchers:
                act(level)

    def reconfigured(self, pins: list[str]) -> None:
        """A port's modes have changed."""
        self._carriers = None
        for pin in pins:
            self.refresh(pin)
