"""What a frame does to a joint, and what is due to be told, hot and hardware-free; requests are served elsewhere."""

from shared.joint.layout import (
    IO_CURRENT,
    IO_DAMPING,
    IO_HASH_OK,
    IO_MODE,
    IO_POSITION,
    IO_SEQUENCE,
    IO_SESSION,
    IO_STIFFNESS,
    IO_VELOCITY,
    REQUEST_ARM,
    S_DRIVE,
    S_FAULT_CODE,
    S_HOMED,
    S_REQUEST,
)
from shared.joint.report import report_current, report_position, report_velocity
from shared.runtime import Ints, const, hot
from shared.wire.codec import encode_reply
from shared.wire.names import (
    NOT_AVAILABLE,
    REPLY_CURRENT,
    REPLY_ID,
    REPLY_POSITION,
    REPLY_VELOCITY,
    STATE_FAULT,
    STATE_FAULT_REACTION,
    STATE_READY,
    STATE_SWITCH_ON_DISABLED,
)
from shared.wire.receive import (
    FRAME_E_STOP,
    FRAME_REQUEST,
    FRAME_SYNC,
    FRAME_SYNC_SETPOINT,
    FRAME_TWIN,
    KIND_CURRENT,
    KIND_CURRENT_FEEDFORWARD,
    KIND_DAMPING,
    KIND_STIFFNESS,
    KIND_VELOCITY,
    KIND_VELOCITY_FEEDFORWARD,
    LINK_LATCHED,
    LINK_MODE,
    LINK_NODE,
    accept_frame,
    end_session,
)

from .joint_run import RUN_REPLY

TOLD_STATE = const(0)  # what the host was told last, and how long ago
TOLD_FAULT = const(1)
TOLD_STATUS_MS = const(2)
TOLD_FAULT_MS = const(3)
TOLD_SIZE = const(4)

TELL_HEARTBEAT = const(1)  # what is due
TELL_STATUS = const(2)
TELL_FAULT = const(4)
SESSION_OVER = const(8)  # the torque is gone: what armed the joint is to arm it no more

_STATUS_MS = const(200)  # heartbeat and slow status, five times a second
_FAULT_MS = const(1000)  # a latched fault is told again
FRAMES_MOST = const(8)  # taken in one go, so that a flooded bus cannot hold up the motion tick
FOUND_SHIFT = const(16)  # what take_frame returns: FRAME_* << 16 + length << 11 + identifier
WANTS_REPLY = const(-2)
_IDENTIFIER = const(0x7FF)
_LENGTH_SHIFT = const(11)
_LENGTH = const(15)
_MASK = const(0x3FFFFFFF)


@hot
def take_frame(link, io, came: int, frame) -> int:
    """Do what a frame says; ``came``: identifier + length << 11. Set-points made valid go to io.

    Return WANTS_REPLY after a SYNC, ``came`` with FRAME_* above it if it is left to the application, else -1.
    """
    found = accept_frame(link, came & _IDENTIFIER, frame, came >> _LENGTH_SHIFT & _LENGTH)
    if found == FRAME_SYNC_SETPOINT:
        use_setpoint(link, io)
        return WANTS_REPLY
    if found == FRAME_SYNC:
        return WANTS_REPLY
    if found == FRAME_E_STOP or found == FRAME_REQUEST or found == FRAME_TWIN:
        return came | found << FOUND_SHIFT
    return -1


@hot
def use_setpoint(link: Ints, io: Ints) -> int:
    """Copy the latched set-point to where the control reads it; only this feeds the watchdog. Return its mode."""
    mode = link[LINK_MODE]
    velocity = KIND_VELOCITY_FEEDFORWARD
    if mode == KIND_VELOCITY + 1:
        velocity = KIND_VELOCITY
    current = KIND_CURRENT_FEEDFORWARD
    if mode == KIND_CURRENT + 1:
        current = KIND_CURRENT
    io[IO_MODE] = mode
    io[IO_POSITION] = link[LINK_LATCHED + mode - 1]
    io[IO_VELOCITY] = link[LINK_LATCHED + velocity]
    io[IO_CURRENT] = link[LINK_LATCHED + current]
    io[IO_STIFFNESS] = link[LINK_LATCHED + KIND_STIFFNESS]
    io[IO_DAMPING] = link[LINK_LATCHED + KIND_DAMPING]
    io[IO_SEQUENCE] = (io[IO_SEQUENCE] + 1) & _MASK
    return mode


@hot
def write_reply(link: Ints, foc, cfg, state: Ints, run: Ints, out) -> int:
    """Write the reply to SYNC into the frame ``out``; return its identifier, 0 for a joint without a node."""
    if link[LINK_NODE] == 0:
        return 0
    run[RUN_REPLY + REPLY_POSITION] = NOT_AVAILABLE
    if state[S_HOMED]:
        run[RUN_REPLY + REPLY_POSITION] = report_position(cfg, state)
    run[RUN_REPLY + REPLY_VELOCITY] = report_velocity(cfg, state)
    run[RUN_REPLY + REPLY_CURRENT] = report_current(foc, cfg)
    encode_reply(out, run, RUN_REPLY)
    return REPLY_ID + link[LINK_NODE]


@hot
def is_armed(state: Ints) -> int:
    """Return 1 from the moment arming was accepted until the torque is gone, else 0."""
    if state[S_REQUEST] == REQUEST_ARM:
        return 1
    if state[S_DRIVE] >= STATE_READY and state[S_DRIVE] <= STATE_FAULT_REACTION:
        return 1
    return 0


@hot
def leave_session(link, state: Ints, io: Ints) -> int:
    """A session lasts from arming to the end of torque; then every set-point is forgotten. Return 1 if it ended now."""
    if io[IO_SESSION] == 0 or is_armed(state):
        return 0
    if state[S_DRIVE] != STATE_FAULT and state[S_DRIVE] != STATE_SWITCH_ON_DISABLED:
        return 0
    end_session(link)
    io[IO_SESSION] = 0
    io[IO_HASH_OK] = 0
    io[IO_MODE] = 0
    return 1


@hot
def what_to_tell(told: Ints, link, state: Ints, io) -> int:
    """Once a millisecond: end a session that is over; return TELL_* bits of what the host is to be told now."""
    tell = 0
    if leave_session(link, state, io):
        tell = SESSION_OVER
    told[TOLD_STATUS_MS] += 1
    told[TOLD_FAULT_MS] += 1
    if told[TOLD_STATUS_MS] >= _STATUS_MS:
        told[TOLD_STATUS_MS] = 0
        tell = tell | TELL_HEARTBEAT | TELL_STATUS
    if state[S_DRIVE] != told[TOLD_STATE]:
        told[TOLD_STATE] = state[S_DRIVE]
        tell = tell | TELL_HEARTBEAT
    code = state[S_FAULT_CODE]
    if code and (code != told[TOLD_FAULT] or told[TOLD_FAULT_MS] >= _FAULT_MS):
        told[TOLD_FAULT_MS] = 0
        tell = tell | TELL_FAULT
    told[TOLD_FAULT] = code
    return tell
