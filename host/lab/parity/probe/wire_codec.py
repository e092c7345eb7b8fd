"""shared/wire/codec.py: every frame, encoded from any numbers and decoded from any bits."""

from array import array

from shared.wire import codec

from .draw import Range
from .draws import INT30
from .probe import Block, Probe

SOURCES = ("wire.codec",)

FIELDS = 10
WORD = Range(0, 65535)
FRAME = Block(array("H", [0] * 4), (4, WORD))
VALUES = Block(array("i", [0] * FIELDS), (FIELDS, INT30))


def _codec(name):
    arguments = (FRAME, VALUES)
    return Probe(name, getattr(codec, name), arguments, watch=(FRAME.array, VALUES.array))


PROBES = tuple([_codec(name) for name in sorted(dir(codec)) if name.startswith(("encode_", "decode_"))])
