"""The loader as it is flashed, on an emulated Cortex-M4 with the flash controller of the model of the chip.

Nothing of the loader's own sources is used here but the program that ARM's compiler makes of it.
"""

import shutil
import struct

import pytest

from firmware.flash_map import BASE, CONFIRMED, HEADER, IMAGE_MOST, SIZE, read_records, slot_at
from host.boards.build.board_image import build_loader
from host.boards.runtimes.cortex_m import instructions
from host.sim import chip as model
from host.sim.chip.flash import LOCK

from . import test_loader

unicorn = pytest.importorskip("unicorn")
if shutil.which("arm-none-eabi-gcc") is None:
    pytest.skip("ARM's compiler is not installed: gcc-arm-none-eabi", allow_module_level=True)

RAM, CCM, SYSTEM = 0x20000000, 0x10000000, 0x1FFF0000
CONTROLLER, SYSCFG, CORE = 0x40023000, 0x40013000, 0xE000E000
ACCESS_CYCLES = 500  # slow, but a word takes some of them
STACK, ENTRY = 0x1000FFF8, 0x401


def board(records=(), slots="ab", length=1024):
    """Return a flash with images in these slots, whose vectors name their stack and first instruction, and records."""
    flash = test_loader.board(None, None, records)
    for name in slots:
        slot = "ab".index(name)
        data = struct.pack("<II", STACK, BASE + slot_at(slot) + ENTRY).ljust(length, b"\x5a")
        flash.store.write(slot_at(slot), test_loader.slot_bytes(slot, "b", data))
    return flash


@pytest.fixture(scope="module")
def loader(tmp_path_factory):
    return build_loader(tmp_path_factory.mktemp("loader"))


class Chip:
    """An STM32F405 as far as the loader goes: runs from reset to the first instruction outside of sector 0."""

    def __init__(self, loader, flash):
        from unicorn import arm_const as arm

        self.arm, self.flash = arm, flash
        flash.store.write(0, loader)
        self.model, self.count = model.Chip(), 0
        self.model.flash.contents[:] = flash.store.data
        uc = self.uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        uc.mem_map(BASE, SIZE)
        uc.mem_map(RAM, 0x20000)
        uc.mem_map(CCM, 0x10000)
        uc.mem_write(CCM, b"\x77" * 0x10000)
        uc.mem_map(SYSTEM, 0x8000)
        uc.mem_map(CORE, 0x1000)
        uc.mem_map(SYSCFG, 0x1000)
        uc.mem_write(SYSTEM, RAM.to_bytes(4, "little") + (SYSTEM + 0x101).to_bytes(4, "little"))
        uc.mmio_map(CONTROLLER, 0x1000, self._read, None, self._write, None)
        uc.mem_write(BASE, bytes(flash.store.data))
        uc.hook_add(unicorn.UC_HOOK_MEM_WRITE, self._program, None, BASE, BASE + SIZE)
        uc.hook_add(unicorn.UC_HOOK_BLOCK, self._block)

    def run(self):
        """Return where the processor went."""
        stack, entry = (int.from_bytes(self.uc.mem_read(BASE + at, 4), "little") for at in (0, 4))
        self.uc.reg_write(self.arm.UC_ARM_REG_SP, stack)
        self.uc.emu_start(entry, 0, timeout=60_000_000)
        self.flash.store.data[:] = self.model.flash.contents
        return self.uc.reg_read(self.arm.UC_ARM_REG_PC)

    def _block(self, uc, address, size, data):
        if not BASE <= address < BASE + 0x4000:
            uc.emu_stop()
            return
        self.count += instructions(bytes(uc.mem_read(address, size)))

    def _read(self, uc, offset, size, data):
        self.model.advance(ACCESS_CYCLES)
        return self.model.read(CONTROLLER + offset, size)

    def _write(self, uc, offset, size, value, data):
        self.model.write(CONTROLLER + offset, value, size)

    def _program(self, uc, access, address, size, value, data):
        self.model.write(address, value & 0xFFFFFFFF, size)

    def word(self, address):
        """Return a word of memory."""
        return int.from_bytes(self.uc.mem_read(address, 4), "little")


def started(loader, flash):
    """Return the slot that the loader jumps into as the processor would, or "dfu"."""
    chip = Chip(loader, flash)
    at = chip.run()
    assert chip.model.complaints == []
    assert chip.model.flash.value["CR"] & LOCK
    assert bytes(chip.uc.mem_read(CCM, 0x10000)) == b"\x77" * 0x10000  # MicroPython's note over a reset
    if at & ~1 == SYSTEM + 0x100:
        assert chip.word(SYSCFG + 0x800) == 1
        return "dfu"
    slot = "ab"[[BASE + slot_at(slot) + (ENTRY & ~1) for slot in (0, 1)].index(at & ~1)]
    assert chip.uc.reg_read(chip.arm.UC_ARM_REG_SP) == STACK
    assert chip.uc.reg_read(chip.arm.UC_ARM_REG_R0) == 0
    assert chip.word(CORE + 0xD08) == BASE + slot_at("ab".index(slot)) + HEADER
    return slot


@pytest.mark.parametrize(
    ("records", "slots", "expected"),
    [
        ((), "ab", "a"),
        ((), "b", "b"),
        ((), "", "dfu"),
        (((1, CONFIRMED),), "ab", "b"),
        (((1, CONFIRMED),), "a", "a"),
        (((0, CONFIRMED), (1, 0)), "ab", "a"),
    ],
)
def test_the_loader_starts_the_right_slot_on_the_processor(loader, records, slots, expected):
    assert started(loader, board(records, slots)) == expected


def test_a_trial_is_counted_in_flash_on_the_processor(loader):
    flash = board([(0, CONFIRMED), (1, 2)])
    assert started(loader, flash) == "b"
    assert read_records(flash.view(0x4000, 0x4000))[0] == (1, 1)
    assert [started(loader, flash) for _ in range(2)] == ["b", "a"]


def test_the_largest_image_is_checked_in_a_blink(loader):
    """At the reset's 16 MHz the flash has no wait states: an instruction takes one to two cycles."""
    chip = Chip(loader, board(slots="a", length=IMAGE_MOST))
    chip.run()
    print(f"{chip.count} instructions: {chip.count / 16000:.0f} ms at one cycle each, {chip.count / 8000:.0f} at two")
    assert chip.count < 2_500_000


def test_the_loader_fits_its_sector(loader):
    assert len(loader) < 4096
