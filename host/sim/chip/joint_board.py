"""The joint's board round the model of the chip, with MicroPython's part in it: whole firmware runs on this in CPython.

Wiring as docs/joint-board.md assumes it; written from that page and the data sheets, knows no line of the firmware.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .as5047p import As5047p
from .bridge import HalfBridges
from .chip import Chip
from .drv8323 import Drv8323s
from .view import View

TIM1, RCC = 0x4001_0000, 0x4002_3800
CR1, DIER, SR, EGR, PSC, ARR, RCR, BDTR = (TIM1 + n for n in (0x00, 0x0C, 0x10, 0x14, 0x28, 0x2C, 0x30, 0x44))
CEN, UPDATE, CENTRE = 1, 1, 0x20
POLLED = {0x4001_3008, 0x4000_3C08, 0x4001_2000}  # SR of SPI 1, SPI 3 and ADC 1: they change by events only
TIM1_UP = 25  # position of the interrupt, RM0090 table 62
EXCEPTION = 16 + TIM1_UP
SHUNTS = ("PC0", "PC1", "PC2")
SHUNT_CHANNELS = {("ADC1", 10): "a", ("ADC2", 11): "b", ("ADC3", 12): "c"}
HALF_BRIDGES = {"a": ("PA8", "PB13"), "b": ("PA9", "PB14"), "c": ("PA10", "PB15")}
CYCLES_PER_MS = 168_000
ENTRY_CYCLES = 1200  # some 600 instructions of entry, HAL and MicroPython before the callback (test_image_boots.py)
EXIT_CYCLES = 60
BOOT_CYCLES = 10 * CYCLES_PER_MS  # from a reset to the first line of Python: assumed, and at least that
LOOP_CYCLES = 2000  # of the main loop's body beside its registers


class Restart(BaseException):
    """The chip was reset: what ran on it runs no more. Not an Exception, for no program can catch a reset."""


class Registers:
    """A part of the memory map as words and as half words, each access interruptible."""

    def __init__(self, board: JointBoard, base: int) -> None:
        self.words = InterruptibleView(board, base, 4)
        self.halves = InterruptibleView(board, base, 2)


class InterruptibleView(View):
    """Registers as an array; before an access interrupts that wait are served, as between two instructions.

    A status register read over and over is looked at only when something can have happened; that changes no figure.
    """

    def __init__(self, board: JointBoard, base: int, size: int) -> None:
        super().__init__(board.model, base, size, board.access_cycles)
        self.board, self.time = board, board.model.time
        self._index, self._value, self._quiet_until = -1, 0, -1

    def __getitem__(self, index: int) -> int:
        if index == self._index and self.time.now + self.cost_cycles < self._quiet_until:
            self.time.now += self.cost_cycles
            return self._value
        address = self.base + index * self.size
        self.board.spend(self.cost_cycles)
        self._value = self.chip.read(address, self.size)
        if address in POLLED and not self.board.may_interrupt():
            due = self.time.next_due()
            self._index, self._quiet_until = index, self.time.now + 1000 if due is None else due
        else:
            self._index = -1
        return self._value

    def __setitem__(self, index: int, value: int) -> None:
        self._index = -1
        self.board.spend(self.cost_cycles)
        self.chip.write(self.base + index * self.size, value, self.size)


class PortTimer:
    """Timer 1 as MicroPython's stm32 port leaves it when ``pyb.Timer(1, mode=CENTER)`` is made, and its callback."""

    def __init__(self, board: JointBoard, period: int) -> None:
        self.board = board
        self.handler: Callable[[Any], Any] | None = None
        self.uncaught: list[Exception] = []
        chip = board.model
        chip.write(RCC + 0x44, chip.read(RCC + 0x44) | 1)
        board.spend(4)
        for register, value in ((CR1, CENTRE), (ARR, period), (PSC, 0), (RCR, 0), (EGR, UPDATE), (BDTR, 0)):
            chip.write(register, value)
            board.spend(4)
        chip.write(CR1, chip.read(CR1) | 0x80)
        chip.write(CR1, chip.read(CR1) | CEN)
        board.spend(1000)  # back to Python; the counter runs meanwhile

    def callback(self, handler: Callable[[Any], Any]) -> None:
        """Let ``handler(timer)`` be called at each update event."""
        self.handler = handler
        chip = self.board.model
        chip.write(DIER, chip.read(DIER) & ~UPDATE)
        chip.write(SR, ~UPDATE & 0xFFFF)
        chip.write(DIER, chip.read(DIER) | UPDATE)
        chip.write(CR1, chip.read(CR1) | CEN)
        chip.nvic.write(0, 1 << TIM1_UP, 4)

    def interrupt(self) -> None:
        """Do what the port's handler does: clear the flag, call; an exception ends it for good."""
        chip = self.board.model
        if not chip.read(SR) & chip.read(DIER) & UPDATE:
            return
        chip.write(SR, ~UPDATE & 0xFFFF)
        if self.handler is None:
            return
        try:
            self.handler(self)
        except Exception as error:
            self.uncaught.append(error)
            self.handler = None
            chip.write(DIER, chip.read(DIER) & ~UPDATE)


class JointBoard:
    """What firmware/board_stm32f405.py takes for the chip: ``chip``, ``core``, ``system``, ``timer`` and the rest.

    ``shunts`` (counts of a, b, c), ``bus``, ``thermistor``, ``mcu`` (counts), ``rotor_angle`` and ``joint_angle`` (0
    to 16383) are what the sensors see. Time passes in accesses to registers (``access_cycles`` each), in ``spend`` and
    in ``run``. ``entry_cycles`` lie between an update event and the call of the handler; ``entries`` and ``exits`` are
    the cycles at which handlers began and ended.
    """

    def __init__(
        self, entry_cycles: int = ENTRY_CYCLES, access_cycles: int = 4, loop_cycles: int = LOOP_CYCLES, **chip: Any
    ) -> None:
        self.model = Chip(**chip)
        self.entry_cycles, self.access_cycles, self.loop_cycles = entry_cycles, access_cycles, loop_cycles
        self.shunts: list[Any] = [2048, 2048, 2048]
        self.bus, self.thermistor, self.mcu = 2291, 2048, 980
        self.rotor_angle, self.joint_angle = 1234, 777
        self.handling = False
        self.entries: list[int] = []
        self.exits: list[int] = []
        self.to_loader = False
        self._timer: PortTimer | None = None
        self._resets = 0
        self.chip = Registers(self, 0x4000_0000)
        self.core = Registers(self, 0xE000_E000)
        self.system = Registers(self, 0x1FFF_7A00)
        self._wire()

    def _wire(self) -> None:
        model = self.model
        model.muted |= {"NVIC", "TIM1", "TIM1 outputs", "ADC1", "ADC2", "ADC3", "SPI1", "SPI3", "IWDG"}
        for phase, pin in enumerate(SHUNTS):
            model.analog[pin] = lambda cycle, phase=phase: self.shunt_counts(phase, cycle)  # type: ignore[misc]
        model.analog["PC3"] = lambda cycle: self.bus
        model.analog["PA4"] = lambda cycle: self.thermistor
        model.analog["TEMPERATURE"] = lambda cycle: self.mcu
        self.rotor = As5047p(model, "SPI1", "PC6", lambda cycle: self.rotor_angle, "rotor encoder")
        self.joint = As5047p(model, "SPI3", "PD2", lambda cycle: self.joint_angle, "joint encoder")
        self.driver = Drv8323s(model, "SPI3", "PA15", "PC4", "PB12")
        self.bridges = HalfBridges(model, HALF_BRIDGES)
        self.can = model.can1.wire

    def shunt_counts(self, phase: int, cycle: int) -> float:
        """Return what a phase's amplifier gives; ``shunts`` holds numbers or functions of the cycle."""
        value = self.shunts[phase]
        return float(value(cycle) if callable(value) else value)

    # -- what MicroPython gives --

    def timer(self, period: int) -> PortTimer:
        """Return timer 1."""
        self._timer = PortTimer(self, period)
        return self._timer

    def reset_cause(self) -> int:
        """Return 0 power, 2 reset pin, 3 software, 4 watchdog, 5 other, by the flags in RCC_CSR (7.3.21)."""
        flags = self.model.read(RCC + 0x74)
        for bit, number in ((29, 4), (28, 3), (27, 0), (26, 2)):
            if flags >> bit & 1:
                return number
        return 5

    def random(self) -> int:
        """Return 30 bits, always the same: a model has no noise."""
        return 0x1234567

    def unique_id(self) -> bytes:
        """Return the chip's twelve bytes."""
        return b"".join(self.model.read(0x1FFF_7A10 + 4 * n).to_bytes(4, "little") for n in range(3))

    def reset(self, to_loader: bool) -> None:
        """Reset the chip; does not return."""
        self.to_loader = bool(to_loader)
        self.model.reset("software")
        self._restart()

    # -- time --

    def spend(self, cycles: int) -> None:
        """Let the processor work for some cycles; interrupts are served first, and Restart raised after a reset."""
        self.model.time.advance(cycles)
        if len(self.model.resets) > self._resets:
            self._restart()
        if self.may_interrupt():
            self._serve()

    def may_interrupt(self) -> bool:
        """Tell whether an interrupt waits that nothing holds back."""
        return not self.handling and bool(self.model.nvic.pending)

    def _restart(self) -> None:
        self._resets = len(self.model.resets)
        self._timer, self.handling = None, False
        self.model.advance(BOOT_CYCLES)
        raise Restart(self.model.resets[-1][1])

    def _serve(self) -> None:
        while waiting := self.model.pending_interrupts():
            if waiting[0] != EXCEPTION or self._timer is None:
                raise AssertionError(f"exception {waiting[0]} has no handler here")
            self.handling = True
            self.model.nvic.enter(EXCEPTION)
            self.spend(self.entry_cycles)
            self.entries.append(self.model.now)
            self._timer.interrupt()
            self.exits.append(self.model.now)
            self.spend(EXIT_CYCLES)
            self.model.nvic.leave()
            self.handling = False

    def run(self, milliseconds: float, body: Callable[[], Any] | None = None) -> None:
        """Call the main loop's body for a time; without one the loop hangs, and only interrupts run."""
        end = self.model.now + round(milliseconds * CYCLES_PER_MS)
        while self.model.now < end:
            if body is not None:
                body()
            self.work(self.loop_cycles)

    def work(self, cycles: int) -> None:
        """Let the processor work without touching a register; what interrupts it comes on top."""
        time = self.model.time
        while cycles > 0:
            due = time.next_due()
            step = cycles if due is None else min(cycles, max(due - time.now, 1))
            cycles -= step
            self.spend(step)

    # -- what a scope shows --

    @property
    def gates(self) -> str:
        """Return the six gates as levels of high and low side of a, b, c: 1, 0, or - for a pin nobody drives."""
        levels = (self.model.pins.level(pin) for pair in HALF_BRIDGES.values() for pin in pair)
        return "".join("-" if level is None else str(level) for level in levels)

    @property
    def outputs_on(self) -> bool:
        """Tell whether the timer's outputs may move (MOE)."""
        return bool(self.model.tim1.value["BDTR"] & 0x8000)
