"""CAN frames on the host: one buffer seen as words by the integer codec and as bytes by the bus, and their names."""

from __future__ import annotations

import sys
from array import array
from collections.abc import Callable
from functools import cache, partial
from typing import Any, NamedTuple

from shared.record import pack, unpack
from shared.wire import codec

from . import dbc
from .dbc import Message, Signal
from .generate_codec import record_name

if sys.byteorder != "little":  # the codec's words are the frame's bytes only on little-endian machines
    raise ImportError("the CAN protocol needs a little-endian machine")


class Frame(NamedTuple):
    """The codec reads and writes ``words``; ``data`` is the same eight bytes."""

    words: array[int]
    data: memoryview


class Kind(NamedTuple):
    """The meaning of an identifier: the message, its node or group, and its codec."""

    message: Message
    instance: int
    encode: Callable[[array[int], Any], int]
    decode: Callable[[array[int], Any], int]

    def values(self) -> Any:
        """Return the codec's values: the message's record, else an array."""
        made = getattr(codec, record_name(self.message.codec or self.message.name), None)
        return made() if made else array("i", [0] * len(self.message.signals))


def new_frame() -> Frame:
    """Return an empty frame, to keep and reuse."""
    words = array("H", (0, 0, 0, 0))
    return Frame(words, memoryview(words).cast("B"))


@cache
def kinds() -> dict[int, Kind]:
    """Return every identifier of the protocol with its meaning."""
    found = {}
    for message in dbc.load():
        name = message.codec or message.name
        encode = getattr(codec, f"encode_{name}", partial(_pack, message.signals))
        decode = getattr(codec, f"decode_{name}", partial(_unpack, message.signals))
        for instance, identifier in enumerate(message.identifiers, message.first):
            found[identifier] = Kind(message, instance, encode, decode)
    return found


def _pack(signals: tuple[Signal, ...], words: array[int], values: Any) -> int:
    """Encode like the codec, for a frame for which the core has no encode."""
    whole = clipped = 0
    for signal, raw in zip(signals, pack(values), strict=True):
        limited = raw if raw == signal.special else max(signal.low, min(signal.high, raw))
        clipped += limited != raw
        whole |= (limited & (1 << signal.length) - 1) << signal.start
    words[:] = array("H", (whole >> 16 * place & 0xFFFF for place in range(4)))
    return clipped


def _unpack(signals: tuple[Signal, ...], words: array[int], values: Any) -> int:
    """Decode like the codec, for a frame for which the core has no decode."""
    whole = sum(word << 16 * place for place, word in enumerate(words))
    raws = [_signed(signal, whole >> signal.start & (1 << signal.length) - 1) for signal in signals]
    unpack(values, raws)
    return sum(raw != s.special and not s.low <= raw <= s.high for s, raw in zip(signals, raws, strict=True))


def _signed(signal: Signal, raw: int) -> int:
    return raw - (1 << signal.length) if signal.signed and raw >> signal.length - 1 else raw


def encode(identifier: int, values: list[int]) -> tuple[bytes, int]:
    """Return the bytes of a frame from raw values in the order of its fields, and how many were limited.

    For tools and tests; loops keep their own Frame and call the codec.
    """
    kind, frame = kinds()[identifier], new_frame()
    clipped = kind.encode(frame.words, unpack(kind.values(), values))
    return bytes(frame.data[: kind.message.length]), clipped


def decode(identifier: int, data: bytes) -> tuple[list[int], int] | None:
    """Return the raw values of a frame and how many are out of range; None if unknown or too short."""
    kind = kinds().get(identifier)
    if kind is None or len(data) < kind.message.length:
        return None
    frame, values = new_frame(), kind.values()
    frame.data[: kind.message.length] = data[: kind.message.length]
    outside = kind.decode(frame.words, values)
    return pack(values), outside


def describe(identifier: int, data: bytes) -> dict[str, float | str] | None:
    """Return the fields of a frame in the units of joints.dbc, named values as words; None if unknown or too short."""
    decoded, kind = decode(identifier, data), kinds().get(identifier)
    if decoded is None or kind is None:
        return None
    return {s.name: _field(s, raw) for s, raw in zip(kind.message.signals, decoded[0], strict=True)}


def _field(signal: Signal, raw: int) -> float | str:
    if signal.is_flags:
        return " ".join(word for bit, word in signal.choices if raw & bit) or "none"
    return dict(signal.choices).get(raw, float(raw * signal.factor + signal.offset))
