"""Memory-mapped registers: which bits software may write, in which sizes, and complaints about the rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from .chip import Chip

ALL = 0xFFFF_FFFF


@dataclass(frozen=True)
class Complaint:
    """What the manual forbids or leaves open, and a driver did. The same one again only counts up."""

    cycle: int
    peripheral: str
    register: str
    reason: str

    def __str__(self) -> str:
        return f"cycle {self.cycle}: {self.peripheral} {self.register}: {self.reason}"


@dataclass(frozen=True)
class Register:
    """One register: ``write`` are the modelled bits that software may set, ``clear`` those cleared by writing 0.

    ``back`` are read-only bits that the hardware changes: a word written back as it was read is no mistake.
    """

    name: str
    offset: int
    reset: int = 0
    write: int = ALL
    clear: int = 0
    readable: bool = True
    back: int = 0


class Peripheral:
    """A block of registers. Subclasses give the table and may define ``read_NAME()`` and ``write_NAME(old, new)``."""

    registers: ClassVar[tuple[Register, ...]] = ()
    read_sizes: ClassVar[tuple[int, ...]] = (1, 2, 4)
    write_sizes: ClassVar[tuple[int, ...]] = (2, 4)

    def __init__(self, chip: Chip, name: str, base: int, size: int = 0x400, clock: tuple[str, int] | None = None):
        self.chip, self.name, self.base, self.size, self.clock = chip, name, base, size, clock
        self.by_offset = {register.offset: register for register in self.registers}
        self.value = {register.name: register.reset for register in self.registers}
        self._readers: dict[int, Callable[[], int]] = {}
        self._writers: dict[int, Callable[[int, int], None]] = {}
        for register in self.registers:
            if reader := getattr(self, f"read_{register.name}", None):
                self._readers[register.offset] = reader
            if writer := getattr(self, f"write_{register.name}", None):
                self._writers[register.offset] = writer
        self.power_up()
        self.clear()

    def power_up(self) -> None:
        """Set up what the block has besides registers."""

    def clear(self) -> None:
        """Begin anew, at power-on and at a reset: nothing is under way."""

    def on_write(self, register: str, act: Callable[[int, int], None]) -> None:
        """Have ``act(old, new)`` called when a register was written, of several that are alike."""
        self._writers[next(one.offset for one in self.registers if one.name == register)] = act

    def reset(self) -> None:
        """Put every register to its reset value, and begin anew."""
        self.value.update({register.name: register.reset for register in self.registers})
        self.clear()

    def complain(self, register: str, reason: str) -> None:
        self.chip.complain(self.name, register, reason)

    def doubt(self, register: str, reason: str) -> None:
        """Note that the driver relies on something the manual leaves open."""
        self.chip.doubt(self.name, register, reason)

    # -- access from the bus --

    def clocked(self, register: str) -> bool:
        """Tell whether RCC clocks this block; say so if not."""
        if self.clock is None:
            return True
        why = self.chip.rcc.why_not_clocked(*self.clock)
        if why:
            self.complain(register, why)
        return not why

    def find(self, offset: int, size: int, sizes: tuple[int, ...], verb: str) -> Register | None:
        """Return the register an access hits, None with a complaint if the access is not allowed."""
        register = self.by_offset.get(offset & ~3)
        label = register.name if register else f"+0x{offset:X}"
        if not self.clocked(label):
            return None
        if register is None:
            self.complain(label, f"{verb} where there is no register")
        elif size not in sizes:
            self.complain(label, f"{verb} of {8 * size} bits is not allowed here")
        elif offset % size:
            self.complain(label, f"{verb} of {8 * size} bits at an odd place")
        else:
            return register
        return None

    def read(self, offset: int, size: int) -> int:
        register = self.find(offset, size, self.read_sizes, "read")
        if register is None:
            return 0
        if not register.readable:
            self.complain(register.name, "read of a write-only register")
            return 0
        reader = self._readers.get(register.offset)
        whole = reader() if reader else self.value[register.name]
        return (whole >> 8 * (offset & 3)) & ((1 << 8 * size) - 1)

    def write(self, offset: int, value: int, size: int) -> None:
        register = self.find(offset, size, self.write_sizes, "write")
        if register is None:
            return
        shift, part = 8 * (offset & 3), (1 << 8 * size) - 1
        old = self.value[register.name]
        rest = (old | register.clear) & ~(part << shift) & ALL
        whole = rest | (value & part) << shift
        forbidden = whole & ~register.write & ~register.clear & ~register.back & ~old
        if forbidden and not register.clear:
            self.complain(register.name, f"write of bits that are reserved, read-only or not modelled: 0x{forbidden:X}")
        keep = ~register.write & ~register.clear
        new = old & keep | whole & register.write | old & whole & register.clear
        self.value[register.name] = new
        writer = self._writers.get(register.offset)
        if writer:
            writer(old, new)

    def refuse(self, register: str, old: int, reason: str) -> None:
        """Take a write back and say why."""
        self.value[register] = old
        self.complain(register, reason)
