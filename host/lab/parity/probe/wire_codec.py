"""shared/wire/codec.py: every frame, encoded from any numbers and decoded from any bits."""

from array import array

from shared.record import size_of
from shared.wire import codec

from .draw import INT30, Range
from .probe import Block, Probe

WORD = Range(0, 65535)
FRAME = Block(array("H", [0] * 4), (4, WORD))
VALUES = {
    "sync": codec.Sync(),
    "group": array("i", [0] * 4),
    "fault": codec.Fault(),
    "reply": codec.Reply(),
    "slow_status": codec.SlowStatus(),
    "heartbeat": codec.Heartbeat(),
    "service_request": codec.ServiceRequest(),
    "service_response": codec.ServiceResponse(),
    "update_request": codec.UpdateRequest(),
    "update_answer": codec.UpdateAnswer(),
    "update_missing": codec.UpdateMissing(),
}


def _codec(name):
    values = VALUES[name[7:]]  # behind "encode_" or "decode_"
    block = Block(values, (size_of(values), INT30))
    return Probe(codec, name, (FRAME, block), watch=(FRAME.array, values))


PROBES = tuple([_codec(name) for name in sorted(dir(codec)) if name.startswith(("encode_", "decode_"))])
