"""What only silicon can tell, measured on the joint's own board: times, samples with the bridge off and on, registers.

``measure(board)`` returns a dictionary of integers, for the host to judge and print. With ``bridge`` all three phases
also switch with half the period for as long again: no current flows into a motor at rest, and the samples show what
switching does to them.
"""

from shared.joint.commutation import set_commutation
from shared.joint.current import current_reset, current_step
from shared.joint.layout import CurrentLoop
from shared.runtime import const

from .chip_probe import Seen, probed
from .joint_control import Control
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
    set_commutation(control.loop, control.settings)
    current_reset(control.loop, max(angle, 0))
    control.loop.trip_square = _NEVER  # offsets are not measured here
    seen = Seen()
    seen.gap_least_us = _LARGE
    _forget_samples(seen)
    board.start(control, probed, seen)
    took = _wait(board, control, STEPS)
    found = {"driver": driver, "took_us": took, "raw_low": _low(seen), "raw_high": _high(seen)}
    if bridge:
        found.update(_switched(board, control, seen, driver))
    board.pwm_off()
    found.update({
        "steps": control.run.steps,
        "failed": control.run.failed_part,
        "stale": seen.stale_samples,
        "bad_rotor": control.loop.glitches,
        "driver_fault": board.millisecond(),  # a motion tick, which takes note of failures and clears them
        "gap_least_us": seen.gap_least_us,
        "gap_most_us": seen.gap_most_us,
        "entry_most_ns": seen.entry_most * 1000 // 168,
        "end_most_ns": seen.end_most * 1000 // 168,
        "bus": _counts(board.read_bus),
        "thermistor": _counts(board.read_thermistor),
        "mcu": _counts(board.read_mcu),
        "joint": board.read_joint(),
        "step_ns": _step_ns(board, control.loop),
    })  # fmt: skip
    return found


def _switched(board, control: Control, seen: Seen, driver):
    """Return what the samples are while the bridge switches; nothing if the gate driver is not set up."""
    if driver != -1:
        return {"bridge_on": 0}
    _forget_samples(seen)
    board.pwm_on(control.loop)  # compares in the middle, as current_reset left them
    _wait(board, control, 2 * STEPS)
    return {"bridge_on": board.pwm_is_on(), "on_low": _low(seen), "on_high": _high(seen)}


def _forget_samples(seen: Seen):
    for phase in range(3):
        seen.raw_low[phase] = 4095
        seen.raw_high[phase] = 0


def _low(seen: Seen):
    return [seen.raw_low[phase] for phase in range(3)]


def _high(seen: Seen):
    return [seen.raw_high[phase] for phase in range(3)]


def _counts(read):
    """Return what an ADC channel reads, -1 if no conversion ends."""
    try:
        return read()
    except OSError:
        return -1


def _wait(board, control: Control, steps):
    """Wait until so many steps are done, or for two seconds; return how long. Feeds what the main loop feeds."""
    run = control.run
    began = board.ticks_us()
    took = 0
    while run.steps < steps and took < _TIMEOUT_US:
        board.feed_watchdog()
        run.steps_since_motion = 0  # no motion ticks here
        took = (board.ticks_us() - began) & _MASK
    return took


def _step_ns(board, loop: CurrentLoop):
    """Return the mean time of one current step alone, interrupts included."""
    start = board.ticks_us()
    for _ in range(CALLS):
        current_step(loop.rotor, 0, loop)
    return ((board.ticks_us() - start) & _MASK) * 1000 // CALLS


def run(bridge=False):
    """Measure the board this runs on."""
    from .board_stm32f405 import Stm32F405Board

    return measure(Stm32F405Board(), bridge)
