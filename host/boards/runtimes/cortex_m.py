"""MicroPython on an emulated Cortex-M4: 32 bit, the same machine code as on a board, with every instruction
counted.

The VM is MicroPython's own qemu port, built for a Cortex-M4 (docs/core.md has the four commands) and put at
~/.cache/caramelo/micropython-cortex-m4.bin or named by CARAMELO_CORTEX_M. The PyPI package unicorn emulates the
processor; the machine around it is memory, a serial port, and one address: a write there reads the count of
instructions so far (``import host; host.call("", "")``). Time, caches and flash wait states are not emulated.
"""

import contextlib
import os
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...util.extras import not_installed
from .base import Runtime, RuntimeFailure
from .wasi import cache_folder

MEMORY_BYTES = 4 << 20  # of the image, as ports/qemu/mcu/arm/mps2.ld has it; code, heap and stack
ROM_AT, ROM_BYTES = 0x21000000, 4 << 20  # where the port looks for a file system when it starts, since MicroPython 1.26
FILES_AT, MARKS_AT, SERIAL_AT, SYSTEM_AT = 0x60000000, 0x50000000, 0x40004000, 0xE000E000
PAGE = 0x1000
DATA, STATE, HAS_BYTE = 0, 4, 2  # registers of the serial port, and its bit for a waiting byte
BREAKPOINT, SEMIHOSTING_EXIT = 7, 0x18
PROLOGUE = f"""
import machine, sys, uctypes, vfs
vfs.mount(vfs.VfsRom(uctypes.bytearray_at({FILES_AT}, %d)), '/core')
sys.path.insert(0, '/core')
class host:
    def call(name, text, memory=machine.mem32):
        memory[{MARKS_AT}] = 0
sys.modules['host'] = host
"""


class CortexM(Runtime):
    """``marks`` holds, after a run with ``counting``, the instructions done at each reading the script took."""

    name = "cortex-m-viper"
    emitter = "viper"
    arch = "armv7emsp"
    timeout_s = 3600.0  # the planner's vectors alone take some minutes, and a busy machine many times that

    def __init__(self, counting: bool = False) -> None:
        self.counting = counting
        self.marks: list[int] = []

    def missing(self) -> str | None:
        no_vm = None if image_path().exists() else f"no VM at {image_path()}: docs/core.md says how to make it"
        return not_installed("unicorn") or no_vm

    def execute(self, tree: Path, script: str) -> str:
        files = rom_files(tree)
        machine = Machine(image_path().read_bytes(), files, self.counting)
        output = machine.run(PROLOGUE % len(files) + script, self.timeout_s)
        self.marks = machine.marks
        _, _, answer = output.partition(b">OK")
        printed, error, _ = [*answer.split(b"\x04"), b"", b""][:3]
        if error or b"\x04" not in answer:
            text = (error or output).decode("utf-8", "replace").strip()[-2000:]
            raise RuntimeFailure(f"{self.name}: {machine.failure or 'failed'}: {text}")
        return printed.decode("utf-8", "replace")


class Machine:
    """One emulated processor with its memory, from power-on until the script has answered.

    ``actions``: functions to call when the script writes their number to MARKS_AT; 0 reads the count of instructions.
    """

    def __init__(self, image: bytes, files: bytes, counting: bool) -> None:
        import unicorn
        from unicorn import arm_const

        self._registers = arm_const
        self.marks: list[int] = []
        self.actions: dict[int, Callable[[], None]] = {}
        self.failure = ""
        self._done = 0
        self._sizes: dict[tuple[int, int], int] = {}
        self._waiting, self._sent = bytearray(), bytearray()
        uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        uc.ctl_set_cpu_model(arm_const.UC_CPU_ARM_CORTEX_M4)
        uc.mem_map(0, MEMORY_BYTES)
        uc.mem_write(0, image)
        uc.mem_map(SYSTEM_AT, PAGE)
        uc.mem_map(ROM_AT, ROM_BYTES)
        uc.mem_map(FILES_AT, (len(files) + PAGE) // PAGE * PAGE)
        uc.mem_write(FILES_AT, files)
        uc.mmio_map(SERIAL_AT, PAGE, self._serial_read, None, self._serial_write, None)
        uc.mmio_map(MARKS_AT, PAGE, lambda *_: 0, None, self._mark, None)
        uc.hook_add(unicorn.UC_HOOK_INTR, self._interrupt)
        if counting:
            uc.hook_add(unicorn.UC_HOOK_BLOCK, self._count)
        self._uc = uc

    def run(self, script: str, timeout_s: float) -> bytes:
        """Give the script to the raw prompt and return the VM's output."""
        import unicorn

        stack, start = struct.unpack("<II", bytes(self._uc.mem_read(0, 8)))
        self._waiting += b"\x01" + script.encode() + b"\x04"
        self._uc.reg_write(self._registers.UC_ARM_REG_SP, stack)
        self.failure = f"no answer within {timeout_s:g} s"
        try:
            self._uc.emu_start(start | 1, MEMORY_BYTES, timeout=round(timeout_s * 1e6))
        except unicorn.UcError as error:
            self.failure = str(error)
        return bytes(self._sent)

    def _serial_read(self, uc: Any, offset: int, size: int, data: Any) -> int:
        if offset == DATA and self._waiting:
            return self._waiting.pop(0)
        if offset == STATE and not self._waiting and self._sent.endswith(b"\x04>"):
            uc.emu_stop()
        return HAS_BYTE if offset == STATE and self._waiting else 0

    def _serial_write(self, uc: Any, offset: int, size: int, value: int, data: Any) -> None:
        if offset == DATA:
            self._sent.append(value & 0xFF)

    def _mark(self, uc: Any, offset: int, size: int, value: int, data: Any) -> None:
        if value:
            self.actions[value]()
        else:
            self.marks.append(self._done)

    def write(self, address: int, data: bytes) -> None:
        """Put bytes into the memory, as an action may."""
        self._uc.mem_write(address, data)

    def _interrupt(self, uc: Any, number: int, data: Any) -> None:
        """Skip the debugger calls that the port makes when it starts; anything else ends the run."""
        registers = self._registers
        if number != BREAKPOINT or uc.reg_read(registers.UC_ARM_REG_R0) == SEMIHOSTING_EXIT:
            self.failure = f"the VM stopped with exception {number}"
            uc.emu_stop()
            return
        uc.reg_write(registers.UC_ARM_REG_R0, 0)
        uc.reg_write(registers.UC_ARM_REG_PC, uc.reg_read(registers.UC_ARM_REG_PC) + 2 | 1)

    def _count(self, uc: Any, address: int, size: int, data: Any) -> None:
        """Add a block's instructions; conditional ones count also when they do nothing, as they take their cycle."""
        count = self._sizes.get((address, size))
        if count is None:
            count = instructions(bytes(uc.mem_read(address, size)))
            self._sizes[address, size] = count
        self._done += count


def instructions(code: bytes) -> int:
    """Return how many Thumb-2 instructions ``code`` holds: a half-word from 0xE800 on begins one of four bytes."""
    count = at = 0
    while at < len(code):
        at += 4 if code[at + 1] >= 0xE8 else 2
        count += 1
    return count


def rom_files(tree: Path) -> bytes:
    """Return the tree as a MicroPython ROM file system."""
    from mpremote.romfs import make_romfs

    with contextlib.redirect_stdout(None):  # it lists the packed files
        return bytes(make_romfs(str(tree), mpy_cross=False))


def image_path() -> Path:
    """Return where the VM's image is expected."""
    named = os.environ.get("CARAMELO_CORTEX_M")
    return Path(named) if named else cache_folder() / "micropython-cortex-m4.bin"
