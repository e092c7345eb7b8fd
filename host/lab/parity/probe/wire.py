"""shared/wire: access, framing, identity, and a joint's end of the bus under any frames."""

from array import array

from shared.wire import access, framing, identity, limits, receive
from shared.wire.names import HEARTBEAT_ID, SERVICE_REQUEST_ID, SETPOINT_POSITION_ID, SYNC_ID
from shared.wire.parameters import PARAMETERS

from .draw import Range
from .draws import INT30
from .probe import Block, Probe

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
        values[1] = COMMON[dice.below(len(COMMON))]
        values[3] = 8
    if dice.below(30) == 0:
        receive.link_reset(LINK, dice.below(5))
    if dice.below(30) == 0:
        LINK.lost_syncs = (1 << 30) - 2
    if dice.below(30) == 0:
        receive.start_session(LINK, 1 + dice.below(255))


def _probe(source, name, arguments, watch=(), begin=None, fit=None, ticks=True, vectors=1):
    function = getattr(source, name)
    return Probe(name, function, arguments, watch=watch, begin=begin, fit=fit, ticks=ticks, vectors=vectors)


PROBES = (
    Probe("limit_but", limits.limit_but, (INT30, INT30, INT30, INT30), fit=_order),
    Probe("differs", limits.differs, (SMALL, SMALL)),
    Probe("outside", limits.outside, (INT30, INT30, INT30, INT30), fit=_order),
    _probe(access, "may_read", (PARAMETER,)),
    _probe(access, "may_write", (PARAMETER, INT30, Range(0, 1)), vectors=2),
    _probe(access, "is_stored", (PARAMETER,)),
    _probe(framing, "frame_block", (IDENTIFIER,)),
    _probe(framing, "frame_node", (IDENTIFIER,)),
    _probe(framing, "setpoint_kind", (IDENTIFIER,)),
    _probe(framing, "setpoint_group", (IDENTIFIER,)),
    _probe(framing, "node_group", (Range(-1, 14),)),
    _probe(framing, "node_slot", (Range(1, 12),)),
    _probe(framing, "read_slot", (FRAME, Range(0, 3))),
    _probe(framing, "sync_counter", (FRAME,)),
    _probe(framing, "sync_session", (FRAME,)),
    _probe(framing, "joint_filters", (PAIRS, NODE), watch=(PAIRS,)),
    _probe(framing, "update_filters", (PAIRS, NODE, Range(0, 1)), watch=(PAIRS,)),
    _probe(identity, "board_id", (UNIQUE,), ticks=False),
    _probe(identity, "discover_delay_ms", (Range(0, (1 << 30) - 1), Range(0, 255)), ticks=False),
    _probe(receive, "clear_setpoints", (LINK,), watch=(LINK,), begin=_begin, fit=_soil),
    _probe(receive, "start_session", (LINK, Range(1, 255)), watch=(LINK,), begin=_begin, fit=_soil),
    _probe(receive, "end_session", (LINK,), watch=(LINK,), begin=_begin, fit=_soil),
    _probe(receive, "link_reset", (LINK, NODE), watch=(LINK,), begin=_begin, fit=_soil),
    _probe(
        receive,
        "accept_frame",
        (LINK, IDENTIFIER, FRAME, Range(0, 8)),
        watch=(LINK,),
        begin=_begin,
        fit=_traffic,
        vectors=4,
    ),
)
