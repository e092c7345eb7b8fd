"""The joint's board with an STM32F405: timer, ADCs, SPI chips, CAN, watchdog, behind the interface of board_sim.py.

Pins are assumed, because the wiring is not published: TIM1 on PA8..10 and PB13..15, shunts on PC0..2, bus PC3,
thermistor PA4, rotor encoder on SPI 1, which only the interrupt reads; gate driver and joint encoder on SPI 3, which
only the main loop uses; CAN 1 on PB8 and PB9.
"""

import time

import machine
import pyb
import stm
from machine import SPI, Pin

from shared.joint.layout import F_DUTY_A, F_DUTY_B, F_DUTY_C, F_RAW_A, F_RAW_B, F_RAW_C
from shared.runtime import const

from .drv8323 import Drv8323
from .encoders import MagneticEncoder
from .registers import JDR_A, JDR_B, JDR_C, TS_CAL1, TS_CAL2, Registers

PERIOD = const(4200)  # compare counts: 168 MHz / (2 x 20 kHz)
_DEAD_TICKS = const(17)  # 100 ns
_MASK = const(0x3FFFFFFF)
_WATCHDOG_MS = const(200)
_BUS_CHANNEL = const(13)
_THERMISTOR_CHANNEL = const(4)
_MCU_CHANNEL = const(16)
_FIFO_ORDER = const(0)  # even banks: set-points and SYNC share a FIFO, because their order counts
_FIFO_SERVICE = const(1)
_AF_TIM1 = const(1)
_BANKS = ((0, 1), (2, 3), (4, 4), (5, 6))  # e-stop, SYNC; requests; set-points; own heartbeat and reply
# machine.reset_cause() to the parameter reset_cause: 0 power, 2 reset pin, 3 software, 4 watchdog, 5 other
_CAUSES = ((machine.PWRON_RESET, 0), (machine.HARD_RESET, 2), (machine.SOFT_RESET, 3), (machine.WDT_RESET, 4))


class Stm32F405Board:
    """All a joint's application needs of its board."""

    STEP_US = 100

    def __init__(self):
        self._registers = Registers(stm)
        self.MCU_CAL1 = self._registers.factory(TS_CAL1)
        self.MCU_CAL2 = self._registers.factory(TS_CAL2)
        self.RESET_CAUSE = reset_cause(machine.reset_cause())
        self._handler = _nothing
        self._feed = _nothing
        self._stale = 0
        self._can = pyb.CAN(1, pyb.CAN.NORMAL, prescaler=3, bs1=10, bs2=3, auto_restart=True)  # 1 Mbit at 42 MHz
        self._bytes = bytearray(8)
        self._received = [0, False, False, 0, memoryview(self._bytes)]
        self._send = bytearray(8)
        view = memoryview(self._send)
        self._views = [view[:length] for length in range(9)]
        self._was_bus_off = False
        self._bus_off = 0
        self.can_length = 0
        self._rotor = MagneticEncoder(SPI(1, baudrate=5000000, polarity=0, phase=1), Pin("PB12", Pin.OUT, value=1))
        slow = SPI(3, baudrate=5000000, polarity=0, phase=1)
        self._driver = Drv8323(slow, Pin("PA15", Pin.OUT, value=1))
        self._joint = MagneticEncoder(slow, Pin("PD2", Pin.OUT, value=1))
        self._timer = pyb.Timer(1, prescaler=0, period=PERIOD, mode=pyb.Timer.CENTER)
        self._enable = Pin("PC4", Pin.OUT, value=0)
        self._fault = Pin("PC5", Pin.IN, Pin.PULL_UP)
        self._setup()

    def _setup(self):
        """Timer first, with its outputs off, then the pins that carry them."""
        self._registers.setup_timer(PERIOD, _DEAD_TICKS)
        self._registers.setup_adc()
        for name in ("PC0", "PC1", "PC2", "PC3", "PA4"):
            Pin(name, Pin.ANALOG)
        for name in ("PA8", "PA9", "PA10", "PB13", "PB14", "PB15"):
            Pin(name, Pin.ALT, alt=_AF_TIM1)

    def start(self, handler):
        """Call ``handler`` for every current step from now on, and start the watchdog."""
        self._handler = handler
        self._feed = machine.WDT(timeout=_WATCHDOG_MS).feed
        self._timer.callback(self._tick)

    def _tick(self, timer):
        self._handler()

    def pwm_on(self):
        """Let the bridge follow the compare registers."""
        self._registers.bridge_on()

    def pwm_off(self):
        """Open all six switches."""
        self._registers.bridge_off()

    def pwm_write(self, foc):
        """Set the compare registers from F_DUTY_*."""
        self._registers.compare(foc[F_DUTY_A], foc[F_DUTY_B], foc[F_DUTY_C])

    def read_currents(self, foc):
        """Write the last conversions of the three shunt amplifiers to F_RAW_*; OSError if the trigger has stopped."""
        r = self._registers
        self._stale += 1
        if r.sampled():
            self._stale = 0
        if self._stale > 3:
            raise OSError(5)
        foc[F_RAW_A] = r.sample(JDR_A)
        foc[F_RAW_B] = r.sample(JDR_B)
        foc[F_RAW_C] = r.sample(JDR_C)

    def read_rotor(self):
        """Return the rotor encoder's angle, 0 .. 16383, or -1 if the reading failed its check."""
        return self._rotor.read()

    def read_joint(self):
        """Return the joint encoder's angle, 0 .. 16383, or -1."""
        return self._joint.read()

    def read_bus(self):
        """Return the bus voltage in ADC counts."""
        return self._registers.convert(_BUS_CHANNEL)

    def read_thermistor(self):
        """Return the thermistor in ADC counts."""
        return self._registers.convert(_THERMISTOR_CHANNEL)

    def read_mcu(self):
        """Return the microcontroller's temperature sensor in ADC counts."""
        return self._registers.convert(_MCU_CHANNEL)

    def driver_setup(self):
        """Wake the gate driver, write and read back its registers and the timer's.

        Return the driver's register that differs, 256 for one of the microcontroller, -1 if none.
        """
        self._enable(1)
        pyb.delay(2)  # ms; tREADY is at most 1
        if self._registers.wrong:
            return 256
        return self._driver.setup()

    def driver_check(self):
        """Read the driver's registers again; return the first that differs, -1 if none."""
        return self._driver.check()

    def driver_fault(self):
        """Return both fault registers while the gate driver pulls nFAULT low, else 0."""
        if self._fault():
            return 0
        self.pwm_off()
        return self._driver.faults() or 1

    def ticks_us(self):
        """Return microseconds modulo 2^30."""
        return time.ticks_us() & _MASK  # pyright: ignore[reportAttributeAccessIssue]: not in CPython's time

    def ticks_ms(self):
        """Return milliseconds modulo 2^30."""
        return time.ticks_ms() & _MASK  # pyright: ignore[reportAttributeAccessIssue]

    def unique_id(self):
        """Return the chip's twelve bytes."""
        return machine.unique_id()

    def bus_off(self):
        """Return how often the CAN controller was bus-off, as far as the main loop saw."""
        off = self._registers.can_bus_off()
        if off and not self._was_bus_off:
            self._bus_off += 1
        self._was_bus_off = off
        return self._bus_off

    def can_filters(self, pairs, count):
        """Set the hardware filters from (identifier, mask) pairs, two to a bank; banks not needed repeat another."""
        for bank in range(4):
            used = bank if 2 * bank < count else bank - 2
            first = 2 * _BANKS[used][0]
            second = 2 * _BANKS[used][1]
            words = (pairs[first], pairs[first + 1], pairs[second], pairs[second + 1])
            self._can.setfilter(bank, pyb.CAN.MASK16, bank & 1, words)

    def can_receive(self, frame):
        """Copy the oldest frame into ``frame`` and its length to ``can_length``; return its identifier, or -1."""
        if self._can.any(_FIFO_ORDER):
            self._can.recv(_FIFO_ORDER, self._received, timeout=0)
        elif self._can.any(_FIFO_SERVICE):
            self._can.recv(_FIFO_SERVICE, self._received, timeout=0)
        else:
            return -1
        data = self._bytes
        for word in range(4):
            frame[word] = data[2 * word] | data[2 * word + 1] << 8
        self.can_length = len(self._received[4])
        return self._received[0]

    def can_send(self, identifier, frame, length):
        """Send a frame; return 0 if all three mailboxes are full."""
        if not self._registers.can_free():
            return 0
        data = self._send
        for word in range(4):
            data[2 * word] = frame[word] & 0xFF
            data[2 * word + 1] = frame[word] >> 8
        self._can.send(self._views[length], identifier)
        return 1

    def feed_watchdog(self):
        """Put the watchdog off."""
        self._feed()

    def reset(self, to_loader):
        """Start the board anew; to the ROM's loader if asked."""
        if to_loader:
            machine.bootloader()
        machine.reset()


def reset_cause(cause):
    """Return the parameter's number for MicroPython's."""
    for known, number in _CAUSES:
        if cause == known:
            return number
    return 5


def _nothing():
    """Stands for what ``start`` brings."""
