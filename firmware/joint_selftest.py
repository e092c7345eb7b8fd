"""What only silicon can tell, measured on the joint's own board with the bridge off: times, samples, registers.

``measure(board)`` takes a board of either kind and returns a dictionary of integers, for the host to judge and print.
"""

import time
from array import array

from shared.joint.calibration import set_commutation
from shared.joint.current import current_repair, current_reset, current_step
from shared.joint.layout import F_RAW_A, F_ROTOR
from shared.runtime import const

from .joint_control import Control
from .joint_store import Parameters

STEPS = const(2000)
CALLS = const(500)
_TIMEOUT_MS = const(2000)


class Probe:
    """An interrupt handler that does what a current step does and notes when it was called and how long it took."""

    def __init__(self, board):
        self.board = board
        self.control = Control(board)
        Parameters(self.control, "").defaults()
        set_commutation(self.control.foc, self.control.cfg)
        current_reset(self.control.foc, 0)
        self.count = 0
        self.failed = 0
        self.bad_rotor = 0
        self.last = -1
        self.shortest = 1000000
        self.longest = 0
        self.step_most = 0
        self.low = array("i", [4095, 4095, 4095])
        self.high = array("i", [0, 0, 0])

    def step(self):
        """Be called once per current step."""
        try:
            self._step()
        except Exception:
            self.failed += 1
        self.count += 1

    def _step(self):
        now = self.board.ticks_us()
        if self.last >= 0:
            gap = (now - self.last) & 0x3FFFFFFF
            self.shortest = min(self.shortest, gap)
            self.longest = max(self.longest, gap)
        self.last = now
        foc = self.control.foc
        self.board.read_currents(foc)
        rotor = self.board.read_rotor()
        if rotor < 0:
            self.bad_rotor += 1
            rotor = foc[F_ROTOR]
        code = current_step(rotor, 0, foc)
        if code:
            current_repair(code, rotor, 0, foc)
        self.board.pwm_write(foc)
        for phase in range(3):
            self.low[phase] = min(self.low[phase], foc[F_RAW_A + phase])
            self.high[phase] = max(self.high[phase], foc[F_RAW_A + phase])
        self.step_most = max(self.step_most, (self.board.ticks_us() - now) & 0x3FFFFFFF)


def measure(board):
    """Return the figures; the bridge stays off. The watchdog that ``start`` brings is fed until the end."""
    board.pwm_off()
    driver = board.driver_setup()
    probe = Probe(board)
    board.start(probe.step)
    began = board.ticks_ms()
    while probe.count < STEPS and (board.ticks_ms() - began) & 0x3FFFFFFF < _TIMEOUT_MS:
        board.feed_watchdog()
    took = (board.ticks_ms() - began) & 0x3FFFFFFF
    board.pwm_off()
    figures = {
        "driver": driver,
        "driver_fault": board.driver_fault(),
        "steps": probe.count,
        "took_ms": took,
        "failed": probe.failed,
        "bad_rotor": probe.bad_rotor,
        "gap_least_us": probe.shortest,
        "gap_most_us": probe.longest,
        "handler_most_us": probe.step_most,
        "raw_low": list(probe.low),
        "raw_high": list(probe.high),
        "bus": board.read_bus(),
        "thermistor": board.read_thermistor(),
        "mcu": board.read_mcu(),
        "joint": board.read_joint(),
    }
    figures["step_ns"] = _step_ns(probe.control.foc)
    return figures


def _step_ns(foc):
    """Return the mean time of one current step alone, interrupts included."""
    clock = getattr(time, "ticks_us", None)
    if clock is None:
        return -1
    start = clock()
    for _ in range(CALLS):
        current_step(foc[F_ROTOR], 0, foc)
    return (clock() - start) * 1000 // CALLS


def run():
    """Measure the board this runs on."""
    from .board_stm32f405 import Stm32F405Board

    return measure(Stm32F405Board())
