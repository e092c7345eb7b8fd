"""What builds an image: MicroPython's sources and ARM's compiler, checked before anything is made, and run.

Nothing of either comes with the project: the sources are somebody's checkout, the compiler is the system's.
"""

import os
import re
import shutil
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

from ...util.errors import NOT_ACHIEVED, UserError

OLDEST = (1, 28)  # MicroPython; 1.29 is what was tried
GCC = "arm-none-eabi-gcc"
OBJCOPY = "arm-none-eabi-objcopy"
SIZE = "arm-none-eabi-size"
NM = "arm-none-eabi-nm"
COMPILER_PACKAGES = "sudo apt-get install gcc-arm-none-eabi libnewlib-arm-none-eabi make"
SUBMODULES = ("stm32lib", "CMSIS_6", "tinyusb")  # below lib/, which a plain clone leaves empty


def check_sources(micropython: Path) -> str:
    """Return the version of MicroPython's sources; UserError unless they are whole and new enough."""
    settings = micropython / "py/mpconfig.h"
    if not settings.is_file() or not (micropython / "ports/stm32/Makefile").is_file():
        raise UserError(
            f"--micropython {micropython}: no sources of MicroPython: git clone --branch v1.29.0 "
            f"https://github.com/micropython/micropython, then name that folder (docs/flashing.md)"
        )
    empty = [name for name in SUBMODULES if not any((micropython / "lib" / name).glob("*"))]
    if empty:
        raise UserError(
            f"--micropython {micropython}: lib/{empty[0]} is empty: git -C {micropython} submodule update --init "
            f"{' '.join(f'lib/{name}' for name in SUBMODULES)}"
        )
    numbers = re.findall(r"#define MICROPY_VERSION_(?:MAJOR|MINOR|MICRO) (\d+)", settings.read_text())
    version = tuple(map(int, numbers))
    if version[:2] < OLDEST:
        oldest = ".".join(map(str, OLDEST))
        raise UserError(f"--micropython {micropython}: version {'.'.join(numbers)}; {oldest} or newer is needed")
    return ".".join(numbers)


def check_compiler() -> None:
    """UserError with what to install if the compiler or its headers are missing."""
    for program in (GCC, OBJCOPY, SIZE, NM, "make"):
        if shutil.which(program) is None:
            raise UserError(f"{program} is not installed: {COMPILER_PACKAGES}")
    include = "#include <string.h>\n"
    done = subprocess.run([GCC, "-fsyntax-only", "-xc", "-"], input=include, text=True, capture_output=True)
    if done.returncode:
        raise UserError(f"{GCC} finds no string.h: {COMPILER_PACKAGES}")


def run(command: Sequence[str]) -> str:
    """Run a program and return what it printed; UserError with its first complaint if it fails."""
    done = subprocess.run(command, text=True, capture_output=True)
    if done.returncode:
        raise UserError(f"{Path(command[0]).name} failed: {_complaint(done.stdout + done.stderr)}", NOT_ACHIEVED)
    return done.stdout


def make(
    micropython: Path, target: str, values: dict[str, str], jobs: int, log: Path, tell: Callable[[], None]
) -> None:
    """Run make in the stm32 port; ``tell`` is called for every file compiled. UserError names the first complaint."""
    words = [f"{name}={value}" for name, value in values.items()]
    command = ["make", "-C", str(micropython / "ports/stm32"), f"-j{jobs}", target, *words]
    # The date in MicroPython's greeting comes from here: the same sources give the same bytes.
    environment = {**os.environ, "SOURCE_DATE_EPOCH": "0"}
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("a", buffering=1) as file:  # to be looked at while it grows
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", env=environment
        )
        assert process.stdout is not None
        try:
            for line in process.stdout:
                file.write(line)
                if line.startswith(("CC ", "LINK ", "MPY ")):
                    tell()
            code = process.wait()
        finally:
            process.kill()
            process.wait()
    if code:
        raise UserError(f"the build failed: {_complaint(log.read_text())} (all of it: {log})", NOT_ACHIEVED)


def _complaint(text: str) -> str:
    """Return the first line of a build's output that says what is wrong, or its last."""
    lines = text.strip().splitlines()
    for mark in ("will not fit", "error:", "overflowed", "undefined reference", "Error", "***"):
        for line in lines:
            if mark in line:
                return line.strip()[:300]
    return lines[-1] if lines else "no reason was printed"
