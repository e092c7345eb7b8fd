"""The joint's end of the bus: what a frame means for this joint, set-points kept until SYNC makes them valid.

``link`` is one array('i') of LINK_SIZE. A set-point frame fills the pending slots; SYNC moves them all at once to
the latched ones, so the joints of a robot change together. What has arrived decides the mode: position, velocity,
current or impedance set-point, the last one wins. A feed-forward holds for the set-point it came with; without it
the next set-point has none. Stiffness and damping hold until changed. Nothing here ever makes a set-point up.
"""

from ..runtime import Ints, const, hot
from .codec import decode_sync
from .framing import SETPOINT_KINDS, frame_block, node_group, node_slot, read_slot, setpoint_group, setpoint_kind
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
)

# Places in the link block
LINK_NODE = const(0)  # 0 not assigned, 1 .. 12
LINK_SESSION = const(1)  # session the joint is armed in, 0 none
LINK_COUNTER = const(2)  # counter of the last SYNC, -1 none yet
LINK_LOST = const(3)  # SYNC frames missed, stays at 2^30 - 1
LINK_BAD = const(4)  # frames dropped because too short or out of range, stays at 2^30 - 1
LINK_PENDING_SET = const(5)  # bit per set-point kind received since the last SYNC
LINK_PENDING_MODE = const(6)  # mode of the last of them that carries one, 0 none
LINK_MODE = const(7)  # MODE_* of the latched set-point, 0 none since clear_setpoints
LINK_SYNC = const(8)  # 2 values: fields of the last SYNC as received
LINK_PENDING = const(10)  # 8 values, one per set-point kind
LINK_LATCHED = const(18)  # 8 values, in the same order
LINK_SIZE = const(26)

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
def clear_setpoints(link: Ints) -> int:
    """Forget every set-point, pending and latched, with gains and feed-forwards."""
    for i in range(LINK_PENDING_SET, LINK_MODE + 1):
        link[i] = 0
    for i in range(LINK_PENDING, LINK_SIZE):
        link[i] = 0
    return 0


@hot
def start_session(link: Ints, session: int) -> int:
    """Bind the link to the host's session 1 .. 255, on arm: SYNC of another is refused, counting starts anew.

    The set-points stay as they are, because arming needs fresh ones before it.
    """
    link[LINK_SESSION] = session
    link[LINK_COUNTER] = -1
    return session


@hot
def end_session(link: Ints) -> int:
    """Leave the session and forget every set-point: on disarm, fault and e-stop."""
    link[LINK_SESSION] = 0
    return clear_setpoints(link)


@hot
def link_reset(link: Ints, node: int) -> int:
    """Start the link of node 0 .. 12: no session, no SYNC seen, no set-point, counters zero."""
    for i in range(LINK_SIZE):
        link[i] = 0
    link[LINK_NODE] = node
    link[LINK_COUNTER] = -1
    return 0


@hot
def _add_up(link: Ints, place: int, more: int) -> int:
    """Add ``more`` >= 0 to a counter that stays at its largest value; return it."""
    if link[place] > _MOST - more:
        link[place] = _MOST
    else:
        link[place] = link[place] + more
    return link[place]


@hot
def _bad_frame(link) -> int:
    _add_up(link, LINK_BAD, 1)
    return FRAME_BAD


@hot
def _accept_setpoint(link: Ints, identifier: int, frame) -> int:
    """Keep this joint's slot of a set-point frame; FRAME_NOT_MINE for another group or "no change"."""
    node = link[LINK_NODE]
    if setpoint_group(identifier) != node_group(node) or node_group(node) < 0:
        return FRAME_NOT_MINE
    value = read_slot(frame, node_slot(node))
    if value == NO_CHANGE:
        return FRAME_NOT_MINE
    kind = setpoint_kind(identifier)
    if kind >= KIND_STIFFNESS and value < 0:
        return _bad_frame(link)
    link[LINK_PENDING + kind] = value
    link[LINK_PENDING_SET] = link[LINK_PENDING_SET] | (1 << kind)
    if kind <= KIND_IMPEDANCE:
        link[LINK_PENDING_MODE] = kind + 1
    return FRAME_SETPOINT


@hot
def _count_sync(link: Ints) -> int:
    """Count the SYNC frames missed since the last one; return how many, 0 .. 255."""
    counter = link[LINK_SYNC]
    missed = 0
    if link[LINK_COUNTER] >= 0:
        missed = (counter - link[LINK_COUNTER] - 1) & 0xFF
        _add_up(link, LINK_LOST, missed)
    link[LINK_COUNTER] = counter
    return missed


@hot
def _latch(link: Ints) -> int:
    """Move the pending set-points to the latched ones; FRAME_SYNC_SETPOINT if one carries a mode."""
    arrived = link[LINK_PENDING_SET]
    mode = link[LINK_PENDING_MODE]
    link[LINK_PENDING_SET] = 0
    link[LINK_PENDING_MODE] = 0
    for kind in range(SETPOINT_KINDS):
        if (arrived >> kind) & 1:
            link[LINK_LATCHED + kind] = link[LINK_PENDING + kind]
        elif mode and (kind == KIND_VELOCITY_FEEDFORWARD or kind == KIND_CURRENT_FEEDFORWARD):
            link[LINK_LATCHED + kind] = 0
    if mode == 0:
        return FRAME_SYNC
    link[LINK_MODE] = mode
    return FRAME_SYNC_SETPOINT


@hot
def _accept_sync(link: Ints, frame) -> int:
    """Count, then latch; SYNC of a host with another session changes nothing."""
    decode_sync(frame, link, LINK_SYNC)
    if link[LINK_SESSION] and link[LINK_SYNC + 1] != link[LINK_SESSION]:
        return FRAME_OTHER_SESSION
    _count_sync(link)
    return _latch(link)


@hot
def accept_frame(link: Ints, identifier: int, frame, length: int) -> int:
    """Take one received frame of ``length`` bytes; return FRAME_*.

    ``frame`` is an array('H') of four words. An e-stop counts whatever its length. Of a request only
    the address is looked at: decode_service_request reads it. Intermediates within 2^30.
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
    node = link[LINK_NODE]
    if identifier == SERVICE_REQUEST_ID or identifier == SERVICE_REQUEST_ID + node:
        if length < SERVICE_REQUEST_LENGTH:
            return _bad_frame(link)
        return FRAME_REQUEST
    if node and (identifier == HEARTBEAT_ID + node or identifier == REPLY_ID + node):
        return FRAME_TWIN
    return FRAME_NOT_MINE
