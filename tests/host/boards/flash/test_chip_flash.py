"""The flash controller's driver against a model of it made from RM0090, section 3: keys, program, erase, errors."""

import pytest

from firmware.chip_flash import ChipFlash
from firmware.flash_map import BASE, SIZE, sector_at, sector_bytes

ACR, KEYR, SR, CR = 0x40023C00, 0x40023C04, 0x40023C0C, 0x40023C10
PG, SER, STRT, LOCK = 1, 2, 1 << 16, 1 << 31
BSY, WRPERR, PGSERR = 1 << 16, 1 << 4, 1 << 7
CACHES, CACHE_RESETS = 3 << 9, 3 << 11


class Controller:
    """The registers and the memory behind them; operations last a few looks at BSY."""

    def __init__(self):
        self.memory = bytearray(b"\x00" * SIZE)
        self.registers = {ACR: 0x705, SR: 0, CR: LOCK}
        self.keys, self.busy, self.protected, self.stale = [], 0, False, False
        self.acr_written = []

    def read(self, address):
        if address == SR:
            self.busy = max(0, self.busy - 1)
            return self.registers[SR] | (BSY if self.busy else 0)
        return self.registers[address]

    def write(self, address, value):
        assert not self.busy, "no register is written while the controller works"
        if BASE <= address < BASE + SIZE:
            self._program(address - BASE, value)
        elif address == KEYR:
            self.keys.append(value)
            if self.keys[-2:] == [0x45670123, 0xCDEF89AB]:
                self.registers[CR] &= ~LOCK
        elif address == SR:
            self.registers[SR] &= ~value
        elif address == CR:
            assert not self.registers[CR] & LOCK, "CR is written while it is locked"
            self.registers[CR] = value
            if value & STRT:
                self._erase(value >> 3 & 15)
        else:
            self.acr_written.append(value)
            # Section 3.9.1: the caches may be reset only while they are off
            assert not (value & CACHE_RESETS and value & CACHES)
            self.stale = self.stale and value & CACHE_RESETS != CACHE_RESETS
            self.registers[ACR] = value

    def _program(self, at, value):
        if self.protected:
            self.registers[SR] |= WRPERR
        elif not self.registers[CR] & PG or self.registers[CR] >> 8 & 3 != 2:
            self.registers[SR] |= PGSERR
        else:
            word = int.from_bytes(self.memory[at : at + 4], "little") & value
            self.memory[at : at + 4] = word.to_bytes(4, "little")
            self.busy, self.stale = 3, True

    def _erase(self, sector):
        assert self.registers[CR] & SER
        at, count = sector_at(sector), sector_bytes(sector)
        self.memory[at : at + count] = b"\xff" * count
        self.busy, self.stale = 5, True


class Places:
    """Registers as the driver's pointers see them, ``size`` bytes each."""

    def __init__(self, controller, base, size):
        self.controller, self.base, self.size = controller, base, size

    def __getitem__(self, index):
        return self.controller.read(self.base + self.size * index)

    def __setitem__(self, index, value):
        self.controller.write(self.base + self.size * index, value & (1 << 8 * self.size) - 1)


class Handle:
    """What stands for an address on the chip."""

    def __init__(self, controller, base):
        self.words, self.halves = Places(controller, base, 4), Places(controller, base, 2)


class Driver(ChipFlash):
    """The driver, whose memory is the controller's."""

    def __init__(self, controller):
        super().__init__(Handle(controller, 0x40000000), Handle(controller, BASE))
        self.controller = controller

    def view(self, at, count):
        return self.controller.memory[at : at + count]


@pytest.fixture
def chip():
    controller = Controller()
    return Driver(controller), controller


def settled(controller):
    """The controller as every operation has to leave it: locked, caches as before, nothing stale in them."""
    return (bool(controller.registers[CR] & LOCK), controller.registers[ACR], controller.stale) == (True, 0x705, False)


@pytest.mark.parametrize("sector", range(12))
def test_a_sector_is_erased_and_no_other(chip, sector):
    driver, controller = chip
    driver.erase(sector)
    at, count = sector_at(sector), sector_bytes(sector)
    assert controller.memory == bytes(at) + b"\xff" * count + bytes(SIZE - at - count)
    assert settled(controller)


def test_words_are_written_and_read_back(chip):
    driver, controller = chip
    driver.erase(5)
    data = bytes(range(64))
    for at in (sector_at(5), sector_at(5) + 64):
        driver.program(at, data)
        assert driver.view(at, 64) == data
        assert settled(controller)
    driver.program(sector_at(5) + 128, b"\xff\xff\xff\x80")  # the sign bit of a word
    assert driver.view(sector_at(5) + 128, 4) == b"\xff\xff\xff\x80"


def test_what_was_not_erased_is_told(chip):
    driver, controller = chip
    with pytest.raises(OSError, match=r"flash 0x20000: reads back something else: was it erased"):
        driver.program(sector_at(5), b"data")
    assert settled(controller)


def test_a_protected_place_is_told_and_the_next_operation_works(chip):
    driver, controller = chip
    driver.erase(5)
    controller.protected = True
    with pytest.raises(OSError, match=r"flash 0x20000: this place is protected"):
        driver.program(sector_at(5), b"data")
    assert settled(controller)
    controller.protected = False
    driver.program(sector_at(5), b"data")
    assert driver.view(sector_at(5), 4) == b"data"


def test_only_whole_words_are_written(chip):
    driver, controller = chip
    for at, data in ((2, b"data"), (0, b"dat")):
        with pytest.raises(OSError, match="only whole words"):
            driver.program(at, data)
    assert controller.keys == []
