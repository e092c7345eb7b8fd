"""A real board on a serial port, over the link that flashing uses: the final reference.

The tree goes into a folder ``parity`` of the board's file system and is removed at the end: a board with caramelo's
own firmware has none, so this is for any board with MicroPython as its makers distribute it. Every
wait is bounded: a silent board is a failure with a sentence, never a hang.
"""

import base64
import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from ...util.errors import UserError
from ...util.extras import not_installed
from .base import MARK, Runtime, RuntimeFailure, compile_sources

if TYPE_CHECKING:
    from ..flash.link import BoardLink

FOLDER = "parity"
CHUNK = 1024  # bytes of a file that a script carries
MAKE_FOLDER = "import os\ntry:\n    os.mkdir(%r)\nexcept OSError as e:\n    if e.args[0] != 17:\n        raise"
LEAVE_RAW = b"\x02"  # Ctrl-B: back to the friendly prompt
# py/persistentcode.h, the bits of sys.implementation._mpy that name the processor
ARCHES = (
    None, "x86", "x64", "armv6", "armv6m", "armv7m", "armv7em", "armv7emsp", "armv7emdp", "xtensa", "xtensawin",
    "rv32imc", "rv64imc",
)  # fmt: skip

# Each script starts without our modules in memory, so that only one set is loaded at a time.
PROLOGUE = f"""
import gc, sys
for _name in list(sys.modules):
    if _name.split('.')[0] in ('shared', 'probe'):
        del sys.modules[_name]
gc.collect()
if '{FOLDER}' not in sys.path:
    sys.path.insert(0, '{FOLDER}')
"""


class Board(Runtime):
    """The core as the firmware build makes it for the board's own processor."""

    name = "board"
    emitter = "viper"

    def __init__(self, port: str) -> None:
        self.port = port
        self._link: BoardLink | None = None
        self._undo: list[str] = []  # scripts that take away what was copied, to be run from the last to the first

    def missing(self) -> str | None:
        return not_installed("mpremote")

    def prepare(self, sources: Path, work: Path) -> Path:
        from ..flash.link import BoardLink

        link = BoardLink(self.port)
        with _failures():
            link.interrupt()
            self._link = link
            arch = self._arch(link)
        self.emitter = "viper" if arch else "bytecode"
        tree = compile_sources(sources, work, self.emitter, arch or "any")
        with _failures():
            self._upload(link, tree)
        return tree

    def execute(self, tree: Path, script: str) -> str:
        assert self._link is not None
        with _failures():
            return self._link.run(PROLOGUE + script, self.timeout_s)

    def close(self) -> None:
        """Remove the copied files and close the port."""
        link, self._link = self._link, None
        if link is None:
            return
        with _failures():
            for script in reversed(self._undo):
                link.run(script)
            link.send(LEAVE_RAW)
            link.close()
        self._undo = []

    def _arch(self, link: "BoardLink") -> str | None:
        word = link.ask(f"print({MARK!r} + str(__import__('sys').implementation._mpy))", int)
        number = word >> 10 & 0xF
        if number >= len(ARCHES):
            raise RuntimeFailure(f"{self.port}: processor number {number} is not known")
        return ARCHES[number]

    def _upload(self, link: "BoardLink", tree: Path) -> None:
        for folder in [FOLDER, *(f"{FOLDER}/{p.relative_to(tree)}" for p in sorted(tree.rglob("*")) if p.is_dir())]:
            link.run(MAKE_FOLDER % folder)
            self._undo.append(f"import os\nos.rmdir({folder!r})")
        for path in sorted(tree.rglob("*.mpy")):
            target = f"{FOLDER}/{path.relative_to(tree).as_posix()}"
            _write(link, target, path.read_bytes())
            self._undo.append(f"import os\nos.remove({target!r})")


def _write(link: "BoardLink", path: str, data: bytes) -> None:
    """Write one file, a script for each part."""
    link.run(f"import binascii\nout = open({path!r}, 'wb')")
    for at in range(0, len(data), CHUNK):
        part = base64.b64encode(data[at : at + CHUNK])
        link.run(f"out.write(binascii.a2b_base64({part!r}))")
    link.run("out.close()")


@contextlib.contextmanager
def _failures() -> Iterator[None]:
    """Turn the errors of a board into those of a runtime."""
    try:
        yield
    except UserError as error:
        raise RuntimeFailure(str(error)) from error
