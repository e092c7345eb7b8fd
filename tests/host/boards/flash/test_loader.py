"""The loader and the firmware's update on simulated flash: after any power cut, and any two, a sound slot starts."""

import binascii
import hashlib
import random
import re
import struct

import pytest

from firmware import flash_map as m
from firmware.flash_map import CONFIRMED, HEADER, Header, parse_header, sector_at, slot_at
from firmware.update import Update, UpdateError

from .loader import SOURCES, choose
from .sim_flash import Memory, PowerCut, SimFlash

BOARD = "CARAMELO_JOINT"


def slot_bytes(slot, text, image=None):
    image = image or (text.encode() * 64)[:64]
    digest = hashlib.sha256(image).digest()
    head = Header(slot, len(image), binascii.crc32(image), 7, digest, BOARD, text, "0.1.0", "joint")
    return head.pack() + image


def board(a="one", b=None, records=()):
    """Return a flash whose slots hold these builds, and these boot records."""
    store = Memory()
    for slot, text in enumerate((a, b)):
        if text:
            store.write(slot_at(slot), slot_bytes(slot, text))
    for place, record in enumerate(records):
        store.write(sector_at(m.RECORDS_SECTOR) + 8 * place, m.pack_record(*record))
    return SimFlash(store)


def nothing():
    pass


def install(flash, running, text):
    """Do what `caramelo flash` does on the board, up to the reset."""
    update = Update(flash, running, BOARD)
    new = slot_bytes(1 - running, text)
    for sector in update.begin(new[:HEADER], False):
        update.erase(sector)
    for at in range(HEADER, len(new), 16):
        update.write(at - HEADER, new[at : at + 16])
    update.finish(nothing)
    update.activate()


def start(flash):
    """Return the slot that starts, after a check that it is sound."""
    slot = choose(flash)
    assert slot in (0, 1)
    assert Update(flash, slot, BOARD).is_whole(slot, nothing)
    return slot


def test_a_new_board_starts_what_it_has():
    assert choose(board()) == 0
    assert choose(board(None, "two")) == 1
    assert choose(board(None, None)) == -1


def test_a_trial_is_counted_and_ends_with_the_other_slot():
    flash = board("one", "two", [(0, CONFIRMED), (1, 3)])
    assert [start(flash) for _ in range(5)] == [1, 1, 1, 0, 0]
    assert Update(flash, 0, BOARD).wished() == (1, 0)


def test_a_confirmed_slot_stays():
    flash = board("one", "two", [(1, 3)])
    assert start(flash) == 1
    Update(flash, 1, BOARD).confirm()
    assert [start(flash) for _ in range(5)] == [1] * 5


def test_a_trial_without_another_sound_slot_goes_on():
    flash = board(None, "two", [(1, 3)])
    assert [start(flash) for _ in range(6)] == [1] * 6


def test_a_trial_that_cannot_be_counted_is_not_started():
    flash = board("one", "two", [(0, CONFIRMED)] * 2047 + [(1, 3)])
    assert start(flash) == 0


@pytest.mark.parametrize("at", [0, 4, 8, 12, 16, 100, HEADER - 4, HEADER, HEADER + 63])
def test_a_damaged_slot_is_not_started(at):
    flash = board("one", "two", [(1, CONFIRMED)])
    flash.store.data[slot_at(1) + at] ^= 0x40
    assert start(flash) == 0


def test_no_damage_in_one_direction_makes_a_record_of_anything():
    drawn = random.Random(3)
    for _ in range(20000):
        record = m.pack_record(drawn.randrange(2), drawn.choice([0, 1, 2, 3, CONFIRMED]))
        word = int.from_bytes(record, "little")
        more = word | drawn.getrandbits(64) & drawn.getrandbits(64)  # half written, or half erased
        assert more == word or m.parse_record(more.to_bytes(8, "little")) is None


def test_the_loader_and_the_firmware_say_the_same_of_the_flash():
    text = (SOURCES / "loader.h").read_text()

    def number(name):
        return eval(re.search(rf"#define {name} ([^/\n]+)", text)[1].replace("u", ""), {"HEADER_BYTES": HEADER})

    assert (number("RECORDS_AT"), number("RECORDS_BYTES")) == (sector_at(m.RECORDS_SECTOR), m.sector_bytes(1))
    assert (number("HEADER_BYTES"), number("IMAGE_MOST"), number("CONFIRMED")) == (HEADER, m.IMAGE_MOST, CONFIRMED)
    assert struct.pack("<II", number("HEADER_MAGIC"), number("HEADER_FORMAT")) == slot_bytes(0, "x")[:8]
    assert number("RECORD_MAGIC").to_bytes(4, "little")[2:] == m.pack_record(0, 0)[2:4]
    assert (slot_at(0), slot_at(1)) == (0x10000, 0x80000)


def test_headers_survive_packing_and_no_bit_of_them_may_change():
    data = slot_bytes(1, "build")[:HEADER]
    header = parse_header(data)
    assert (header.slot, header.build, header.board, header.role, header.protocol) == (1, "build", BOARD, "joint", 7)
    for bit in range(HEADER * 8):
        assert parse_header(bytes(b ^ (1 << bit % 8 if at == bit // 8 else 0) for at, b in enumerate(data))) is None


def life(flash, text="new"):
    """Let the board be updated from whatever runs now, and the new firmware confirm itself, as far as power lasts."""
    running = start(flash)
    install(flash, running, text)
    running = start(flash)
    Update(flash, running, BOARD).confirm()


SITUATIONS = {
    "first update": lambda: board(),
    "third update": lambda: board("one", "two", [(0, CONFIRMED), (1, 3), (1, 2), (1, CONFIRMED)]),
    "on trial": lambda: board("one", "two", [(0, CONFIRMED), (1, 3)]),
    "trial used up": lambda: board("one", "two", [(0, CONFIRMED), (1, 0)]),
    "full records": lambda: board("one", "two", [(0, CONFIRMED)] * 2046),
}


def whole_life(situation):
    flash = SITUATIONS[situation]()
    life(flash)
    return flash.done


@pytest.mark.parametrize("situation", SITUATIONS)
def test_a_cut_in_any_write_leaves_a_board_that_starts_and_can_be_updated(situation):
    kept = SITUATIONS[situation]().store.data
    builds = set()
    for cut in range(1, whole_life(situation) + 1):
        flash = SimFlash(Memory(kept), cut, cut * 991)
        with pytest.raises(PowerCut):
            life(flash)
        flash.cut = 0
        slot = start(flash)
        builds.add(parse_header(flash.view(slot_at(slot), HEADER)).build)
        life(flash, "newer")
        slot = start(flash)
        assert parse_header(flash.view(slot_at(slot), HEADER)).build == "newer"
    assert builds <= {"one", "two", "new"}
    assert "new" in builds  # the cuts after the switch


@pytest.mark.parametrize("situation", SITUATIONS)
def test_a_second_cut_while_the_board_recovers_leaves_one_that_starts(situation):
    kept = SITUATIONS[situation]().store.data
    drawn = random.Random(situation)
    count = whole_life(situation)
    for _ in range(60):
        flash = SimFlash(Memory(kept), drawn.randint(1, count), drawn.randrange(65537))
        with pytest.raises(PowerCut):
            life(flash)
        flash.done, flash.cut = 0, drawn.randint(1, count)
        try:
            life(flash, "newer")
        except PowerCut:
            flash.cut = 0
        start(flash)


@pytest.mark.parametrize(
    ("change", "armed", "words"),
    [
        (lambda data: b"\xff" * HEADER, False, "not the header of an image"),
        (lambda data: data, True, "the joint is armed"),
        (lambda data: slot_bytes(0, "new")[:HEADER], False, "an image for slot a, from which this board runs"),
        (
            lambda data: Header(1, 64, 0, 0, bytes(32), "CARAMELO_GAIT", "x", "1", "gait").pack(),
            False,
            "an image for CARAMELO_GAIT; this board is a CARAMELO_JOINT",
        ),
    ],
)
def test_what_is_not_for_this_slot_is_refused_before_anything_is_erased(change, armed, words):
    flash = board("one", "two")
    before = bytes(flash.store.data)
    update = Update(flash, 0, BOARD)
    with pytest.raises(UpdateError, match=words):
        update.begin(change(slot_bytes(1, "new")[:HEADER]), armed)
    with pytest.raises(UpdateError, match="is not to be erased"):
        update.erase(8)
    assert bytes(flash.store.data) == before


def test_an_image_that_reads_back_differently_is_not_made_sound():
    flash = board("one", "two")
    update = Update(flash, 0, BOARD)
    new = slot_bytes(1, "new")
    for sector in update.begin(new[:HEADER], False):
        update.erase(sector)
    update.write(0, new[HEADER:-4] + b"????")
    with pytest.raises(UpdateError, match="reads back as something else"):
        update.finish(nothing)
    assert update.header(1) is None
    with pytest.raises(UpdateError, match="slot b holds no whole image"):
        update.activate()
    assert start(flash) == 0
