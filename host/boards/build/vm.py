"""Builds MicroPython for an emulated Cortex-M4 with a role frozen in, to count what its paths cost.

MicroPython's qemu port for a board with a Cortex-M3, compiled for the M4 of the STM32F405, with that chip's heap.
"""

from pathlib import Path

from . import toolchain
from .frozen import FrozenTree

_CPU = "-mcpu=cortex-m4 -mfloat-abi=hard -mfpu=fpv4-sp-d16 -isystem /usr/include/newlib"


def build_vm(micropython: Path, tree: FrozenTree, heap_bytes: int, work: Path, jobs: int = 2) -> bytes:
    """Return the image to be loaded at address 0; ``work`` is an absolute folder. UserError says what is missing."""
    toolchain.check_sources(micropython)
    toolchain.check_compiler()
    manifest = work / "manifest.py"
    manifest.write_text(f"freeze({str(tree.modules)!r})\n")
    toolchain.run(["make", "-C", str(micropython / "mpy-cross"), f"-j{jobs}"])
    toolchain.run(["make", "-C", str(micropython / "ports/qemu"), f"-j{jobs}", "BOARD=MPS2_AN385",
                   f"BUILD={work / 'vm'}", f"FROZEN_MANIFEST={manifest}", f"USER_C_MODULES={tree.c_modules}",
                   f"MICROPY_HEAP_SIZE={heap_bytes}", f"CFLAGS_EXTRA={_CPU}"])  # fmt: skip
    image = work / "vm.bin"
    toolchain.run([toolchain.OBJCOPY, "-O", "binary", str(work / "vm/firmware.elf"), str(image)])
    return image.read_bytes()
