"""The journal of settings on simulated flash: what was put is found again; a power cut leaves the old or the new."""

import random

import pytest

from firmware.flash_map import SETTINGS_SECTORS, sector_at, sector_bytes
from firmware.settings import Journal

from .sim_flash import Memory, PowerCut, SimFlash


def fresh():
    """Return a new board's flash with its journal begun."""
    flash = SimFlash(Memory())
    Journal(flash).tidy()
    return flash


def test_what_was_put_last_is_found_after_a_power_cycle():
    flash = fresh()
    journal = Journal(flash)
    assert journal.get("joint") is None
    for value in (b"one", b"two", b""):
        assert journal.put("joint", value) == 1
    assert journal.put("log", b"\xff\xff\xff\xff") == 1
    for again in (journal, Journal(flash)):
        assert (again.get("joint"), again.get("log"), again.get("node")) == (b"", b"\xff\xff\xff\xff", None)


def test_a_journal_never_begun_keeps_nothing():
    flash = SimFlash(Memory(bytes(range(256)) * 4096))
    journal = Journal(flash)
    assert journal.put("joint", b"x") == 0
    assert flash.done == 0
    journal.tidy()
    assert journal.put("joint", b"x") == 1
    assert Journal(flash).get("joint") == b"x"


def test_a_full_journal_refuses_and_has_room_after_the_next_start():
    flash = fresh()
    journal = Journal(flash)
    count = 0
    while journal.put("joint", bytes([count]) * 700):
        count += 1
    assert count > 20
    assert Journal(flash).get("joint") == bytes([count - 1]) * 700
    for _ in range(3):
        journal = Journal(flash)
        journal.tidy()
        for again in range(20):
            assert journal.put("joint", bytes([again]) * 700) == 1
        assert Journal(flash).get("joint") == bytes([19]) * 700


def test_flash_that_reads_back_something_else_is_a_failure_and_the_old_value_stays():
    flash = fresh()
    journal = Journal(flash)
    journal.put("joint", b"old.")
    at = sector_at(SETTINGS_SECTORS[0])
    flash.store.data[at + 100 : at + 112] = bytes(12)  # worn out: stuck at zero
    while journal.put("joint", b"new" * 10):
        pass
    kept = Journal(flash).get("joint")
    assert kept in (b"old.", b"new" * 10)
    assert journal.get("joint") == kept
    assert journal.put("joint", b"next") == 1  # behind the bad place
    assert Journal(flash).get("joint") == b"next"


def one_life(flash):
    """Start, make room, save parameters and a line of the log; return what has surely been put."""
    journal = Journal(flash)
    journal.tidy()
    number = 1 + int((journal.get("joint") or b"0").split()[0])
    put = {}
    for key, value in (("joint", b"%d " % number * 90), ("log", b"start %d" % number)):
        if journal.put(key, value):
            put[key] = value
    return put


def lives_to_a_swap():
    """Return a flash that is about to swap its sectors."""
    flash = fresh()
    while Journal(flash)._end < 4096:
        one_life(flash)
    return flash


@pytest.mark.parametrize("begin", [lambda: SimFlash(Memory()), fresh, lives_to_a_swap], ids=["new", "begun", "swap"])
def test_a_cut_in_any_write_leaves_the_old_or_the_new(begin):
    kept = begin().store.data
    before = {key: Journal(SimFlash(Memory(kept))).get(key) for key in ("joint", "log")}
    flash = SimFlash(Memory(kept))
    after = one_life(flash)
    for cut in range(1, flash.done + 1):
        torn = SimFlash(Memory(kept), cut, cut * 31)
        with pytest.raises(PowerCut):
            one_life(torn)
        torn.cut = 0
        found = Journal(torn)
        for key in ("joint", "log"):
            assert found.get(key) in (before[key], after[key])
        assert set(one_life(torn)) == {"joint", "log"}  # and it goes on


def test_a_long_random_life_with_cuts_never_loses_what_was_kept():
    drawn = random.Random(11)
    flash, kept = fresh(), {}
    for _ in range(100):
        flash.done, flash.cut = 0, drawn.choice([0, drawn.randint(1, 600)])
        journal = Journal(flash)
        goal = {}
        try:
            journal.tidy()
            for key in drawn.sample(["joint", "log", "node"], 2):
                goal = {key: drawn.randbytes(drawn.choice([0, 1, 4, 63, 700]))}
                if journal.put(key, goal[key]):
                    kept |= goal
                goal = {}
        except PowerCut:
            pass
        flash.cut = 0
        again = Journal(flash)
        for key, value in kept.items():
            assert again.get(key) in (value, goal.get(key, value))
        kept |= {key: again.get(key) for key in goal if again.get(key) is not None}


def test_nothing_is_written_outside_of_the_settings_sectors():
    flash = lives_to_a_swap()
    one_life(flash)
    first, end = sector_at(SETTINGS_SECTORS[0]), sector_at(SETTINGS_SECTORS[1]) + sector_bytes(SETTINGS_SECTORS[1])
    data = flash.store.data
    assert set(data[:first]) | set(data[end:]) == {0xFF}
