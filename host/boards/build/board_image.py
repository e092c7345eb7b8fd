"""Builds a board's image from MicroPython's sources: frozen modules, linked for both slots, and the loader."""

import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from shared.wire.names import PROTOCOL_HASH

from ... import ROOT
from . import toolchain
from .frozen import FrozenTree, frozen_sources
from .image_file import ImageFile, make_image

BOARDS = ROOT / "firmware/boards"
LOADER = ROOT / "firmware/loader"
BOARD = {"joint": "CARAMELO_JOINT", "gait": "CARAMELO_GAIT"}
COMPILED_FILES = 330  # about so many files make tells of; only for the bar
LOADER_FLAGS = (
    "-mcpu=cortex-m4", "-mthumb", "-Os", "-std=c11", "-Wall", "-Wextra", "-Werror", "-ffreestanding",
    "-fno-tree-loop-distribute-patterns", "-nostdlib",
)  # fmt: skip


@dataclass(frozen=True)
class Built:
    """An image, and what it takes: bytes by name, as image_budget.json names them."""

    image: ImageFile
    bytes: dict[str, int]


def build_board_image(
    role: str, robot: str, micropython: Path, out: Path, jobs: int, tell: Callable[[], None] = lambda: None
) -> Built:
    """Build what a board of ``role`` gets, in ``out``, where a later build goes on. BuildError or UserError.

    ``tell`` is called for every file compiled.
    """
    number = toolchain.check_sources(micropython)
    toolchain.check_compiler()
    out = out.absolute()
    out.mkdir(parents=True, exist_ok=True)
    tree = frozen_sources(role, robot, out / "frozen")
    elves = [_link(role, slot, tree, micropython.absolute(), out, jobs, tell) for slot in "ab"]
    loader = build_loader(out)
    images = [_binary(elf) for elf in elves]
    protocol = PROTOCOL_HASH if role == "joint" else None
    image = make_image(role, BOARD[role], version("caramelo-robot"), protocol, number, images, loader)
    return Built(image, {**measure(elves[0], out), "loader": len(loader)})


def _link(
    role: str, slot: str, tree: FrozenTree, micropython: Path, out: Path, jobs: int, tell: Callable[[], None]
) -> Path:
    """Return the program linked for a slot; everything but the linking is done once for both."""
    manifest = out / "manifest.py"
    manifest.write_text(f"freeze({str(tree.modules)!r})\n")
    build, elf = out / "make", out / f"slot_{slot}.elf"
    values = {
        "BOARD_DIR": str(BOARDS / BOARD[role]),
        "BUILD": str(build),
        "SLOT": slot,
        "FROZEN_MANIFEST": str(manifest),
    }
    if tree.c_modules is not None:
        values["USER_C_MODULES"] = str(tree.c_modules)
    (build / "firmware.elf").unlink(missing_ok=True)
    toolchain.make(micropython, str(build / "firmware.elf"), values, jobs, out / "build.log", tell)
    shutil.copyfile(build / "firmware.elf", elf)
    return elf


def build_loader(out: Path) -> bytes:
    """Return the loader's bytes, compiled in ``out``."""
    elf = out / "loader.elf"
    sources = [str(LOADER / name) for name in ("choose.c", "main.c")]
    script = f"-Wl,-T,{LOADER / 'loader.ld'},--build-id=none"
    toolchain.run([toolchain.GCC, *LOADER_FLAGS, script, "-o", str(elf), *sources])
    return _binary(elf)


def _binary(elf: Path) -> bytes:
    target = elf.with_suffix(".bin")
    toolchain.run([toolchain.OBJCOPY, "-O", "binary", str(elf), str(target)])
    return target.read_bytes()


def measure(elf: Path, out: Path) -> dict[str, int]:
    """Return what an image takes of flash and RAM in bytes, by what."""
    sections = _sections(elf)
    symbols = _symbols(elf)
    flash = sum(sections.get(name, 0) for name in (".isr_vector", ".text", ".data", ".ARM"))
    frozen = _frozen_bytes(out / "make")
    return {
        "flash": flash,
        "interpreter": flash - frozen,
        "frozen": frozen,
        "data": sections[".data"],
        "bss": sections[".bss"],
        "stack": symbols["_estack"] - symbols["_sstack"],
        "heap": symbols["_heap_end"] - symbols["_heap_start"],
    }


def _frozen_bytes(build: Path) -> int:
    """Return what of the image is ours: the frozen modules, and C modules if there are any."""
    objects = [build / "frozen_content.o", *build.glob("_core/*.o")]
    total = 0
    for path in objects:
        total += sum(size for name, size in _sections(path).items() if re.match(r"\.(text|rodata|data)", name))
    return total


def _sections(path: Path) -> dict[str, int]:
    """Return the sizes of a file's sections by name."""
    found: dict[str, int] = {}
    for line in toolchain.run([toolchain.SIZE, "-A", "-d", str(path)]).splitlines():
        match = re.match(r"(\.\S+)\s+(\d+)\s", line)
        if match:
            found[match[1]] = found.get(match[1], 0) + int(match[2])
    return found


def _symbols(elf: Path) -> dict[str, int]:
    lines = (line.split() for line in toolchain.run([toolchain.NM, str(elf)]).splitlines())
    return {words[2]: int(words[0], 16) for words in lines if len(words) == 3}
