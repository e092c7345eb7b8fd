"""Identifiers of the CAN frames: a block of 128 for each kind, then the node, or the group and the set-point kind.

Identifier = block * 128 + rest. A block holds one kind of frame; the rest is the node (0 not assigned,
1 .. 12 = 1 + 3 * leg + joint), or for set-points 8 * group + kind. Nodes 1..4 are group 0, slots 0..3, and so on.
"""

from ..runtime import Ints, const, hot, ptr16
from .names import (
    E_STOP_ID,
    HEARTBEAT_ID,
    REPLY_ID,
    SERVICE_REQUEST_ID,
    SETPOINT_POSITION_ID,
    SYNC_ID,
    UPDATE_BLOCK_ID,
    UPDATE_REQUEST_ID,
)

NODES = const(12)  # the joints; node 0 has no id yet
SETPOINT_KINDS = const(8)
FILTERS = const(8)  # hardware filters of one joint
_BLOCK_MASK = const(0x780)
_REST_MASK = const(0x7F)
_ALL_BITS = const(0x7FF)
_GROUP_BITS = const(0x7F8)  # every set-point kind of one group
BLOCK_HIGH = const(1)  # bits of update_block's identifier: bit 16 of the block's number; the slot; 1 for the header
BLOCK_SLOT = const(2)
BLOCK_HEADER = const(4)
BLOCK_MASK = const(0x7FA)  # filter mask for all blocks of one slot


@hot
def frame_block(identifier: int) -> int:
    """Return the base identifier of the kind of frame (REPLY_ID, ...; SETPOINT_POSITION_ID for all set-points).

    -1 if ``identifier`` is not 0 .. 0x7FF. Exact; intermediates below 2^11.
    """
    if identifier < 0 or identifier > _ALL_BITS:
        return -1
    return identifier & _BLOCK_MASK


@hot
def frame_node(identifier: int) -> int:
    """Return the node, 0 .. 12, of a frame that belongs to one; -1 if there is no such node. Exact."""
    node = identifier & _REST_MASK
    if node > NODES:
        return -1
    return node


@hot
def setpoint_kind(identifier: int) -> int:
    """Return 0 .. 7, in the order of the identifiers 0x100 .. 0x107, of a set-point frame. Exact."""
    return identifier & (SETPOINT_KINDS - 1)


@hot
def setpoint_group(identifier: int) -> int:
    """Return the group, 0 .. 2, of a set-point frame; -1 if there is no such group. Exact."""
    group = (identifier & _REST_MASK) >> 3
    if group * 4 >= NODES:
        return -1
    return group


@hot
def node_group(node: int) -> int:
    """Return the set-point group of node 1 .. 12; -1 for the others. Exact."""
    if node < 1 or node > NODES:
        return -1
    return (node - 1) >> 2


@hot
def node_slot(node: int) -> int:
    """Return the place, 0 .. 3, of node 1 .. 12 in its group's frames. Exact."""
    return (node - 1) & 3


@hot
def read_slot(frame: Ints, slot: int) -> int:
    """Return the value of slot 0 .. 3 of a set-point frame, NO_CHANGE included. Exact."""
    words = ptr16(frame)
    return (words[slot & 3] ^ 0x8000) - 0x8000


@hot
def sync_counter(frame: Ints) -> int:
    """Return the counter of a SYNC frame, 0 .. 255. Exact."""
    words = ptr16(frame)
    return words[0] & 0xFF


@hot
def sync_session(frame: Ints) -> int:
    """Return the session of a SYNC frame, 0 .. 255. Exact."""
    words = ptr16(frame)
    return words[0] >> 8


@hot
def joint_filters(pairs: Ints, node: int) -> int:
    """Write the hardware filters of one joint, (identifier, mask) pairs; return how many there are.

    ``pairs`` is an array('H') of 2 * FILTERS. E-stop, SYNC, the set-points of its group, requests to it
    and to all, its own heartbeats and replies (hearing one of those means a second node has its id), updates of it.
    A node not assigned (0) needs no set-points and gets 4 filters.
    """
    table = ptr16(pairs)
    table[0] = E_STOP_ID
    table[2] = SYNC_ID
    table[4] = SERVICE_REQUEST_ID
    table[6] = SERVICE_REQUEST_ID | (node & _REST_MASK)
    table[1] = _ALL_BITS
    table[3] = _ALL_BITS
    table[5] = _ALL_BITS
    table[7] = _ALL_BITS
    if node < 1 or node > NODES:
        return 4
    table[8] = SETPOINT_POSITION_ID | (node_group(node) << 3)
    table[9] = _GROUP_BITS
    table[10] = HEARTBEAT_ID | node
    table[11] = _ALL_BITS
    table[12] = REPLY_ID | node
    table[13] = _ALL_BITS
    table[14] = UPDATE_REQUEST_ID | node
    table[15] = _ALL_BITS
    return FILTERS


@hot
def update_filters(pairs: Ints, node: int, slot: int) -> int:
    """Write the hardware filters of joint 1 .. 12 during an update of slot 0 or 1; return how many there are."""
    table = ptr16(pairs)
    table[0] = UPDATE_REQUEST_ID | node
    table[1] = _ALL_BITS
    table[2] = UPDATE_BLOCK_ID | slot << 1
    table[3] = BLOCK_MASK
    return 2
