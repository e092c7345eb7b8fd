"""Frame lengths of the bus load against a second way of counting, and the share the joints may take."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.bus.can import load as busload
from host.protocol import frames

FRAME = st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8))


def polynomial_remainder(bits):
    """CRC-15 as the remainder of one big number over GF(2)."""
    number = int("".join(map(str, bits)) + "0" * 15, 2)
    for place in range(number.bit_length() - 1, 14, -1):
        if number >> place & 1:
            number ^= 0xC599 << (place - 15)
    return number


def stuffed_text(bits):
    """Stuffing by text replacement, left to right: after five equal characters the other one."""
    text, done = "".join(map(str, bits)), ""
    while found := re.search(r"0{5}|1{5}", text):
        end = found.end()
        inserted = "1" if text[end - 1] == "0" else "0"
        done, text = done + text[:end], inserted + text[end:]
    return done + text


def test_crc_of_the_published_check():
    bits = [byte >> place & 1 for byte in b"123456789" for place in range(7, -1, -1)]
    assert busload.crc15(bits) == 0x059E


@given(FRAME)
def test_frame_bits_equal_a_second_count(frame):
    identifier, data = frame
    region = busload.stuffed_region(identifier, data)
    assert int("".join(map(str, region[-15:])), 2) == polynomial_remainder(region[:-15])
    assert len(region) == 34 + 8 * len(data)
    assert busload.frame_bits(identifier, data) == len(stuffed_text(region)) + 13
    assert len(region) + 13 <= busload.frame_bits(identifier, data) <= busload.worst_bits(len(data))


def test_worst_lengths_of_the_literature():
    assert [busload.worst_bits(n) for n in (0, 1, 2, 4, 6, 8)] == [55, 65, 75, 95, 115, 135]


@pytest.mark.parametrize(("identifier", "data"), [(0x800, b""), (-1, b""), (1, bytes(9))])
def test_frames_that_do_not_exist_are_refused(identifier, data):
    with pytest.raises(ValueError, match=r"allowed 0..0x7ff with 0..8 bytes"):
        busload.frame_bits(identifier, data)


def test_twelve_joints_at_200_hz_take_at_most_40_percent():
    rows = busload.busload(busload.default_schedule())
    total = rows[-1]
    assert total.name == "total"
    assert total.worst_share <= 0.40
    assert total.worst_share == pytest.approx(sum(row.worst_share for row in rows[:-1]))
    assert total.frames_per_s == 200 * (1 + 3 + 12) + 12 * 10
    assert all(row.typical_bits <= row.worst_bits for row in rows)
    assert sum(1e-6 * 200 * n * bits for n, bits in ((1, 75), (3, 135), (12, 115))) < total.worst_share
    slower = busload.busload(busload.default_schedule(), busload.BITRATE // 2)[-1]
    assert slower.worst_share == pytest.approx(2 * total.worst_share)


def test_typical_equals_what_the_samples_take_when_sent():
    schedule = busload.default_schedule()
    sent = [item.samples[i % len(item.samples)] for item in schedule for i in range(int(item.rate_hz) * 60)]
    total = busload.busload(schedule)[-1]
    share = sum(busload.frame_bits(*frame) for frame in sent) / (60.0 * busload.BITRATE)
    assert share == pytest.approx(total.typical_share, rel=0.01)


def test_samples_are_frames_of_the_protocol():
    for item in busload.default_schedule(setpoints=tuple(busload.SETPOINTS)):
        for identifier, data in item.samples:
            assert frames.decode(identifier, data)[1] == 0
            assert len(data) == item.length


def test_unknown_set_points_and_nodes_are_refused():
    for arguments in ({"setpoints": ("torque",)}, {"nodes": (13,)}, {"nodes": ()}):
        with pytest.raises(ValueError, match="allowed position"):
            busload.default_schedule(**arguments)
