"""What a frame does to a joint, and what is due to be told, hot and hardware-free; requests are served elsewhere."""

from shared.joint.drive_state import REQUEST_ARM
from shared.joint.layout import CurrentLoop, JointIo, JointSettings, JointState
from shared.joint.report import report_current, report_position, report_velocity
from shared.record import field, record
from shared.runtime import const, hot
from shared.wire.codec import Reply, encode_reply
from shared.wire.names import (
    NOT_AVAILABLE,
    REPLY_ID,
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
    FRAME_UPDATE,
    KIND_CURRENT,
    KIND_CURRENT_FEEDFORWARD,
    KIND_DAMPING,
    KIND_STIFFNESS,
    KIND_VELOCITY,
    KIND_VELOCITY_FEEDFORWARD,
    Link,
    accept_frame,
    end_session,
)


@record
class Told:
    """What the host was told last, and how long ago."""

    drive_state: int = field("", "STATE_* told last, -1 none")
    fault_code: int = field("", "latched in the millisecond before, 0 none")
    status_ms: int = field("ms", "since heartbeat and slow status")
    fault_ms: int = field("ms", "since a latched fault")


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
def take_frame(link: Link, io: JointIo, came: int, frame) -> int:
    """Do what a frame says; ``came``: identifier + length << 11. Set-points made valid go to io.

    Return WANTS_REPLY after a SYNC, ``came`` with FRAME_* above it if it is left to the application, else -1.
    """
    found = accept_frame(link, came & _IDENTIFIER, frame, came >> _LENGTH_SHIFT & _LENGTH)
    if found == FRAME_SYNC_SETPOINT:
        use_setpoint(link, io)
        return WANTS_REPLY
    if found == FRAME_SYNC:
        return WANTS_REPLY
    if found == FRAME_E_STOP or found == FRAME_REQUEST or found == FRAME_TWIN or found == FRAME_UPDATE:
        return came | found << FOUND_SHIFT
    return -1


@hot
def use_setpoint(link: Link, io: JointIo) -> None:
    """Copy the latched set-point to where the control reads it; only this feeds the watchdog."""
    mode = link.mode
    velocity = KIND_VELOCITY_FEEDFORWARD
    if mode == KIND_VELOCITY + 1:
        velocity = KIND_VELOCITY
    current = KIND_CURRENT_FEEDFORWARD
    if mode == KIND_CURRENT + 1:
        current = KIND_CURRENT
    io.mode = mode
    io.position = link.latched[mode - 1]
    io.velocity = link.latched[velocity]
    io.current = link.latched[current]
    io.stiffness = link.latched[KIND_STIFFNESS]
    io.damping = link.latched[KIND_DAMPING]
    io.sequence = (io.sequence + 1) & _MASK


@hot
def write_reply(link: Link, loop: CurrentLoop, settings: JointSettings, state: JointState, reply: Reply, out) -> int:
    """Write the reply to SYNC into the frame ``out``; return its identifier, 0 for a joint without a node."""
    if link.node == 0:
        return 0
    reply.position = NOT_AVAILABLE
    if state.homed:
        reply.position = report_position(settings, state)
    reply.velocity = report_velocity(settings, state)
    reply.current = report_current(loop, settings)
    encode_reply(out, reply)
    return REPLY_ID + link.node


@hot
def is_armed(state: JointState) -> int:
    """Return 1 from the moment arming was accepted until the torque is gone, else 0."""
    if state.request == REQUEST_ARM:
        return 1
    if state.drive_state >= STATE_READY and state.drive_state <= STATE_FAULT_REACTION:
        return 1
    return 0


@hot
def leave_session(link: Link, state: JointState, io: JointIo) -> int:
    """A session lasts from arming to the end of torque; then every set-point is forgotten. Return 1 if it ended now."""
    if io.session == 0 or is_armed(state):
        return 0
    if state.drive_state != STATE_FAULT and state.drive_state != STATE_SWITCH_ON_DISABLED:
        return 0
    end_session(link)
    io.session = 0
    io.hash_ok = 0
    io.mode = 0
    return 1


@hot
def what_to_tell(told: Told, link: Link, state: JointState, io: JointIo) -> int:
    """Once a millisecond: end a session that is over; return TELL_* bits of what the host is to be told now."""
    tell = 0
    if leave_session(link, state, io):
        tell = SESSION_OVER
    told.status_ms += 1
    told.fault_ms += 1
    if told.status_ms >= _STATUS_MS:
        told.status_ms = 0
        tell = tell | TELL_HEARTBEAT | TELL_STATUS
    if state.drive_state != told.drive_state:
        told.drive_state = state.drive_state
        tell = tell | TELL_HEARTBEAT
    code = state.fault_code
    if code and (code != told.fault_code or told.fault_ms >= _FAULT_MS):
        told.fault_ms = 0
        tell = tell | TELL_FAULT
    told.fault_code = code
    return tell
