"""Reads the parts of an MCAP file in order: the robot's data, messages with their channels, the end.

mcap decodes the parts. This module splits the file and its chunks into parts, because an hour has over a million and
mcap's own reader takes longer for that than for all the rest.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import Any

MAGIC = b"\x89MCAP0\r\n"
LARGEST_PART = 1 << 28  # bytes, also of a chunk once it is decompressed
_FOOTER, _CHANNEL, _MESSAGE, _CHUNK, _METADATA = 0x02, 0x04, 0x05, 0x06, 0x0C  # opcodes of the MCAP specification
_READ = (_FOOTER, _CHANNEL, _MESSAGE, _CHUNK, _METADATA)
_HEAD = struct.Struct("<BQ")  # opcode, length
_MESSAGE_HEAD = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time


@dataclass(frozen=True)
class Channel:
    """A message's channel; ``encoding`` is json in our own records."""

    topic: str
    encoding: str


Message = tuple[Channel, int, bytes]  # with the log time, ns, and the content
Part = list[Message] | dict[str, str] | bool  # of metadata: what it says; of the end: True
Channels = dict[int, Channel]


class BadPart(Exception):
    """A part that is not MCAP, or damaged."""


class NoMcap(Exception):
    """The file does not begin like an MCAP file."""


def parts(file: Any, metadata: str) -> Iterator[Part]:
    """Yield messages, each metadata of that name, and True at the end.

    NoMcap; BadPart or an error of mcap or its decompressor where the file is damaged or cut off.
    """
    from mcap import records as r

    channels: Channels = {}
    for opcode, data in _top(file):
        if opcode == _CHUNK:
            yield list(_messages(_decompressed(r.Chunk.read(_stream(data))), channels))
        elif opcode == _METADATA:
            found = r.Metadata.read(_stream(data))
            if found.name == metadata:
                yield dict(found.metadata)
        elif opcode == _FOOTER:
            yield True
        elif opcode == _MESSAGE:
            yield [_message(data, channels)]
        else:
            _learn(data, channels)


def _top(file: Any) -> Iterator[tuple[int, bytes]]:
    """Yield opcode and content of the file's parts that matter, up to the footer and the magic behind it."""
    if file.read(len(MAGIC)) != MAGIC:
        raise NoMcap
    while True:
        head = file.read(_HEAD.size)
        if len(head) < _HEAD.size:
            raise BadPart("the file is cut off")
        opcode, length = _HEAD.unpack(head)
        if length > LARGEST_PART:
            raise BadPart("a part is larger than a record's largest")
        data = file.read(length)
        if len(data) < length or (opcode == _FOOTER and file.read() != MAGIC):
            raise BadPart("the file is cut off")
        if opcode in _READ:
            yield opcode, data
        if opcode == _FOOTER:
            return


def _decompressed(chunk: Any) -> bytes:
    """Return a chunk's content; refuses one that would fill the memory."""
    from mcap.stream_reader import get_chunk_data_stream
    from zstandard import frame_content_size

    if chunk.compression not in ("zstd", ""):
        raise BadPart(f"a chunk is compressed with {chunk.compression}, not with zstd")
    size = frame_content_size(chunk.data) if chunk.compression else 0
    if max(size, chunk.uncompressed_size) > LARGEST_PART:
        raise BadPart("a chunk is larger than a record's largest")
    stream, length = get_chunk_data_stream(chunk, validate_crc=True)
    return stream.read(length)


def _messages(data: bytes, channels: Channels) -> Iterator[Message]:
    """Yield a chunk's messages, and note the channels that it defines."""
    at = 0
    while at < len(data):
        opcode, length = _HEAD.unpack_from(data, at)
        at += _HEAD.size
        content = data[at : at + length]
        if len(content) < length:
            raise BadPart("a chunk ends within a part")
        if opcode == _MESSAGE:
            yield _message(content, channels)
        elif opcode == _CHANNEL:
            _learn(content, channels)
        at += length


def _message(data: bytes, channels: Channels) -> Message:
    number, _, time_ns, _ = _MESSAGE_HEAD.unpack_from(data)
    if number not in channels:
        raise BadPart(f"a message belongs to channel {number}, which the file does not define")
    return channels[number], time_ns, data[_MESSAGE_HEAD.size :]


def _learn(data: bytes, channels: Channels) -> None:
    from mcap.records import Channel as Record

    record = Record.read(_stream(data))
    channels[record.id] = Channel(record.topic, record.message_encoding)


def _stream(data: bytes) -> Any:
    from mcap.data_stream import ReadDataStream

    return ReadDataStream(BytesIO(data))
