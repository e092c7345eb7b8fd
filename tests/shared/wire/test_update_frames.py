"""What must never change: a joint of any age is updated by these frames. A failure here means that it no longer is."""

from array import array

from firmware.can_update import HEADER_BLOCKS, LOOK_FLAGS, VERSION
from firmware.flash_blocks import BLOCK_BYTES
from firmware.flash_map import Header, parse_header
from shared.record import unpack
from shared.wire import codec, framing, names
from shared.wire.codec import Heartbeat, UpdateAnswer, UpdateMissing, UpdateRequest

IDENTIFIERS = {"UPDATE_REQUEST": 0x480, "UPDATE_BLOCK": 0x500, "UPDATE_MISSING": 0x580, "UPDATE_ANSWER": 0x600}
COMMANDS = ("LOOK", "BEGIN", "ERASE", "MISSING", "VERIFY", "SWITCH", "CONFIRM", "CANCEL")
STATES = ("RUNNING", "WAITING", "CHECKED", "ERASING", "TAKING", "WHOLE", "REFUSED", "FAILED", "LEAVING")
REASONS = (
    "NONE", "ARMED", "NO_FLASH", "OTHER_UPDATE", "NOT_A_HEADER", "OTHER_BOARD", "RUNNING_SLOT", "OTHER_IMAGE",
    "NO_MEMORY", "FLASH", "DIFFERENT", "WRONG_STATE",
)  # fmt: skip


def encoded(encode, record, *values):
    frame = array("H", [0] * 4)
    assert encode(frame, unpack(record, values)) == 0
    return frame.tobytes()


def test_identifiers_and_words_are_those_of_the_first_version():
    assert {name: getattr(names, f"{name}_ID") for name in IDENTIFIERS} == IDENTIFIERS
    assert [getattr(names, f"UPDATE_{word}") for word in COMMANDS] == list(range(1, 9))
    assert [getattr(names, f"UPDATE_IS_{word}") for word in STATES] == list(range(9))
    assert [getattr(names, f"UPDATE_WHY_{word}") for word in REASONS] == list(range(12))
    assert (framing.BLOCK_HIGH, framing.BLOCK_SLOT, framing.BLOCK_HEADER) == (1, 2, 4)
    assert (BLOCK_BYTES, HEADER_BLOCKS, LOOK_FLAGS, VERSION) == (6, 86, 128, 1)


def test_the_bytes_of_the_frames_are_those_of_the_first_version():
    request = encoded(codec.encode_update_request, UpdateRequest(), 2, 0x4D, 0x0102, 0x1234, 0xFEDC)
    assert request == bytes.fromhex("024d02013412dcfe")
    answer = encoded(codec.encode_update_answer, UpdateAnswer(), 4, 0x4D, 5, 10, 7, 0x1234, 0xFEDC)
    assert answer == bytes.fromhex("044da5073412dcfe")
    missing = encoded(codec.encode_update_missing, UpdateMissing(), 1, 0x1FFFF, 0x10000)
    assert int.from_bytes(missing, "little") == 1 | 0x1FFFF << 17 | 0x10000 << 34


def test_an_old_joint_is_known_by_its_heartbeat():
    beat = Heartbeat()
    codec.decode_heartbeat(array("H", bytes.fromhex("51003412ff000000")), beat)
    assert (beat.state, beat.mode, beat.fault, beat.protocol_hash) == (1, 5, 0, 0x1234)


def test_the_words_of_a_header_lie_where_they_lay():
    header = Header(1, 4, 0, 0x1234, bytes(32), "BOARD", "0123456789abcdef", "0.1.0", "joint").pack()
    assert parse_header(header) is not None
    assert (header[20:24], header[56:61], header[72:88]) == (b"\x34\x12\0\0", b"BOARD", b"0123456789abcdef")
    assert (header[88:93], header[104:109]) == (b"0.1.0", b"joint")
