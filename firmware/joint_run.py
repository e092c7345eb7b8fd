"""What a current step and a millisecond do beside the control, hardware-free and hot: times, offsets, watching, bridge.

``run`` is one array('i') of RUN_SIZE. The board reads the sensors, calls ``take_step`` 10 000 times a second and
``take_motion`` 1 000 times, and does to the bridge what they return.
"""

from shared.joint.current import current_repair, current_step, set_offsets
from shared.joint.encoder import home_by_encoder
from shared.joint.faults import (
    FAULT_CURRENT_SENSE,
    FAULT_DRIVER,
    FAULT_EXCEPTION,
    FAULT_INTERRUPT_STOPPED,
    FAULT_NONE,
    FAULT_OVERRUN,
)
from shared.joint.layout import (
    F_MASKED,
    F_RAW_A,
    F_RAW_B,
    F_RAW_C,
    F_ROTOR,
    IO_E_STOP,
    IO_HARDWARE_FAULT,
    IO_HARDWARE_READY,
    IO_HARDWARE_VALUE,
    IO_JOINT_VALID,
    K_HAS_JOINT_ENCODER,
    K_OFFSET_SPREAD,
    TORQUE_OFF,
)
from shared.joint.tick import motion_tick
from shared.runtime import Ints, const, hot

RUN_BRIDGE = const(0)  # 1: the bridge is on
RUN_STEPS = const(1)  # current steps, modulo 2^30
RUN_LATE = const(2)  # late steps since power-on
RUN_LATE_US = const(3)  # a step that comes later than this after the last is late
RUN_LAST_US = const(4)  # -1: none yet
RUN_SINCE_MOTION = const(5)  # current steps since the last motion tick
RUN_OFFSET_STEPS = const(6)  # current offsets are still measured that many steps; -1 without hope
RUN_SUM_A = const(7)  # of the raw currents, for the offsets
RUN_SUM_B = const(8)
RUN_SUM_C = const(9)
RUN_STALE = const(10)  # steps in a row without a new sample
RUN_FAILED = const(11)  # PART_* that failed since the last motion tick
RUN_READY = const(12)  # 1 once offsets are measured and the driver is set up
RUN_LATE_SEEN = const(13)  # RUN_LATE at the last slow tick
RUN_STEPS_SEEN = const(14)  # RUN_STEPS at the last motion tick
RUN_STILL_MS = const(15)  # motion ticks without a current step
RUN_INVALID_MS = const(16)  # motion ticks without an answer of the joint's encoder
RUN_HOLD_MS = const(17)  # a hardware fault stays reported that long
RUN_E_STOP_MS = const(18)  # an emergency stop lasts that long
RUN_UNSENT = const(19)  # frames that found no free mailbox, modulo 2^30
RUN_STEPS_FED = const(20)  # RUN_STEPS when the watchdog was fed last
RUN_REPLY = const(21)  # 3 values: fields of the reply being written
RUN_MASKED = const(24)  # F_MASKED of the step before the last
RUN_SIZE = const(25)

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
_INVALID_MS = const(10)  # the joint encoder may be silent that long
_HOLD_MS = const(20)  # a hardware fault stays reported that long after its cause
_E_STOP_MS = const(20)  # an emergency stop lasts that long after its last frame


@hot
def take_step(foc: Ints, run: Ints, now_us: int, rotor: int) -> int:
    """Do a current step on F_RAW_* and the rotor's angle (-1: none) and return what becomes of the bridge.

    The samples were taken where the duties of the last step began to act and those of the step before ended: what
    either left no time for is not used.
    """
    if run[RUN_LAST_US] >= 0 and ((now_us - run[RUN_LAST_US]) & _MASK) > run[RUN_LATE_US]:
        run[RUN_LATE] = (run[RUN_LATE] + 1) & _MASK
    run[RUN_LAST_US] = now_us
    run[RUN_STEPS] = (run[RUN_STEPS] + 1) & _MASK
    run[RUN_SINCE_MOTION] += 1
    invalid = 0
    if rotor < 0:
        rotor = foc[F_ROTOR]
        invalid = 1
    masked = foc[F_MASKED]
    foc[F_MASKED] = masked | run[RUN_MASKED]
    run[RUN_MASKED] = masked
    code = current_step(rotor, invalid, foc)
    if code:
        code = current_repair(code, rotor, invalid, foc)
    if run[RUN_OFFSET_STEPS] > 0:
        run[RUN_SUM_A] += foc[F_RAW_A]
        run[RUN_SUM_B] += foc[F_RAW_B]
        run[RUN_SUM_C] += foc[F_RAW_C]
        run[RUN_OFFSET_STEPS] -= 1
    if code or run[RUN_SINCE_MOTION] > _MOTION_LATE_STEPS:
        run[RUN_BRIDGE] = 0
        return BRIDGE_OFF
    return run[RUN_BRIDGE]


@hot
def note_fault(run: Ints, io: Ints, code: int, value: int) -> int:
    """Report a fault of the hardware; the first stands until it has not been raised for 20 ms. Return that."""
    if io[IO_HARDWARE_FAULT] == FAULT_NONE:
        io[IO_HARDWARE_FAULT] = code
        io[IO_HARDWARE_VALUE] = value
    if io[IO_HARDWARE_FAULT] == code:
        run[RUN_HOLD_MS] = _HOLD_MS
    return io[IO_HARDWARE_FAULT]


@hot
def note_stop(run: Ints, io: Ints) -> int:
    """Take an emergency stop; return BRIDGE_OFF."""
    run[RUN_BRIDGE] = 0
    run[RUN_E_STOP_MS] = _E_STOP_MS
    io[IO_E_STOP] = 1
    return BRIDGE_OFF


@hot
def take_motion(foc, cfg, state, io, cal, run: Ints, driver: int) -> int:
    """Do a motion tick on what IO_* holds; return what becomes of the bridge. driver: its fault registers, 0 none."""
    _watch_joint_encoder(foc, cfg, state, io, run)
    if driver:
        note_fault(run, io, FAULT_DRIVER, driver)
    stopped = _watch(run, io)
    torque = motion_tick(foc, cfg, state, io, cal)
    run[RUN_SINCE_MOTION] = 0
    if torque == TORQUE_OFF or stopped or driver:
        run[RUN_BRIDGE] = 0
        return BRIDGE_OFF
    if run[RUN_BRIDGE]:
        return BRIDGE_STAYS
    run[RUN_BRIDGE] = 1
    return BRIDGE_ON


@hot
def _watch_joint_encoder(foc, cfg: Ints, state, io: Ints, run: Ints) -> int:
    """Count what the joint's encoder left unanswered, get ready once offsets are measured; return IO_HARDWARE_READY."""
    run[RUN_INVALID_MS] += 1
    if io[IO_JOINT_VALID]:
        run[RUN_INVALID_MS] = 0
    if run[RUN_READY] == 0 and run[RUN_OFFSET_STEPS] == 0 and run[RUN_STEPS] >= OFFSET_STEPS:
        _take_offsets(foc, cfg, io, run)
        home_by_encoder(cfg, state, io)
    io[IO_HARDWARE_READY] = run[RUN_READY]
    if cfg[K_HAS_JOINT_ENCODER] and run[RUN_INVALID_MS] > _INVALID_MS:
        io[IO_HARDWARE_READY] = 0
    return io[IO_HARDWARE_READY]


@hot
def _take_offsets(foc, cfg: Ints, io, run: Ints) -> int:
    """Use the offsets measured with the bridge off and return 1, or refuse to become ready and return 0."""
    for phase in range(3):
        mean = run[RUN_SUM_A + phase] // OFFSET_STEPS
        if mean < 2048 - cfg[K_OFFSET_SPREAD] or mean > 2048 + cfg[K_OFFSET_SPREAD]:
            run[RUN_OFFSET_STEPS] = -1
            note_fault(run, io, FAULT_CURRENT_SENSE, mean - 2048)
            return 0
    shift = OFFSET_STEPS // 16
    set_offsets(foc, run[RUN_SUM_A] // shift, run[RUN_SUM_B] // shift, run[RUN_SUM_C] // shift)
    run[RUN_READY] = 1
    return 1


@hot
def _watch(run: Ints, io: Ints) -> int:
    """Look for what only the application sees: a part that failed, late interrupts; return 1 if they have stopped."""
    if run[RUN_FAILED]:
        note_fault(run, io, FAULT_EXCEPTION, run[RUN_FAILED])
        run[RUN_FAILED] = 0
    run[RUN_STILL_MS] += 1
    if run[RUN_STEPS] != run[RUN_STEPS_SEEN]:
        run[RUN_STEPS_SEEN] = run[RUN_STEPS]
        run[RUN_STILL_MS] = 0
    stopped = 0
    if run[RUN_STILL_MS] >= _STOPPED_MS:
        stopped = 1
        note_fault(run, io, FAULT_INTERRUPT_STOPPED, run[RUN_STILL_MS])
    late = run[RUN_LATE] - run[RUN_LATE_SEEN]
    if late >= _LATE_MOST:
        note_fault(run, io, FAULT_OVERRUN, late)
    if run[RUN_HOLD_MS] > 0:
        run[RUN_HOLD_MS] -= 1
    elif io[IO_HARDWARE_FAULT]:
        io[IO_HARDWARE_FAULT] = FAULT_NONE
    if run[RUN_E_STOP_MS] > 0:
        run[RUN_E_STOP_MS] -= 1
    else:
        io[IO_E_STOP] = 0
    return stopped
