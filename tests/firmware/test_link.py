"""The link's frames, bit for bit those of its first implementation, which is kept here: it read byte by byte."""

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


def first_crc16(data, start, end):
    crc = 0xFFFF
    for i in range(start, end):
        crc ^= data[i] << 8
        for _ in range(8):
            crc = (crc << 1) ^ 0x1021 if crc & 0x8000 else crc << 1
            crc &= 0xFFFF
    return crc


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
        if first_crc16(self.buffer, 0, end) != self.buffer[end] | self.buffer[end + 1] << 8:
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


class FirstWriter:
    def __init__(self, kind):
        self.buffer = bytearray(link.LARGEST + 6)
        self.buffer[0] = link.SYNC_0
        self.buffer[1] = link.SYNC_1
        self.buffer[2] = kind
        self._at = 4

    def put(self, value, size):
        for _ in range(size):
            self.buffer[self._at] = value & 0xFF
            value >>= 8
            self._at += 1

    def close(self):
        end = self._at
        self.buffer[3] = end - 4
        crc = first_crc16(self.buffer, 2, end)
        self.buffer[end] = crc & 0xFF
        self.buffer[end + 1] = crc >> 8
        return bytes(self.buffer[: end + 2])


def first_frame(kind, values, size):
    writer = FirstWriter(kind)
    for value in values:
        writer.put(value, size)
    return writer.close()


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
def test_a_frame_made_is_the_firsts(size, data):
    most = (1 << 8 * size - 1) - 1
    values = data.draw(st.lists(st.integers(-most - 1, most), max_size=link.LARGEST // size))
    kind = data.draw(st.integers(1, 255))
    assert frame(kind, values, size) == first_frame(kind, values, size)


def test_the_boards_frames_are_the_firsts():
    numbers = gait.BoardStatus()
    for _ in range(200):
        joints = [NOISE.randrange(-32768, 32768) for _ in range(12)]
        numbers.tick_count, numbers.flags = NOISE.randrange(1 << 30), NOISE.randrange(1 << 24)
        numbers.question = NOISE.randrange(256)
        planned = Status()
        unpack(planned, [NOISE.randrange(256) for _ in pack(planned)])
        setpoints, reading = bytearray(gait.SETPOINTS_BYTES), bytearray(gait.READING_BYTES)
        gait.write_setpoints(setpoints, numbers, planned, joints)
        writer = FirstWriter(link.SETPOINTS)
        writer.put(numbers.tick_count, 4)
        writer.put(numbers.flags, 4)
        writer.put(planned.state, 1)
        writer.put(planned.gait, 1)
        for angle in joints:
            writer.put(angle, 2)
        assert setpoints == writer.close()
        fault = NOISE.randrange(5)
        gait.write_reading(reading, numbers, fault, joints[:6])
        writer = FirstWriter(link.READING)
        writer.put(numbers.question, 1)
        writer.put(fault, 1)
        for count in joints[:6]:
            writer.put(count, 2)
        assert reading == writer.close()


# Whole frames, torn ones, and what looks like the start of one
PIECE = st.one_of(
    st.binary(max_size=20),
    st.sampled_from([b"\xca", b"\xca\xca\x5e", b"\xca\x5e\x01\x41", b"\xca\x5e\x01\x40", b"\xca\x5e"]),
    st.builds(first_frame, st.integers(0, 255), st.lists(st.integers(0, 255), max_size=64), st.just(1)),
    st.builds(
        lambda whole, at, bit: bytes(b ^ (1 << bit if i == at % len(whole) else 0) for i, b in enumerate(whole)),
        st.builds(first_frame, st.integers(1, 8), st.lists(st.integers(0, 255), max_size=64), st.just(1)),
        st.integers(0, 99), st.integers(0, 7),
    ),
    st.builds(lambda n: first_frame(2, [7] * 24, 1)[:n], st.integers(0, 30)),
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
        whole = first_frame(NOISE.randrange(1, 8), [NOISE.randrange(256) for _ in range(NOISE.randrange(65))], 1)
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
