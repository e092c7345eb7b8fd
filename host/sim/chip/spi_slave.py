"""What the chips on an SPI bus have in common: a select pin, words of 16 bits in mode 1, and times to keep."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .pins import Level
from .timeline import cycles_of_ns

if TYPE_CHECKING:
    from .chip import Chip
    from .spi import Spi


class SpiSlave:
    """A chip with 16-bit words in mode 1 (CPOL 0, CPHA 1), selected by a low pin. Times in nanoseconds."""

    name = "slave"
    max_hz = 10_000_000
    select_to_clock_ns = 0.0
    deselected_ns = 0.0

    def __init__(self, chip: Chip, spi: str, select_pin: str) -> None:
        self.chip, self.bus = chip, chip.spis[spi]
        self.selected_at = self.deselected_at = self.clock_stopped_at = -1_000_000
        self.heard: list[int] = []  # the words since the select
        self.word_out = 0
        self.clocking = False
        self.clocked_wrong = False
        self.bus.slaves.append(self)
        chip.pins.watch(select_pin, self._select_changed)
        self.selected = chip.pins.level(select_pin) == 0

    # -- what a chip does --

    def answer(self) -> int:
        """Return the word to send, as it stands when the chip is selected."""
        raise NotImplementedError

    def respond(self, command: int) -> int | None:
        """Return what to send instead, once the first 5 bits of ``command`` have been heard; None: nothing else."""
        return None

    def take(self, word: int) -> None:
        """A whole word of 16 bits has been heard and the chip deselected."""
        raise NotImplementedError

    def clock_to_deselect_ns(self) -> float:
        """Return how long the chip stays selected after the last clock edge, at least."""
        return 0.0

    def wrong_length(self) -> None:
        """The chip was deselected after more or less than one word."""

    def complain(self, what: str, reason: str) -> None:
        self.chip.complain(self.name, what, reason)

    # -- the wires --

    def _late(self, since: int, least_ns: float) -> bool:
        """Tell whether less time has passed than the chip needs."""
        return self.chip.now - since < cycles_of_ns(least_ns)

    def _select_changed(self, level: Level) -> None:
        if level == 0 and not self.selected:
            self._selected()
        elif level != 0 and self.selected:
            self._deselected()

    def _selected(self) -> None:
        if self._late(self.deselected_at, self.deselected_ns):
            self.complain("select", f"high for less than {self.deselected_ns:g} ns between words")
        self.selected, self.selected_at = True, self.chip.now
        self.heard, self.clocked_wrong = [], False
        self.word_out = self.answer()

    def _deselected(self) -> None:
        self.selected, self.deselected_at = False, self.chip.now
        if self.clocking:
            self.complain("select", "high while a frame is under way")
            self.clocking = False
            self.wrong_length()
            return
        if self.heard and self._late(self.clock_stopped_at, self.clock_to_deselect_ns()):
            self.complain("select", f"high less than {self.clock_to_deselect_ns():.0f} ns after the last clock edge")
        if len(self.heard) == 1 and not self.clocked_wrong:
            self.take(self.heard[0])
        elif self.heard:
            self.wrong_length()

    def frame_begins(self, spi: Spi) -> None:
        if not self.selected:
            return
        self.clocking = True
        if spi.hertz > self.max_hz:
            self.complain("SCK", f"{spi.hertz:.0f} Hz, at most {self.max_hz} Hz")
        if self._late(self.selected_at, self.select_to_clock_ns):
            self.complain("select", f"low less than {self.select_to_clock_ns:g} ns before the clock")

    def exchange(self, spi: Spi, word: int) -> int:
        """Take a word and return one. In a wrong mode both sides miss the bits by one edge."""
        if spi.mode != 1:
            self.complain("SCK", f"mode {spi.mode}, the chip works in mode 1")
            self.clocked_wrong = True
        self.clocking, self.clock_stopped_at = False, self.chip.now
        self.heard.append(word)
        other = self.respond(word)
        sent = self.word_out if other is None else other
        return sent >> 1 if spi.mode != 1 else sent
