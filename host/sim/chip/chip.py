"""The whole chip: its memory map, its time, its pins, what it complained of and what happened when."""

from __future__ import annotations

from collections.abc import Callable

from .adc import Adc, AdcCommon
from .bxcan import BxCan
from .counter import Counter
from .factory import Factory
from .flash import Flash
from .gpio import PORTS, Gpio
from .iwdg import Iwdg
from .nvic import Nvic
from .pins import Pins
from .rcc import Rcc
from .registers import Complaint, Peripheral
from .spi import Spi
from .tim import Tim
from .timeline import Due, Timeline
from .view import View

Analog = Callable[[int], float]
PAGE = 0x100


class Chip:
    """An STM32F405 with 1 MiB of flash, its clocks as start-up code leaves them: 168 MHz, APB1 42 MHz, APB2 84 MHz.

    ``lsi_hz`` is the true rate of the internal low-speed oscillator (17 to 47 kHz, DS8626). ``analog[name]`` is a
    function of the cycle that gives counts of 0 to 4095; names are pins ("PC0") and "TEMPERATURE".

    ``complaints`` holds what the manual forbids and the driver did, ``doubts`` where the driver relies on something the
    manual leaves open, ``events`` everything that happened as (cycle, source, what), except from ``muted`` sources.
    """

    def __init__(self, lsi_hz: float = 32_000) -> None:
        self.time = Timeline()
        self.lsi_hz = lsi_hz
        self.complaints: list[Complaint] = []
        self.doubts: list[Complaint] = []
        self.counts: dict[tuple[str, str, str], int] = {}
        self.events: list[tuple[int, str, str]] = []
        self.muted: set[str] = set()
        self.analog: dict[str, Analog] = {}
        self.resets: list[tuple[int, str]] = []
        self._port_of: dict[str, Gpio] = {}
        self._build()
        self.pins = Pins(self)

    def _build(self) -> None:
        """Make the blocks. Base addresses: RM0090 table 1."""
        self.rcc = Rcc(self, "RCC", 0x4002_3800)
        self.ports = {
            letter: Gpio(self, f"GPIO{letter}", 0x4002_0000 + 0x400 * n, clock=("AHB1ENR", n))
            for n, letter in enumerate(PORTS)
        }
        self.nvic = Nvic(self, "NVIC", 0xE000_E100, 0xC00)
        self.tim1 = Tim(self, "TIM1", 0x4001_0000, clock=("APB2ENR", 0))
        self.tim5 = Counter(self, "TIM5", 0x4000_0C00, clock=("APB1ENR", 3))
        self.adc_common = AdcCommon(self, "ADC_COMMON", 0x4001_2300, 0x100, clock=("APB2ENR", 8))
        self.adcs = {
            f"ADC{n}": Adc(self, f"ADC{n}", 0x4001_2000 + 0x100 * (n - 1), 0x100, clock=("APB2ENR", 7 + n))
            for n in (1, 2, 3)
        }
        self.spis = {
            "SPI1": Spi(self, "SPI1", 0x4001_3000, clock=("APB2ENR", 12)),
            "SPI3": Spi(self, "SPI3", 0x4000_3C00, clock=("APB1ENR", 15)),
        }
        self.can1 = BxCan(self, "CAN1", 0x4000_6400, clock=("APB1ENR", 25))
        self.iwdg = Iwdg(self, "IWDG", 0x4000_3000)
        self.flash = Flash(self, "FLASH", 0x4002_3C00)
        self.factory = Factory(self, "factory", 0x1FFF_7A00, 0x100)
        self.blocks: list[Peripheral] = [
            self.rcc, *self.ports.values(), self.nvic, self.tim1, self.tim5, self.adc_common, *self.adcs.values(),
            *self.spis.values(), self.can1, self.iwdg, self.flash, self.factory,
        ]  # fmt: skip
        self._pages = {
            page: block
            for block in self.blocks
            for page in range(block.base // PAGE, (block.base + block.size - 1) // PAGE + 1)
        }

    # -- the bus --

    def _find(self, address: int, size: int) -> Peripheral | None:
        if size not in (1, 2, 4):
            raise ValueError(f"access of {size} bytes; a bus access has 1, 2 or 4")
        block = self._pages.get(address // PAGE)
        if block is None:
            self.complain("bus", f"0x{address:08X}", "nothing modelled at this address")
        return block

    def read(self, address: int, size: int = 4) -> int:
        """Read 1, 2 or 4 bytes. Flash memory can be read too. No time passes."""
        if self.flash.holds(address):
            return self.flash.load(address, size)
        block = self._find(address, size)
        return block.read(address - block.base, size) if block else 0

    def write(self, address: int, value: int, size: int = 4) -> None:
        """Write 1, 2 or 4 bytes; to flash memory as far as the flash interface lets one. No time passes."""
        if self.flash.holds(address):
            self.flash.program(address, value, size)
            return
        block = self._find(address, size)
        if block:
            block.write(address - block.base, value, size)

    def view(self, base: int, size: int = 4) -> View:
        """Return registers from ``base`` on as an array of ``size``-byte words; each access takes 4 cycles."""
        return View(self, base, size, 4)

    # -- time --

    @property
    def now(self) -> int:
        """The cycle of the 168 MHz clock that it is."""
        return self.time.now

    def advance(self, cycles: int) -> None:
        """Let time pass."""
        self.time.advance(cycles)

    def at(self, when: int, act: Callable[[], None]) -> Due:
        """Have something done in a cycle to come."""
        return self.time.at(when, act)

    def note(self, source: str, what: str) -> None:
        """Record that something happened now."""
        if source not in self.muted:
            self.events.append((self.now, source, what))

    # -- complaints --

    def _tell(self, told: list[Complaint], peripheral: str, register: str, reason: str) -> None:
        key = peripheral, register, reason
        self.counts[key] = self.counts.get(key, 0) + 1
        if self.counts[key] == 1:
            told.append(Complaint(self.now, *key))

    def complain(self, peripheral: str, register: str, reason: str) -> None:
        """Record something the manual forbids. The same once more is only counted."""
        self._tell(self.complaints, peripheral, register, reason)

    def doubt(self, peripheral: str, register: str, reason: str) -> None:
        """Record that the driver relies on a reading of the manual that is open."""
        self._tell(self.doubts, peripheral, register, reason)

    # -- inside --

    def port(self, pin: str) -> Gpio:
        """Return the port of a pin named like "PA8"."""
        port = self._port_of.get(pin)
        if port is not None:
            return port
        if pin[:1] != "P" or pin[1:2] not in self.ports or not pin[2:].isdigit() or int(pin[2:]) > 15:
            raise ValueError(f"pin {pin!r}: pins are named P, A to D, 0 to 15, as PA8")
        self._port_of[pin] = self.ports[pin[1]]
        return self.ports[pin[1]]

    def trigger_adcs(self) -> None:
        """Let timer 1's TRGO rise; ADCs that wait for it see the edge."""
        for adc in self.adcs.values():
            adc.edge()

    def pending_interrupts(self) -> list[int]:
        """Return the exceptions that wait and may run, most urgent first (exception number = interrupt + 16)."""
        return self.nvic.waiting()

    def reset(self, cause: str) -> None:
        """Reset all blocks; ``cause`` is power, pin, software or iwdg (7.1, 7.3.21)."""
        self.note("RCC", f"reset: {cause}")
        self.resets.append((self.now, cause))
        for block in self.blocks:
            block.reset()
        self.rcc.note_reset(cause)
