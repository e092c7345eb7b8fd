"""What a current step and a millisecond do beside the control, hardware-free and hot: times, offsets, watching, bridge.

The board reads the sensors, calls ``take_step`` 10 000 times a second and
``take_motion`` 1 000 times, and does to the bridge what they return.
"""

from shared.joint.bend import corrected_rotor
from shared.joint.cogging import cogging_step
from shared.joint.commission_state import Commission
from shared.joint.current import current_repair, current_step, set_offsets
from shared.joint.encoder import home_by_encoder
from shared.joint.faults import (
    FAULT_CURRENT_SENSE,
    FAULT_DRIVER,
    FAULT_EXCEPTION,
    FAULT_INTERRUPT_STOPPED,
    FAULT_JOINT_ENCODER_LOST,
    FAULT_NONE,
    FAULT_OVERRUN,
)
from shared.joint.layout import TORQUE_OFF, CurrentLoop, JointIo, JointSettings, JointState
from shared.joint.probe import probe_step
from shared.joint.tick import motion_tick
from shared.record import field, record, vector
from shared.runtime import Ints, const, hot


@record
class BoardRun:
    """What a joint's application knows of its steps, its bridge and its hardware."""

    bridge: int = field("", "1: the bridge is on")
    steps: int = field("", "current steps, modulo 2^30")
    late_steps: int = field("", "late steps since power-on")
    late_after_us: int = field("us", "a step that comes later than this after the last is late")
    last_us: int = field("us", "time of the last step; -1: none yet")
    steps_since_motion: int = field("", "current steps since the last motion tick")
    offset_steps: int = field("", "current offsets are still measured that many steps; -1 without hope")
    raw_sum: Ints = vector(3, "count", "phases a, b, c, summed for the offsets")
    stale_steps: int = field("", "steps in a row without a new sample")
    failed_part: int = field("", "PART_* that failed since the last motion tick")
    ready: int = field("", "1 once offsets are measured and the driver is set up")
    late_steps_seen: int = field("", "late_steps at the last slow tick")
    steps_seen: int = field("", "steps at the last motion tick")
    still_ms: int = field("ms", "motion ticks without a current step")
    invalid_ms: int = field("ms", "motion ticks without an answer of the joint's encoder")
    hold_ms: int = field("ms", "a hardware fault stays reported that long")
    e_stop_ms: int = field("ms", "an emergency stop lasts that long")
    unsent_frames: int = field("", "frames that found no free mailbox, modulo 2^30")
    steps_fed: int = field("", "steps when the watchdog was fed last")
    masked_before: int = field("", "CurrentLoop.masked of the step before the last")


PART_STEP = const(1)  # values of FAULT_EXCEPTION
PART_MOTION = const(2)
PART_SLOW = const(3)
PART_BUS = const(4)

BRIDGE_OFF = const(-1)  # what the board is to do with the bridge
BRIDGE_STAYS = const(0)
BRIDGE_ON = const(1)  # after a step: its compares are written; after a motion tick: compares, then on

OFFSET_STEPS = const(256)  # averaged with the bridge off before the joint is ready
STALE_MOST = const(3)
_MASK = const(0x3FFFFFFF)
_LATE_MOST = const(5)  # late steps in a slow period that are a fault
_MOTION_LATE_STEPS = const(50)  # current steps without a motion tick until the interrupt switches the bridge off
_STOPPED_MS = const(3)  # motion ticks without a current step
INVALID_MS = const(10)  # the joint encoder may be silent that long
_HOLD_MS = const(20)  # a hardware fault stays reported that long after its cause
_E_STOP_MS = const(20)  # an emergency stop lasts that long after its last frame


@hot
def take_step(loop: CurrentLoop, run: BoardRun, now_us: int, rotor: int) -> int:
    """Do a current step on loop.raw and the rotor's angle (-1: none) and return what becomes of the bridge.

    The samples were taken where the duties of the last step began to act and those of the step before ended: what
    either left no time for is not used.
    """
    if run.last_us >= 0 and ((now_us - run.last_us) & _MASK) > run.late_after_us:
        run.late_steps = (run.late_steps + 1) & _MASK
    run.last_us = now_us
    run.steps = (run.steps + 1) & _MASK
    run.steps_since_motion += 1
    invalid = 0
    if rotor < 0:
        rotor = loop.rotor
        invalid = 1
    else:
        rotor = corrected_rotor(loop, rotor)
    if loop.waves:
        cogging_step(loop, rotor)
    masked = loop.masked
    loop.masked = masked | run.masked_before
    run.masked_before = masked
    code = current_step(rotor, invalid, loop)
    if code:
        code = current_repair(code, rotor, invalid, loop)
    if run.offset_steps > 0:
        run.raw_sum[0] += loop.raw[0]
        run.raw_sum[1] += loop.raw[1]
        run.raw_sum[2] += loop.raw[2]
        run.offset_steps -= 1
    if loop.probing:
        probe_step(loop)
    if code or run.steps_since_motion > _MOTION_LATE_STEPS:
        run.bridge = 0
        return BRIDGE_OFF
    return run.bridge


@hot
def note_fault(run: BoardRun, io: JointIo, code: int, value: int) -> None:
    """Report a fault of the hardware; the first stands until it has not been raised for 20 ms."""
    if io.hardware_fault == FAULT_NONE:
        io.hardware_fault = code
        io.hardware_value = value
    if io.hardware_fault == code:
        run.hold_ms = _HOLD_MS


@hot
def note_stop(run: BoardRun, io: JointIo) -> None:
    """Take an emergency stop."""
    run.bridge = 0
    run.e_stop_ms = _E_STOP_MS
    io.e_stop = 1


@hot
def take_motion(
    loop: CurrentLoop,
    settings: JointSettings,
    state: JointState,
    io: JointIo,
    commission: Commission,
    run: BoardRun,
    driver: int,
) -> int:
    """Do a motion tick on what ``io`` holds; return what becomes of the bridge. driver: its fault registers, 0 none."""
    _watch_joint_encoder(loop, settings, state, io, run)
    if driver:
        note_fault(run, io, FAULT_DRIVER, driver)
    stopped = _watch(run, io)
    torque = motion_tick(loop, settings, state, io, commission)
    run.steps_since_motion = 0
    if torque == TORQUE_OFF or stopped or driver:
        run.bridge = 0
        return BRIDGE_OFF
    if run.bridge:
        return BRIDGE_STAYS
    run.bridge = 1
    return BRIDGE_ON


@hot
def _watch_joint_encoder(
    loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, run: BoardRun
) -> None:
    """Count what the joint's encoder left unanswered, get ready once offsets are measured.

    An encoder that does not answer is a fault, from when the offsets are measured on: by then it has started.
    """
    run.invalid_ms += 1
    if io.joint_valid:
        run.invalid_ms = 0
    if run.ready == 0 and run.offset_steps == 0 and run.steps >= OFFSET_STEPS:
        _take_offsets(loop, settings, io, run)
        home_by_encoder(settings, state, io)
    io.hardware_ready = run.ready
    if settings.has_joint_encoder and run.ready and run.invalid_ms > INVALID_MS:
        note_fault(run, io, FAULT_JOINT_ENCODER_LOST, run.invalid_ms)


@hot
def _take_offsets(loop: CurrentLoop, settings: JointSettings, io: JointIo, run: BoardRun) -> None:
    """Use the offsets measured with the bridge off, or refuse to become ready."""
    for phase in range(3):
        mean = run.raw_sum[phase] // OFFSET_STEPS
        if mean < 2048 - settings.offset_spread or mean > 2048 + settings.offset_spread:
            run.offset_steps = -1
            note_fault(run, io, FAULT_CURRENT_SENSE, mean - 2048)
            return
    shift = OFFSET_STEPS // 16
    set_offsets(loop, run.raw_sum[0] // shift, run.raw_sum[1] // shift, run.raw_sum[2] // shift)
    run.ready = 1


@hot
def _watch(run: BoardRun, io: JointIo) -> int:
    """Look for what only the application sees: a part that failed, late interrupts; return 1 if they have stopped."""
    if run.failed_part:
        note_fault(run, io, FAULT_EXCEPTION, run.failed_part)
        run.failed_part = 0
    run.still_ms += 1
    if run.steps != run.steps_seen:
        run.steps_seen = run.steps
        run.still_ms = 0
    stopped = 0
    if run.still_ms >= _STOPPED_MS:
        stopped = 1
        note_fault(run, io, FAULT_INTERRUPT_STOPPED, run.still_ms)
    late = run.late_steps - run.late_steps_seen
    if late >= _LATE_MOST:
        note_fault(run, io, FAULT_OVERRUN, late)
    if run.hold_ms > 0:
        run.hold_ms -= 1
    elif io.hardware_fault:
        io.hardware_fault = FAULT_NONE
    if run.e_stop_ms > 0:
        run.e_stop_ms -= 1
    else:
        io.e_stop = 0
    return stopped
