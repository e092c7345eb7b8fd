"""GPIO ports, RM0090 section 8, without the lock of their settings."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import ClassVar

from .pins import ANALOG
from .registers import Peripheral, Register

PORTS = "ABCD"
# 8.4.1, 8.4.3, 8.4.4: port A and B wake with the debug pins in use.
MODER_RESET = {"A": 0xA800_0000, "B": 0x0000_0280}
OSPEEDR_RESET = {"A": 0x0C00_0000, "B": 0x0000_00C0}
PUPDR_RESET = {"A": 0x6400_0000, "B": 0x0000_0100}
# Registers that say what a pin is: bits of each pin, and the first pin.
SETTINGS = {"MODER": (2, 0), "OTYPER": (1, 0), "PUPDR": (2, 0), "AFRL": (4, 0), "AFRH": (4, 8)}


class Gpio(Peripheral):
    """One port of 16 pins."""

    write_sizes: ClassVar = (1, 2, 4)
    registers: ClassVar = (
        Register("MODER", 0x00),
        Register("OTYPER", 0x04, 0, 0xFFFF),
        Register("OSPEEDR", 0x08),
        Register("PUPDR", 0x0C),
        Register("IDR", 0x10, 0, 0),
        Register("ODR", 0x14, 0, 0xFFFF),
        Register("BSRR", 0x18, 0, readable=False),
        Register("AFRL", 0x20),
        Register("AFRH", 0x24),
    )

    def power_up(self) -> None:
        self.letter = self.name[-1]
        for name in SETTINGS:
            self.on_write(name, partial(self._set, name))

    def clear(self) -> None:
        self.value["MODER"] = MODER_RESET.get(self.letter, 0)
        self.value["OSPEEDR"] = OSPEEDR_RESET.get(self.letter, 0)
        self.value["PUPDR"] = PUPDR_RESET.get(self.letter, 0)

    def reset(self) -> None:
        super().reset()
        self._changed(range(16))

    # -- what a pin does, 8.3 --

    def _number(self, pin: str) -> int:
        return int(pin[2:])

    def mode(self, pin: str) -> int:
        """Return 0 input, 1 output, 2 alternate function, 3 analog (8.4.1)."""
        return self.value["MODER"] >> 2 * self._number(pin) & 3

    def function(self, pin: str) -> int:
        """Return the number of the alternate function (8.4.9, 8.4.10)."""
        number = self._number(pin)
        return self.value["AFRL" if number < 8 else "AFRH"] >> 4 * (number & 7) & 15

    def output(self, pin: str) -> int:
        return self.value["ODR"] >> self._number(pin) & 1

    def open_drain(self, pin: str) -> bool:
        return bool(self.value["OTYPER"] >> self._number(pin) & 1)

    def pull(self, pin: str) -> int | None:
        """Return what the resistor pulls the pin to (8.4.4), None if there is none."""
        return {1: 1, 2: 0}.get(self.value["PUPDR"] >> 2 * self._number(pin) & 3)

    def _changed(self, numbers: Iterable[int]) -> None:
        self.chip.pins.reconfigured([f"P{self.letter}{n}" for n in numbers])

    # -- registers, 8.4 --

    def _set(self, name: str, old: int, new: int) -> None:
        width, first = SETTINGS[name]
        field = (1 << width) - 1
        self._changed(first + n for n in range(min(16, 32 // width)) if (old ^ new) >> width * n & field)

    def read_IDR(self) -> int:
        """Analog pins read 0: their input stage is off (8.3.12). So do pins that float, which a chip would not say."""
        word = 0
        for n in range(16):
            pin = f"P{self.letter}{n}"
            if self.mode(pin) != ANALOG and self.chip.pins.level(pin) == 1:
                word |= 1 << n
        return word

    def write_ODR(self, old: int, new: int) -> None:
        for n in range(16):
            if (old ^ new) >> n & 1:
                pin = f"P{self.letter}{n}"
                self.chip.note(self.name, f"{pin} = {new >> n & 1}")
                self.chip.pins.refresh(pin)

    def write_BSRR(self, _old: int, new: int) -> None:
        """Setting wins where both halves name a pin (8.4.7)."""
        old = self.value["ODR"]
        self.value["BSRR"] = 0
        self.value["ODR"] = old & ~(new >> 16) | new & 0xFFFF
        self.write_ODR(old, self.value["ODR"])
