"""Real images, started by the loader on an emulated Cortex-M4: MicroPython comes up and runs what is frozen into it.

Registers of the chip hold what was written to them, and say "ready" where MicroPython waits for that: nothing answers
on any bus. Time passes by instructions. Printing is caught where MicroPython hands it to USB.
"""

import bisect
import subprocess
from collections import Counter

import pytest

from firmware.flash_map import BASE, HEADER, sector_at, sector_bytes, slot_at
from host.boards.build import toolchain
from host.boards.build.board_image import BOARD
from host.boards.runtimes.cortex_m import instructions

from ..runtimes.test_image import build_from_sources
from .sim_flash import Memory

unicorn = pytest.importorskip("unicorn")
pytestmark = pytest.mark.slow

RCC_CR, RCC_CFGR, OTG_RESET, CAN_MCR, CAN_MSR = 0x40023800, 0x40023808, 0x50000010, 0x40006400, 0x40006404
TIM5_CNT, RNG_SR = 0x40000C24, 0x50060804
TIM1_DIER, TIM1_SR, ADC_SR = 0x4001000C, 0x40010010, (0x40012000, 0x40012100, 0x40012200)
TIM1_UP = 16 + 25  # its place among the vectors, RM0090 table 62
FLASH_SR, FLASH_CR, ERASE_NOW, VTOR = 0x40023C0C, 0x40023C10, 1 << 16 | 2, 0xE000ED08
MEMORIES = {0x20000000: 0x20000, 0x10000000: 0x10000, 0x1FFF0000: 0x10000, 0xE0000000: 0x100000}
PERIPHERALS = {0x40000000: 0x80000, 0x50000000: 0x61000}
BIT_BAND = 0x42000000
BLOCKS_PER_MS = 2000  # so that time passes at about the speed of a real chip
SLICE_US = 60_000_000  # without any waiting of the processor's in it


@pytest.fixture(scope="module", params=BOARD)
def built(request, tmp_path_factory):
    """Return an image and its programs' folder."""
    folder = tmp_path_factory.mktemp(request.param)
    return build_from_sources(request.param, folder).image, folder


class Chip:
    """An STM32F405 that says "ready" to everything; ``said`` is what was printed."""

    def __init__(self, image, slot, elf):
        from unicorn import arm_const as arm

        self.arm, self.said, self.failure, self._blocks, self._wanted = arm, b"", "", 0, b""
        self._registers = {RCC_CR: 0x83}
        symbols = subprocess.run([toolchain.NM, str(elf)], capture_output=True, text=True, check=True).stdout
        places = {line.split()[2]: int(line.split()[0], 16) for line in symbols.splitlines() if len(line.split()) == 3}
        self._functions = sorted((place & ~1, name) for name, place in places.items() if place < BASE + 0x100000)
        self._spent = Counter()
        self._tick, self._print = places["uwTick"], places["mp_hal_stdout_tx_strn"] & ~1
        store = Memory()
        store.write(0, image.loader)
        store.write(slot_at(slot), image.slots[slot])
        uc = self.uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        uc.mem_map(BASE, len(store.data))
        uc.mem_write(BASE, bytes(store.data))
        for at, size in MEMORIES.items():
            uc.mem_map(at, size)
        for at, size in PERIPHERALS.items():
            uc.mmio_map(at, size, self._read, at, self._write, at)
        uc.mmio_map(BIT_BAND, 0x2000000, lambda *_: 0, None, self._write_bit, None)
        uc.hook_add(unicorn.UC_HOOK_BLOCK, self._block)
        uc.hook_add(unicorn.UC_HOOK_INTR, self._exception)
        stack, self._at = (int.from_bytes(store.data[place : place + 4], "little") for place in (0, 4))
        uc.reg_write(arm.UC_ARM_REG_SP, stack)

    def run_until(self, words, slices=20_000):
        """Run until these words were printed; AssertionError with what was printed if that takes too long."""
        self._wanted = words
        for _ in range(slices):
            if words in self.said:
                return
            self.uc.emu_start(self._at | 1, 0, timeout=SLICE_US)
            assert not self.failure, f"{self.failure}: {self.said!r}"
            self._at = self.uc.reg_read(self.arm.UC_ARM_REG_PC)
            self._next_ms()  # it waits for an interrupt (WFI): a millisecond is over
        raise AssertionError(f"{words!r} was not printed, but {self.said!r}")

    def start_application(self):
        """Go on until the interrupt of timer 1 is on; AssertionError if that takes too long."""
        self._wanted = b"no such words"
        for _ in range(1000):
            if self._registers.get(TIM1_DIER, 0) & 1:
                return
            self.uc.emu_start(self._at | 1, 0, timeout=SLICE_US // 100)
            assert not self.failure, f"{self.failure}: {self.said!r}"
            self._at = self.uc.reg_read(self.arm.UC_ARM_REG_PC)
            self._next_ms()
        raise AssertionError(f"no interrupt was switched on: {self.said!r}")

    def interrupt(self, number):
        """Take an interrupt whose flags are there, from its vector to its return; return instructions by function."""
        self._registers |= dict.fromkeys(ADC_SR, 6) | {TIM1_SR: 1, 0x40013008: 1}
        table = int.from_bytes(self.uc.mem_read(VTOR, 4), "little")
        handler = int.from_bytes(self.uc.mem_read(table + 4 * number, 4), "little")
        self._spent.clear()
        self.uc.reg_write(self.arm.UC_ARM_REG_LR, BASE | 1)
        self.uc.emu_start(handler | 1, BASE, timeout=SLICE_US)
        assert self.uc.reg_read(self.arm.UC_ARM_REG_PC) == BASE, self.failure
        return dict(self._spent)

    def _read(self, uc, offset, size, base):
        address, shift = base + (offset & ~3), 8 * (offset & 3)
        value = self._registers.get(address, 0)
        if address == RCC_CR:  # oscillators and PLLs are ready as soon as they are on
            value = value & ~0xA020002 | (value & 0x5010001) << 1
        elif address == RCC_CFGR:
            value = value & ~0xC | (value & 3) << 2
        elif address == OTG_RESET:  # idle, no reset going on
            value = value & ~0x31 | 1 << 31
        elif address == TIM5_CNT:  # microseconds
            value = self._blocks * 1000 // BLOCKS_PER_MS
        elif address == RNG_SR:
            value = 1
        elif address == CAN_MSR:
            value = value & ~3 | self._registers.get(CAN_MCR, 0) & 3
        return value >> shift & (1 << 8 * size) - 1

    def _write(self, uc, offset, size, value, base):
        address, shift = base + (offset & ~3), 8 * (offset & 3)
        mask = (1 << 8 * size) - 1 << shift
        value = self._registers.get(address, 0) & ~mask | value << shift & mask
        self._registers[address] = 0 if address == FLASH_SR else value  # its errors are cleared by writing ones
        if address == FLASH_CR and value & ERASE_NOW == ERASE_NOW:
            sector = value >> 3 & 15
            uc.mem_write(BASE + sector_at(sector), b"\xff" * sector_bytes(sector))

    def _write_bit(self, uc, offset, size, value, data):
        address, bit = 0x40000000 + (offset >> 5 & ~3), offset >> 2 & 31
        self._registers[address] = self._registers.get(address, 0) & ~(1 << bit) | (value & 1) << bit

    def _block(self, uc, address, size, data):
        self._blocks += 1
        where = self._functions[bisect.bisect_right(self._functions, (address, "~")) - 1][1]
        self._spent[where] += instructions(bytes(uc.mem_read(address, size)))
        if self._blocks % BLOCKS_PER_MS == 0:
            self._next_ms()
        if address == self._print:
            place, count = uc.reg_read(self.arm.UC_ARM_REG_R0), uc.reg_read(self.arm.UC_ARM_REG_R1)
            self.said += bytes(uc.mem_read(place, count)) if count else b""
            if self._wanted in self.said:
                uc.emu_stop()

    def _next_ms(self):
        now = int.from_bytes(self.uc.mem_read(self._tick, 4), "little") + 1
        self.uc.mem_write(self._tick, now.to_bytes(4, "little"))

    def _exception(self, uc, number, data):
        self.failure = f"exception {number} at {uc.reg_read(self.arm.UC_ARM_REG_PC):#x}"
        uc.emu_stop()


@pytest.mark.parametrize("slot", [0, 1])
def test_the_loader_starts_micropython_and_that_the_application(built, slot):
    image, folder = built
    chip = Chip(image, slot, folder / f"slot_{'ab'[slot]}.elf")
    chip.run_until(f"firmware started from slot {'ab'[slot]}".encode())
    vectors = int.from_bytes(chip.uc.mem_read(VTOR, 4), "little")
    assert vectors == BASE + slot_at(slot) + HEADER  # ST's start-up code would leave the loader's


@pytest.mark.parametrize("built", ["joint"], indirect=True)
def test_the_interrupt_is_short_from_its_vector_to_its_return(built):
    """With the bridge off, as nothing answers here; what driving adds is `caramelo firmware measure`'s."""
    image, folder = built
    chip = Chip(image, 0, folder / "slot_a.elf")
    chip.run_until(b"firmware started from slot a")
    chip.start_application()
    spent = chip.interrupt(TIM1_UP)
    own = {name for name in spent if name.startswith(("firmware_", "shared_"))}
    steps = {"firmware_chip_step__interrupt", "shared_joint_current__current_step"}
    assert steps <= {name.partition(".")[0] for name in own}  # the compiler adds .constprop.0 and the like
    way = sum(count for name, count in spent.items() if name not in own)
    print(f"{way} instructions of MicroPython's, {sum(spent.values())} in all")
    assert way <= 800
    assert sum(spent.values()) <= 2500
