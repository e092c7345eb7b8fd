"""The joint's board with an STM32F405: timer, ADCs, SPI chips, CAN, watchdog, behind the interface of board_sim.py.

Everything is done on registers (chip*.py); of MicroPython it uses a timer's interrupt, the cause of the last reset and
the way into the ROM's loader. What stands for the chip is an address there, and a model of it on a computer.
"""

from shared.joint.layout import CurrentLoop
from shared.runtime import bound, const
from shared.wire.codec import Reply
from shared.wire.receive import Link

from .chip import (
    CORE,
    GPIOA_SET_16,
    GPIOD_SET_16,
    IWDG_KR_32,
    MOE,
    NVIC_PRIORITY_32,
    PERIPHERALS,
    SYSTEM,
    TIM1_BDTR_32,
    TS_CAL1_16,
    TS_CAL2_16,
    change,
    half,
    peek,
    poke,
)
from .chip_io import (
    BUS_CHANNEL,
    DRIVER_BIT,
    JOINT_BIT,
    clock_us,
    is_bus_off,
    receive,
    sample,
    selected_word,
    send,
)
from .chip_joint import millisecond, serve_bus
from .chip_setup import (
    MCU_CHANNEL,
    PERIOD,
    THERMISTOR_CHANNEL,
    enable_driver,
    set_filters,
    set_up_adcs,
    set_up_bridge_pins,
    set_up_can,
    set_up_pins,
    set_up_spis,
    set_up_timers,
    slow_watchdog,
    start_watchdog,
)
from .chip_step import bridge_on, interrupt, outputs_off, rotor_angle, write_compares
from .drv8323 import Drv8323
from .encoders import READ_ANGLE, angle_of
from .joint_control import Control

_OF_THE_CHIP = const(256)  # the "register" of the gate driver that stands for one of the microcontroller
_WAKE_MS = const(2)  # tREADY of the gate driver is at most 1
_TIM1_UP = const(25)  # position of its interrupt (RM0090 table 62)
_SECOND = const(0x10)  # priority 1: the system's clock comes before, USB and the rest wait
_MASK = const(0x3FFFFFFF)


class OnTheChip:
    """What only MicroPython on the chip can give."""

    chip = PERIPHERALS
    core = CORE
    system = SYSTEM

    def timer(self, period):
        """Return timer 1 of MicroPython: it brings the interrupt, its registers are set up after it."""
        import pyb

        return pyb.Timer(1, prescaler=0, period=period, mode=pyb.Timer.CENTER)

    def reset_cause(self):
        """Return the parameter reset_cause: 0 power, 2 reset pin, 3 software, 4 watchdog, 5 other."""
        import machine

        known = ((machine.PWRON_RESET, 0), (machine.HARD_RESET, 2), (machine.SOFT_RESET, 3), (machine.WDT_RESET, 4))
        cause = machine.reset_cause()
        for one, number in known:
            if cause == one:
                return number
        return 5

    def unique_id(self):
        """Return the chip's twelve bytes."""
        import machine

        return machine.unique_id()

    def random(self):
        """Return 30 bits of the chip's noise."""
        import pyb

        return pyb.rng()

    def reset(self, to_loader):
        """Start anew; in the ROM's loader if asked."""
        import machine

        if to_loader:
            machine.bootloader()
        machine.reset()


class Stm32F405Board:
    """All a joint's application needs of its board. ``on``: OnTheChip, or a model of it."""

    STEP_US = 100

    def __init__(self, on=None):
        self._on = on or OnTheChip()
        chip = self._chip = self._on.chip
        self.MCU_CAL1 = half(self._on.system, TS_CAL1_16)
        self.MCU_CAL2 = half(self._on.system, TS_CAL2_16)
        self.RESET_CAUSE = self._on.reset_cause()
        self._was_bus_off = 0
        self._bus_off = 0
        self._timer = self._on.timer(PERIOD)
        set_up_pins(chip)
        self.wrong = set_up_timers(chip) or set_up_adcs(chip) or set_up_spis(chip) or set_up_can(chip)
        set_up_bridge_pins(chip)
        self._driver = Drv8323(bound(selected_word, chip, GPIOA_SET_16, DRIVER_BIT))
        sample(chip, THERMISTOR_CHANNEL)
        # What an application calls at its rates goes straight to the chip
        self.can_send = bound(send, chip)
        self.can_receive = bound(receive, chip)
        self.ticks_us = bound(clock_us, chip)

    def start(self, control: Control, step=interrupt, *more):
        """Do a current step on the control's blocks at each update of the timer, and start the watchdog.

        From now on ``millisecond()`` reads sensors, does a motion tick and moves the bridge. ``step``: another
        interrupt, which also gets ``more`` (chip_probe.py).
        """
        c = control
        self.millisecond = bound(millisecond, self._chip, c.loop, c.settings, c.state, c.io, c.commission, c.run)
        start_watchdog(self._chip)
        self._timer.callback(bound(step, self._chip, c.loop, c.run, *more))
        shift = 8 * (_TIM1_UP & 3)
        change(self._on.core, NVIC_PRIORITY_32 + (_TIM1_UP >> 2), 0xFF << shift, _SECOND << shift)

    def pwm_off(self):
        """Open all six switches."""
        outputs_off(self._chip)

    def listen(self, control: Control, link: Link, frame, out):
        """Return what serves the bus: called without arguments, it returns what chip_joint.serve_bus does."""
        c = control
        reply = Reply()
        return bound(serve_bus, self._chip, frame, link, c.io, c.loop, c.settings, c.state, c.run, reply, out)

    def feed_watchdog(self):
        """Put the watchdog off; for self-test and update, a joint does it in ``millisecond``."""
        poke(self._chip, IWDG_KR_32, 0xAAAA)

    def quiet(self):
        """Stop for good what runs beside the main loop: bridge, gate driver, interrupt; slow the watchdog down."""
        outputs_off(self._chip)
        self._timer.callback(None)
        enable_driver(self._chip, 0)
        slow_watchdog(self._chip)

    def pwm_on(self, loop: CurrentLoop):
        """Let the bridge follow the compares; for the self-test, a joint does it in ``millisecond``."""
        write_compares(self._chip, loop)
        bridge_on(self._chip)

    def pwm_is_on(self):
        """Return 1 while the outputs may move; the timer's break input switches them off by itself."""
        return 1 if peek(self._chip, TIM1_BDTR_32) & MOE else 0

    def read_rotor(self):
        """Return the rotor encoder's angle, 0 .. 16383, or -1; before the interrupt runs."""
        return rotor_angle(self._chip)

    def read_joint(self):
        """Return the joint encoder's angle as it is now, 0 .. 16383, or -1: a word answers the one before."""
        word = 0
        for _ in range(2):
            word = selected_word(self._chip, GPIOD_SET_16, JOINT_BIT, READ_ANGLE)
        return angle_of(word)

    def read_bus(self):
        """Return the bus voltage in ADC counts."""
        return self._sample(BUS_CHANNEL)

    def read_thermistor(self):
        """Return the thermistor in ADC counts."""
        return self._sample(THERMISTOR_CHANNEL)

    def read_mcu(self):
        """Return the microcontroller's temperature sensor in ADC counts."""
        return self._sample(MCU_CHANNEL)

    def _sample(self, channel):
        found = sample(self._chip, channel)
        if found < 0:
            raise OSError(110)
        return found

    def driver_setup(self):
        """Wake the gate driver, write and read back its registers and the timer's.

        Return the driver's register that differs, 256 for one of the microcontroller, -1 if none.
        """
        enable_driver(self._chip, 1)
        start = self.ticks_us()
        while (self.ticks_us() - start) & _MASK < 1000 * _WAKE_MS:
            pass
        if self.wrong:
            return _OF_THE_CHIP
        return self._driver.setup()

    def driver_check(self):
        """Read the driver's registers again; return the first that differs, -1 if none."""
        return self._driver.check()

    def unique_id(self):
        """Return the chip's twelve bytes."""
        return self._on.unique_id()

    def random(self):
        """Return 30 bits of the chip's noise."""
        return self._on.random()

    def bus_off(self):
        """Return how often the CAN controller was bus-off, as far as the main loop saw."""
        off = is_bus_off(self._chip)
        if off and not self._was_bus_off:
            self._bus_off += 1
        self._was_bus_off = off
        return self._bus_off

    def can_filters(self, pairs, count):
        """Set the hardware filters from (identifier, mask) pairs, two to a bank; banks not needed repeat another."""
        set_filters(self._chip, pairs, count)

    def reset(self, to_loader):
        """Start the board anew; in the ROM's loader if asked."""
        self._on.reset(to_loader)
