"""A joint's millisecond and its bus on the chip, each one hot function: what the main loop calls at its rates."""

from shared.joint.commission_state import Commission
from shared.joint.layout import CurrentLoop, JointIo, JointSettings, JointState
from shared.runtime import const, hot, reg32
from shared.wire.codec import Reply
from shared.wire.names import REPLY_LENGTH
from shared.wire.receive import Link

from .chip import IWDG_KR_32
from .chip_io import receive, send, sense
from .chip_step import bridge_on, outputs_off, write_compares
from .joint_bus import FRAMES_MOST, WANTS_REPLY, take_frame, write_reply
from .joint_run import BRIDGE_OFF, BRIDGE_ON, PART_MOTION, BoardRun, take_motion

_FED = const(0xAAAA)
_MASK = const(0x3FFFFFFF)


@hot
def millisecond(
    chip,
    loop: CurrentLoop,
    settings: JointSettings,
    state: JointState,
    io: JointIo,
    commission: Commission,
    run: BoardRun,
) -> int:
    """Read the sensors, do a motion tick, do to the bridge what it says, feed the watchdog while current steps happen.

    Return the gate driver's fault registers, 0 if it reports none. A silent ADC counts as a failed part.
    """
    driver = sense(chip, io)
    if driver < 0:
        run.failed_part = PART_MOTION
        driver = 0
    wanted = take_motion(loop, settings, state, io, commission, run, driver)
    if run.failed_part or wanted == BRIDGE_OFF:
        run.bridge = 0
        outputs_off(chip)
    elif wanted == BRIDGE_ON:
        write_compares(chip, loop)
        bridge_on(chip)
        if run.bridge == 0:  # an interrupt has switched it off in between
            outputs_off(chip)
    if run.steps != run.steps_fed:
        run.steps_fed = run.steps
        c = reg32(chip)
        c[IWDG_KR_32] = _FED
    return driver


@hot
def serve_bus(
    chip,
    frame,
    link: Link,
    io: JointIo,
    loop: CurrentLoop,
    settings: JointSettings,
    state: JointState,
    run: BoardRun,
    reply: Reply,
    out,
) -> int:
    """Take at most FRAMES_MOST frames that have come; SYNC is answered. Return what take_frame leaves, or -1."""
    for _ in range(FRAMES_MOST):
        came = receive(chip, frame)
        if came < 0:
            return -1
        left = take_frame(link, io, came, frame)
        if left >= 0:
            return left
        if left == WANTS_REPLY:
            identifier = write_reply(link, loop, settings, state, reply, out)
            if identifier and send(chip, identifier, out, REPLY_LENGTH) == 0:
                run.unsent_frames = (run.unsent_frames + 1) & _MASK
    return -1
