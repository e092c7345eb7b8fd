"""The flash controller's driver on the model of the chip (RM0090, section 3): keys, program, erase, errors, caches."""

from types import SimpleNamespace

import pytest

from firmware.chip_flash import ChipFlash
from firmware.flash_map import BASE, SIZE, sector_at, sector_bytes
from host.sim.chip import flash as model
from host.sim.chip.chip import Chip
from host.sim.chip.view import View

PERIPHERALS, ACR = 0x40000000, 0x40023C00
CACHES, CACHE_RESETS = 3 << 9, 3 << 11
WRPERR = 1 << 4
ACCESS_CYCLES = 500  # slow, but a word takes some of them


class Driver(ChipFlash):
    """The driver on the model, whose memory is looked at without a wait."""

    def __init__(self, chip):
        memory = (View(chip, base, 4, ACCESS_CYCLES) for base in (PERIPHERALS, BASE))
        super().__init__(*(SimpleNamespace(words=words) for words in memory))
        self.contents = chip.flash.contents

    def view(self, at, count):
        return self.contents[at : at + count]


@pytest.fixture
def chip(monkeypatch):
    """Return the driver and the chip, whose flash is all zeros; ``written``: where to, ``stale``: what the caches hold.

    A write while the flash works is an error here, as is a reset of caches that are on (section 3.9.1).
    """
    monkeypatch.setattr(model, "ERASE_MS", dict.fromkeys(model.ERASE_MS, ((0.02,) * 3,) * 2))  # few looks at BSY
    chip = Chip()
    chip.flash.contents[:] = bytes(SIZE)
    chip.written, chip.stale = [], False
    write = chip.write

    def watched(address, value, size):
        assert chip.now >= chip.flash.busy_until, "nothing is written while the controller works"
        chip.written.append(address)
        if address == ACR:
            assert not (value & CACHE_RESETS and value & CACHES)
            chip.stale = chip.stale and value & CACHE_RESETS != CACHE_RESETS
        write(address, value, size)

    chip.write = watched
    chip.flash.step = lambda what, address, value: setattr(chip, "stale", True)
    return Driver(chip), chip


def settled(chip):
    """The controller as every operation has to leave it: locked, caches as before, nothing stale in them."""
    return (bool(chip.flash.value["CR"] & model.LOCK), chip.flash.value["ACR"], chip.stale) == (True, 0x705, False)


@pytest.mark.parametrize("sector", range(12))
def test_a_sector_is_erased_and_no_other(chip, sector):
    driver, chip = chip
    driver.erase(sector)
    at, count = sector_at(sector), sector_bytes(sector)
    assert chip.flash.contents == bytes(at) + b"\xff" * count + bytes(SIZE - at - count)
    assert settled(chip)
    assert chip.complaints == []


def test_words_are_written_and_read_back(chip):
    driver, chip = chip
    driver.erase(5)
    data = bytes(range(64))
    for at in (sector_at(5), sector_at(5) + 64):
        driver.program(at, data)
        assert driver.view(at, 64) == data
        assert settled(chip)
    driver.program(sector_at(5) + 128, b"\xff\xff\xff\x80")  # the sign bit of a word
    assert driver.view(sector_at(5) + 128, 4) == b"\xff\xff\xff\x80"
    assert chip.complaints == []


def test_what_was_not_erased_is_told(chip):
    driver, chip = chip
    with pytest.raises(OSError, match=r"flash 0x20000: reads back something else: was it erased"):
        driver.program(sector_at(5), b"data")
    assert settled(chip)


def test_a_protected_place_is_told_and_the_next_operation_works(chip, monkeypatch):
    driver, chip = chip
    driver.erase(5)

    def refuse(address, value, size):
        chip.flash.value["SR"] |= WRPERR

    with monkeypatch.context() as protected:
        protected.setattr(chip.flash, "program", refuse)
        with pytest.raises(OSError, match=r"flash 0x20000: this place is protected"):
            driver.program(sector_at(5), b"data")
    assert settled(chip)
    driver.program(sector_at(5), b"data")
    assert driver.view(sector_at(5), 4) == b"data"


def test_only_whole_words_are_written(chip):
    driver, chip = chip
    for at, data in ((2, b"data"), (0, b"dat")):
        with pytest.raises(OSError, match="only whole words"):
            driver.program(at, data)
    assert chip.written == []
