"""shared/wire: access, framing, identity, and a joint's end of the bus under any frames."""

from array import array

from shared.wire import access, framing, identity, limits, receive
from shared.wire.names import HEARTBEAT_ID, SERVICE_REQUEST_ID, SETPOINT_POSITION_ID, SYNC_ID
from shared.wire.parameters import PARAMETERS

from .draw import FLAG, INT30, Range
from .probe import Block, Probe, probe_with

PARAMETER = Range(-2, PARAMETERS + 2)
IDENTIFIER = Range(-2, 0x801)
NODE = Range(0, 12)
SMALL = Range(-1, 1)
FRAME = Block(array("H", [0] * 4), (4, Range(0, 65535)))
PAIRS = array("H", [0] * (2 * framing.FILTERS))
LINK = receive.Link()
UNIQUE = Block(array("H", [0] * 12), (12, Range(0, 255)))
COMMON = (
    SYNC_ID,
    SYNC_ID,
    SETPOINT_POSITION_ID,
    SETPOINT_POSITION_ID + 4,
    SETPOINT_POSITION_ID + 6,
    SETPOINT_POSITION_ID + 8,
    HEARTBEAT_ID + 1,
    SERVICE_REQUEST_ID,
)


def _order(values, dice):
    """A range from low to high; now and then its ends, and the special value itself."""
    if values[1] > values[2]:
        values[1], values[2] = values[2], values[1]
    if dice.below(2) == 0:
        values[0] = values[1 + dice.below(3)]


def _begin():
    receive.link_reset(LINK, 1)


def _soil(values, dice):
    LINK.session = dice.bits(12)
    LINK.counter = dice.bits(12)
    LINK.lost_syncs = dice.bits(12)
    LINK.bad_frames = dice.bits(12)
    LINK.pending_set = dice.bits(12)
    LINK.pending_mode = dice.bits(12)
    LINK.mode = dice.bits(12)
    for kind in range(framing.SETPOINT_KINDS):
        LINK.pending[kind] = dice.bits(12)
        LINK.latched[kind] = dice.bits(12)


def _traffic(values, dice):
    """Mostly frames that concern the joint, of any bits; now and then another node or a session."""
    if dice.below(4):
        values[1] = dice.choose(COMMON)
        values[3] = 8
    if dice.below(30) == 0:
        receive.link_reset(LINK, dice.below(5))
    if dice.below(30) == 0:
        LINK.lost_syncs = (1 << 30) - 2
    if dice.below(30) == 0:
        receive.start_session(LINK, 1 + dice.below(255))


_linked = probe_with(watch=(LINK,), begin=_begin, fit=_soil)

PROBES = (
    Probe(limits, "limit_but", (INT30, INT30, INT30, INT30), fit=_order),
    Probe(limits, "differs", (SMALL, SMALL)),
    Probe(limits, "outside", (INT30, INT30, INT30, INT30), fit=_order),
    Probe(access, "may_read", (PARAMETER,)),
    Probe(access, "may_write", (PARAMETER, INT30, FLAG), vectors=2),
    Probe(access, "is_stored", (PARAMETER,)),
    Probe(framing, "frame_block", (IDENTIFIER,)),
    Probe(framing, "frame_node", (IDENTIFIER,)),
    Probe(framing, "setpoint_kind", (IDENTIFIER,)),
    Probe(framing, "setpoint_group", (IDENTIFIER,)),
    Probe(framing, "node_group", (Range(-1, 14),)),
    Probe(framing, "node_slot", (Range(1, 12),)),
    Probe(framing, "read_slot", (FRAME, Range(0, 3))),
    Probe(framing, "sync_counter", (FRAME,)),
    Probe(framing, "sync_session", (FRAME,)),
    Probe(framing, "joint_filters", (PAIRS, NODE), watch=(PAIRS,)),
    Probe(framing, "update_filters", (PAIRS, NODE, FLAG), watch=(PAIRS,)),
    Probe(identity, "board_id", (UNIQUE,), ticks=False),
    Probe(identity, "discover_delay_ms", (Range(0, (1 << 30) - 1), Range(0, 255)), ticks=False),
    _linked(receive, "clear_setpoints", (LINK,)),
    _linked(receive, "start_session", (LINK, Range(1, 255))),
    _linked(receive, "end_session", (LINK,)),
    _linked(receive, "link_reset", (LINK, NODE)),
    _linked(receive, "accept_frame", (LINK, IDENTIFIER, FRAME, Range(0, 8)), fit=_traffic, vectors=4),
)
