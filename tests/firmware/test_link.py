"""The link's frames, bit for bit those of the first reader, which is kept here: it read byte by byte."""

import binascii
import itertools
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware import gait, link
from host.protocol.gait_frames import FrameReader, frame
from shared.planner.status import Status
from shared.record import pack, unpack

NOISE = random.Random(7)


class FirstReader:
    def __init__(self):
        self.buffer = bytearray(link.LARGEST + 4)
        self.length = 0
        self.broken = 0
        self._at = -2

    def take(self, byte):
        if self._at < 0:
            self._find_sync(byte)
            return 0
        self.buffer[self._at] = byte
        self._at += 1
        if self._at == 2 and byte > link.LARGEST:
            return self._drop()
        if self._at < 2 or self._at < self.buffer[1] + 4:
            return 0
        self._at = -2
        end = self.buffer[1] + 2
        if binascii.crc_hqx(self.buffer[:end], 0xFFFF) != self.buffer[end] | self.buffer[end + 1] << 8:
            return self._drop()
        self.length = end - 2
        return self.buffer[0]

    def _find_sync(self, byte):
        if self._at == -2:
            if byte == link.SYNC_0:
                self._at = -1
        elif byte == link.SYNC_1:
            self._at = 0
        elif byte != link.SYNC_0:
            self._at = -2

    def _drop(self):
        self._at = -2
        self.broken += 1
        return 0


def frame_of(kind, *fields):
    """Return the frame of a kind whose payload are fields: a number and its bytes."""
    payload = b"".join((value & (1 << 8 * size) - 1).to_bytes(size, "little") for value, size in fields)
    body = bytes((kind, len(payload))) + payload
    return bytes((link.SYNC_0, link.SYNC_1)) + body + binascii.crc_hqx(body, 0xFFFF).to_bytes(2, "little")


def frame_of_bytes(kind, values):
    return frame_of(kind, *((value, 1) for value in values))


def first_frames(data):
    reader, found = FirstReader(), []
    for byte in data:
        kind = reader.take(byte)
        if kind:
            found.append((kind, bytes(reader.buffer[2 : 2 + reader.length])))
    return found, reader.broken


def in_pieces(data, cuts):
    reader, found = FrameReader(), []
    places = [0, *sorted(cuts), len(data)]
    for start, end in itertools.pairwise(places):
        found += reader.frames(data[start:end])
    return found, reader.broken


@given(st.binary(max_size=70))
def test_the_crc_is_ccitt_false(data):
    assert link.crc16(data, 0, len(data)) == binascii.crc_hqx(data, 0xFFFF)
    assert link.crc16(b"ab" + data + b"c", 2, 2 + len(data)) == binascii.crc_hqx(data, 0xFFFF)


def test_the_crcs_check_value():
    assert link.crc16(b"123456789", 0, 9) == 0x29B1


@pytest.mark.parametrize("size", [1, 2, 4])
@given(data=st.data())
def test_a_frame_made_is_as_its_fields_say(size, data):
    most = (1 << 8 * size - 1) - 1
    values = data.draw(st.lists(st.integers(-most - 1, most), max_size=link.LARGEST // size))
    kind = data.draw(st.integers(1, 255))
    assert frame(kind, values, size) == frame_of(kind, *((value, size) for value in values))


def test_the_boards_frames_are_as_their_fields_say():
    numbers = gait.BoardStatus()
    for _ in range(200):
        joints = [NOISE.randrange(-32768, 32768) for _ in range(12)]
        numbers.tick_count, numbers.flags = NOISE.randrange(1 << 30), NOISE.randrange(1 << 24)
        numbers.question = NOISE.randrange(256)
        planned = Status()
        unpack(planned, [NOISE.randrange(256) for _ in pack(planned)])
        setpoints, reading = bytearray(gait.SETPOINTS_BYTES), bytearray(gait.READING_BYTES)
        gait.write_setpoints(setpoints, numbers, planned, joints)
        head = ((numbers.tick_count, 4), (numbers.flags, 4), (planned.state, 1), (planned.gait, 1))
        assert setpoints == frame_of(link.SETPOINTS, *head, *((angle, 2) for angle in joints))
        fault = NOISE.randrange(5)
        gait.write_reading(reading, numbers, fault, joints[:6])
        counts = ((count, 2) for count in joints[:6])
        assert reading == frame_of(link.READING, (numbers.question, 1), (fault, 1), *counts)


# Whole frames, torn ones, and what looks like the start of one
PIECE = st.one_of(
    st.binary(max_size=20),
    st.sampled_from([b"\xca", b"\xca\xca\x5e", b"\xca\x5e\x01\x41", b"\xca\x5e\x01\x40", b"\xca\x5e"]),
    st.builds(frame_of_bytes, st.integers(0, 255), st.binary(max_size=64)),
    st.builds(
        lambda whole, at, bit: bytes(b ^ (1 << bit if i == at % len(whole) else 0) for i, b in enumerate(whole)),
        st.builds(frame_of_bytes, st.integers(1, 8), st.binary(max_size=64)),
        st.integers(0, 99), st.integers(0, 7),
    ),
    st.builds(lambda n: frame_of_bytes(2, [7] * 24)[:n], st.integers(0, 30)),
)  # fmt: skip


@settings(max_examples=300)
@given(st.lists(PIECE, max_size=8), st.data())
def test_any_split_of_a_stream_gives_the_frames_of_reading_byte_by_byte(pieces, data):
    stream = b"".join(pieces)
    cuts = data.draw(st.lists(st.integers(0, len(stream)), max_size=12))
    assert in_pieces(stream, cuts) == first_frames(stream)


@pytest.mark.parametrize("block", [1, 2, 7, 64, 100_000])
def test_frames_among_noise_are_the_firsts(block):
    stream = bytearray()
    for _ in range(800):
        stream += NOISE.randbytes(NOISE.randrange(90))
        whole = frame_of_bytes(NOISE.randrange(1, 8), [NOISE.randrange(256) for _ in range(NOISE.randrange(65))])
        stream += whole[: NOISE.choice([len(whole), len(whole), NOISE.randrange(len(whole))])]
    expected = first_frames(stream)
    assert len(expected[0]) > 300
    assert in_pieces(bytes(stream), range(block, len(stream), block)) == expected


def test_noise_never_becomes_a_command():
    assert FrameReader().frames(NOISE.randbytes(200_000)) == []


@given(st.integers(-(1 << 31), (1 << 31) - 1), st.integers(-32768, 32767))
def test_numbers_are_read_back(wide, narrow):
    wide_bytes = b"x" + wide.to_bytes(4, "little", signed=True)
    assert link.read_int30(wide_bytes, 1) == max(-(1 << 30), min((1 << 30) - 1, wide))
    assert link.read_int16(b"xy" + narrow.to_bytes(2, "little", signed=True), 2) == narrow
