"""What only silicon can tell, measured on the joint's own board: times, samples with the bridge off and on, registers.

``measure(board)`` returns a dictionary of integers, for the host to judge and print. With ``bridge`` all three phases
also switch with half the period for as long again: no current flows into a motor at rest, and the samples show what
switching does to them.
"""

from array import array

from shared.joint.calibration import set_commutation
from shared.joint.current import current_reset, current_step
from shared.joint.layout import F_GLITCHES, F_ROTOR, F_TRIP_SQUARE
from shared.runtime import const

from .chip_probe import (
    SEEN_END_MOST,
    SEEN_ENTRY_MOST,
    SEEN_GAP_LEAST,
    SEEN_GAP_MOST,
    SEEN_RAW_HIGH,
    SEEN_RAW_LOW,
    SEEN_SIZE,
    SEEN_STALE,
    probed,
)
from .joint_control import Control
from .joint_run import RUN_FAILED, RUN_SINCE_MOTION, RUN_STEPS
from .joint_store import Parameters
from .settings import Memory

STEPS = const(2000)
CALLS = const(500)
_TIMEOUT_US = const(2000000)
_LARGE = const(1000000)
_NEVER = const(0x3FFFFFFF)
_MASK = const(0x3FFFFFFF)


def measure(board, bridge=False):
    """Return the figures. The watchdog that ``start`` brings is fed until the end, and the bridge is off then."""
    board.pwm_off()
    driver = board.driver_setup()
    angle = board.read_rotor()
    control = Control(board)
    Parameters(control, Memory()).defaults()
    set_commutation(control.foc, control.cfg)
    current_reset(control.foc, max(angle, 0))
    control.foc[F_TRIP_SQUARE] = _NEVER  # offsets are not measured here
    seen = array("i", [0] * SEEN_SIZE)
    seen[SEEN_GAP_LEAST] = _LARGE
    _forget_samples(seen)
    board.start(control, probed, seen)
    took = _wait(board, control, STEPS)
    found = {"driver": driver, "took_us": took, "raw_low": _low(seen), "raw_high": _high(seen)}
    if bridge:
        found.update(_switched(board, control, seen, driver))
    board.pwm_off()
    found.update({
        "steps": control.run[RUN_STEPS],
        "failed": control.run[RUN_FAILED],
        "stale": seen[SEEN_STALE],
        "bad_rotor": control.foc[F_GLITCHES],
        "driver_fault": board.millisecond(),  # a motion tick, which takes note of failures and clears them
        "gap_least_us": seen[SEEN_GAP_LEAST],
        "gap_most_us": seen[SEEN_GAP_MOST],
        "entry_most_ns": seen[SEEN_ENTRY_MOST] * 1000 // 168,
        "end_most_ns": seen[SEEN_END_MOST] * 1000 // 168,
        "bus": _counts(board.read_bus),
        "thermistor": _counts(board.read_thermistor),
        "mcu": _counts(board.read_mcu),
        "joint": board.read_joint(),
        "step_ns": _step_ns(board, control.foc),
    })  # fmt: skip
    return found


def _switched(board, control, seen, driver):
    """Return what the samples are while the bridge switches; nothing if the gate driver is not set up."""
    if driver != -1:
        return {"bridge_on": 0}
    _forget_samples(seen)
    board.pwm_on(control.foc)  # compares in the middle, as current_reset left them
    _wait(board, control, 2 * STEPS)
    return {"bridge_on": board.pwm_is_on(), "on_low": _low(seen), "on_high": _high(seen)}


def _forget_samples(seen):
    for phase in range(3):
        seen[SEEN_RAW_LOW + phase] = 4095
        seen[SEEN_RAW_HIGH + phase] = 0


def _low(seen):
    return list(seen[SEEN_RAW_LOW : SEEN_RAW_LOW + 3])


def _high(seen):
    return list(seen[SEEN_RAW_HIGH : SEEN_RAW_HIGH + 3])


def _counts(read):
    """Return what an ADC channel reads, -1 if no conversion ends."""
    try:
        return read()
    except OSError:
        return -1


def _wait(board, control, steps):
    """Wait until so many steps are done, or for two seconds; return how long. Feeds what the main loop feeds."""
    run = control.run
    began = board.ticks_us()
    took = 0
    while run[RUN_STEPS] < steps and took < _TIMEOUT_US:
        board.feed_watchdog()
        run[RUN_SINCE_MOTION] = 0  # no motion ticks here
        took = (board.ticks_us() - began) & _MASK
    return took


def _step_ns(board, foc):
    """Return the mean time of one current step alone, interrupts included."""
    start = board.ticks_us()
    for _ in range(CALLS):
        current_step(foc[F_ROTOR], 0, foc)
    return ((board.ticks_us() - start) & _MASK) * 1000 // CALLS


def run(bridge=False):
    """Measure the board this runs on."""
    from .board_stm32f405 import Stm32F405Board

    return measure(Stm32F405Board(), bridge)
