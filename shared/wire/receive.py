"""The joint's end of the bus: what a frame means for this joint, set-points kept until SYNC makes them valid.

A set-point frame fills the pending slots; SYNC moves them all at once to the latched ones, so the joints of a robot
change together. What has arrived decides the mode: position, velocity, current or impedance set-point, the last one
wins. A feed-forward holds for the set-point it came with; the next set-point without one has none. Stiffness and
damping hold until changed. Nothing here ever makes a set-point up.
"""

from ..record import field, record, vector
from ..runtime import Ints, const, hot
from .framing import (
    SETPOINT_KINDS,
    frame_block,
    node_group,
    node_slot,
    read_slot,
    setpoint_group,
    setpoint_kind,
    sync_counter,
    sync_session,
)
from .names import (
    E_STOP_ID,
    HEARTBEAT_ID,
    NO_CHANGE,
    REPLY_ID,
    SERVICE_REQUEST_ID,
    SERVICE_REQUEST_LENGTH,
    SETPOINT_POSITION_ID,
    SETPOINT_POSITION_LENGTH,
    SYNC_ID,
    SYNC_LENGTH,
    UPDATE_REQUEST_ID,
    UPDATE_REQUEST_LENGTH,
)


@record
class Link:
    """One joint's end of the bus."""

    node: int = field("", "0 not assigned, 1 .. 12")
    session: int = field("", "session the joint is armed in, 0 none")
    counter: int = field("", "of the last SYNC, -1 none yet")
    lost_syncs: int = field("", "SYNC frames missed, stays at 2^30 - 1")
    bad_frames: int = field("", "frames dropped because too short or out of range, stays at 2^30 - 1")
    pending_set: int = field("", "bit per set-point kind received since the last SYNC")
    pending_mode: int = field("", "MODE_* of the last of them that carries one, 0 none")
    mode: int = field("", "MODE_* of the latched set-point, 0 none since clear_setpoints")
    pending: Ints = vector(SETPOINT_KINDS, "", "set-points received, by kind in the wire's units")
    latched: Ints = vector(SETPOINT_KINDS, "", "set-points made valid by SYNC, likewise")


# What accept_frame found
FRAME_NOT_MINE = const(0)
FRAME_E_STOP = const(1)
FRAME_SETPOINT = const(2)  # kept until SYNC
FRAME_SYNC = const(3)  # no new set-point with it: send the reply, do not feed the watchdog
FRAME_SYNC_SETPOINT = const(4)  # a new set-point is latched: send the reply, feed the watchdog
FRAME_REQUEST = const(5)  # a service request to this node or to all
FRAME_TWIN = const(6)  # another node sends under this node's id
FRAME_BAD = const(7)  # too short or out of range, counted
FRAME_OTHER_SESSION = const(8)  # SYNC of a host that did not arm this joint: nothing latched
FRAME_UPDATE = const(9)  # a request of a firmware update to this node

# Kinds of set-point, low bits of the identifier; kinds 0 .. 3 carry the mode kind + 1
KIND_POSITION = const(0)
KIND_VELOCITY = const(1)
KIND_CURRENT = const(2)
KIND_IMPEDANCE = const(3)
KIND_VELOCITY_FEEDFORWARD = const(4)
KIND_CURRENT_FEEDFORWARD = const(5)
KIND_STIFFNESS = const(6)
KIND_DAMPING = const(7)
_MOST = const(0x3FFFFFFF)


@hot
def clear_setpoints(link: Link) -> None:
    """Forget every set-point, pending and latched, with gains and feed-forwards."""
    link.pending_set = 0
    link.pending_mode = 0
    link.mode = 0
    for kind in range(SETPOINT_KINDS):
        link.pending[kind] = 0
        link.latched[kind] = 0


@hot
def start_session(link: Link, session: int) -> None:
    """Bind the link to the host's session 1 .. 255, on arm: SYNC of another is refused, counting starts again.

    The set-points stay as they are, because arming needs fresh ones before it.
    """
    link.session = session
    link.counter = -1


@hot
def end_session(link: Link) -> None:
    """Leave the session and forget every set-point: on disarm, fault and e-stop."""
    link.session = 0
    clear_setpoints(link)


@hot
def link_reset(link: Link, node: int) -> None:
    """Start the link of node 0 .. 12: no session, no SYNC seen, no set-point, counters zero."""
    link.node = node
    link.session = 0
    link.counter = -1
    link.lost_syncs = 0
    link.bad_frames = 0
    clear_setpoints(link)


@hot
def _counted(count: int, more: int) -> int:
    """Return count + more, both >= 0, at most 2^30 - 1."""
    if count > _MOST - more:
        return _MOST
    return count + more


@hot
def _bad_frame(link: Link) -> int:
    link.bad_frames = _counted(link.bad_frames, 1)
    return FRAME_BAD


@hot
def _accept_setpoint(link: Link, identifier: int, frame: Ints) -> int:
    """Keep this joint's slot of a set-point frame; FRAME_NOT_MINE for another group or "no change"."""
    node = link.node
    if setpoint_group(identifier) != node_group(node) or node_group(node) < 0:
        return FRAME_NOT_MINE
    value = read_slot(frame, node_slot(node))
    if value == NO_CHANGE:
        return FRAME_NOT_MINE
    kind = setpoint_kind(identifier)
    if kind >= KIND_STIFFNESS and value < 0:
        return _bad_frame(link)
    link.pending[kind] = value
    link.pending_set = link.pending_set | (1 << kind)
    if kind <= KIND_IMPEDANCE:
        link.pending_mode = kind + 1
    return FRAME_SETPOINT


@hot
def _count_sync(link: Link, counter: int) -> None:
    """Count the SYNC frames missed since the last one, at most 255."""
    missed = 0
    if link.counter >= 0:
        missed = (counter - link.counter - 1) & 0xFF
        link.lost_syncs = _counted(link.lost_syncs, missed)
    link.counter = counter


@hot
def _latch(link: Link) -> int:
    """Move the pending set-points to the latched ones; FRAME_SYNC_SETPOINT if one carries a mode."""
    arrived = link.pending_set
    mode = link.pending_mode
    link.pending_set = 0
    link.pending_mode = 0
    for kind in range(SETPOINT_KINDS):
        if (arrived >> kind) & 1:
            link.latched[kind] = link.pending[kind]
        elif mode and (kind == KIND_VELOCITY_FEEDFORWARD or kind == KIND_CURRENT_FEEDFORWARD):
            link.latched[kind] = 0
    if mode == 0:
        return FRAME_SYNC
    link.mode = mode
    return FRAME_SYNC_SETPOINT


@hot
def _accept_sync(link: Link, frame: Ints) -> int:
    """Count, then latch; SYNC of a host with another session changes nothing."""
    if link.session and sync_session(frame) != link.session:
        return FRAME_OTHER_SESSION
    _count_sync(link, sync_counter(frame))
    return _latch(link)


@hot
def accept_frame(link: Link, identifier: int, frame: Ints, length: int) -> int:
    """Take one received frame of ``length`` bytes; return FRAME_*.

    ``frame`` is an array('H') of four words. An e-stop counts whatever its length. Of a request only the address is
    checked; decode_service_request reads the rest. Intermediates within 2^30.
    """
    kind = frame_block(identifier)
    if kind == E_STOP_ID:
        if identifier == E_STOP_ID:
            return FRAME_E_STOP
        return FRAME_NOT_MINE
    if kind == SETPOINT_POSITION_ID:
        if length < SETPOINT_POSITION_LENGTH:
            return _bad_frame(link)
        return _accept_setpoint(link, identifier, frame)
    if identifier == SYNC_ID:
        if length < SYNC_LENGTH:
            return _bad_frame(link)
        return _accept_sync(link, frame)
    node = link.node
    if identifier == SERVICE_REQUEST_ID or identifier == SERVICE_REQUEST_ID + node:
        if length < SERVICE_REQUEST_LENGTH:
            return _bad_frame(link)
        return FRAME_REQUEST
    if node and (identifier == HEARTBEAT_ID + node or identifier == REPLY_ID + node):
        return FRAME_TWIN
    if node and identifier == UPDATE_REQUEST_ID + node:
        if length < UPDATE_REQUEST_LENGTH:
            return _bad_frame(link)
        return FRAME_UPDATE
    return FRAME_NOT_MINE
