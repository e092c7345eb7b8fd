"""A joint's millisecond and its bus on the chip, each one hot function: what the main loop calls at its rates."""

from shared.runtime import Ints, const, hot, reg32
from shared.wire.names import REPLY_LENGTH

from .chip import IWDG_KR_32
from .chip_io import receive, send, sense
from .chip_step import bridge_on, outputs_off, write_compares
from .joint_bus import FRAMES_MOST, WANTS_REPLY, take_frame, write_reply
from .joint_run import (
    BRIDGE_OFF,
    BRIDGE_ON,
    PART_MOTION,
    RUN_BRIDGE,
    RUN_FAILED,
    RUN_STEPS,
    RUN_STEPS_FED,
    RUN_UNSENT,
    take_motion,
)

_FED = const(0xAAAA)
_MASK = const(0x3FFFFFFF)


@hot
def millisecond(chip, foc, cfg, state, io, cal, run: Ints) -> int:
    """Read the sensors, do a motion tick, do to the bridge what it says, feed the watchdog while current steps happen.

    Return the gate driver's fault registers, 0 if it reports none. A silent ADC counts as a failed part.
    """
    driver = sense(chip, io)
    if driver < 0:
        run[RUN_FAILED] = PART_MOTION
        driver = 0
    wanted = take_motion(foc, cfg, state, io, cal, run, driver)
    if run[RUN_FAILED] or wanted == BRIDGE_OFF:
        run[RUN_BRIDGE] = 0
        outputs_off(chip)
    elif wanted == BRIDGE_ON:
        write_compares(chip, foc)
        bridge_on(chip)
        if run[RUN_BRIDGE] == 0:  # an interrupt has switched it off in between
            outputs_off(chip)
    if run[RUN_STEPS] != run[RUN_STEPS_FED]:
        run[RUN_STEPS_FED] = run[RUN_STEPS]
        c = reg32(chip)
        c[IWDG_KR_32] = _FED
    return driver


@hot
def serve_bus(chip, frame, link, io, foc, cfg, state, run: Ints, out) -> int:
    """Take at most FRAMES_MOST frames that have come; SYNC is answered. Return what take_frame leaves, or -1."""
    for _ in range(FRAMES_MOST):
        came = receive(chip, frame)
        if came < 0:
            return -1
        left = take_frame(link, io, came, frame)
        if left >= 0:
            return left
        if left == WANTS_REPLY:
            identifier = write_reply(link, foc, cfg, state, run, out)
            if identifier and send(chip, identifier, out, REPLY_LENGTH) == 0:
                run[RUN_UNSENT] = (run[RUN_UNSENT] + 1) & _MASK
    return -1
