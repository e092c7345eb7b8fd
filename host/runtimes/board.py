"""A real board on a serial port, through mpremote's transport: the truth.

The tree goes into a folder ``parity`` of the board's file system and is removed at the end. Every
wait is bounded: a board that says nothing is a failure with a sentence, never a hang.
"""

import contextlib
import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..extras import how_to_get
from .base import Runtime, RuntimeFailure, compile_sources

FOLDER = "parity"
READ_TIMEOUT_S = 2.0
# py/persistentcode.h, the bits of sys.implementation._mpy that name the processor
ARCHES = (
    None, "x86", "x64", "armv6", "armv6m", "armv7m", "armv7em", "armv7emsp", "armv7emdp", "xtensa", "xtensawin",
    "rv32imc", "rv64imc",
)  # fmt: skip

# Each script starts with nothing of ours in memory, so that modules are loaded one set at a time.
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
    prompt_timeout_s = 10.0
    emitter = "viper"

    def __init__(self, port: str) -> None:
        self.port = port
        self._link: Any = None
        self._files: list[str] = []
        self._folders: list[str] = []

    def missing(self) -> str | None:
        if importlib.util.find_spec("mpremote") is None:
            return f"mpremote is not installed: {how_to_get('mpremote')}"
        return None

    def prepare(self, sources: Path, work: Path) -> Path:
        with self._failures():
            self._connect()
            arch = self._arch()
        self.emitter = "viper" if arch else "bytecode"
        tree = compile_sources(sources, work, self.emitter, arch or "any")
        with self._failures():
            self._upload(tree)
        return tree

    def execute(self, tree: Path, script: str) -> str:
        with self._failures():
            output, error = self._link.exec_raw(PROLOGUE + script, timeout=self.timeout_s)
        if error:
            raise RuntimeFailure(f"{self.port}: {error.decode('utf-8', 'replace').strip()[-2000:]}")
        return str(output.decode("utf-8", "replace"))

    def close(self) -> None:
        """Remove what was copied and let the port go."""
        if self._link is None:
            return
        with self._failures():
            for path in reversed(self._files):
                self._link.fs_rmfile(path)
            for path in reversed(self._folders):
                self._link.fs_rmdir(path)
            self._link.exit_raw_repl()
            self._link.close()
        self._link, self._files, self._folders = None, [], []

    def _connect(self) -> None:
        from mpremote.transport_serial import SerialTransport

        if self._link is None:
            link = SerialTransport(self.port, timeout=READ_TIMEOUT_S)
            with contextlib.redirect_stdout(None):  # it prints what it did not understand
                link.enter_raw_repl(soft_reset=False, timeout_overall=self.prompt_timeout_s)
            self._link = link

    def _arch(self) -> str | None:
        word = int(self._link.eval("__import__('sys').implementation._mpy"))
        number = word >> 10 & 0xF
        if number >= len(ARCHES):
            raise RuntimeFailure(f"{self.port}: processor number {number} is not known")
        return ARCHES[number]

    def _upload(self, tree: Path) -> None:
        for folder in [FOLDER, *(f"{FOLDER}/{p.relative_to(tree)}" for p in sorted(tree.rglob("*")) if p.is_dir())]:
            if not self._link.fs_exists(folder):
                self._link.fs_mkdir(folder)
            self._folders.append(folder)
        for path in sorted(tree.rglob("*.mpy")):
            target = f"{FOLDER}/{path.relative_to(tree).as_posix()}"
            self._link.fs_writefile(target, path.read_bytes())
            self._files.append(target)

    @contextlib.contextmanager
    def _failures(self) -> Iterator[None]:
        """Turn what can go wrong on a serial line into one sentence."""
        import struct

        import serial
        from mpremote.transport import TransportError, TransportExecError

        try:
            yield
        except TransportExecError as error:
            raise RuntimeFailure(f"{self.port}: {error.error_output.strip()[-2000:]}") from error
        except (TransportError, serial.SerialException, OSError, struct.error) as error:
            raise RuntimeFailure(f"{self.port}: the board does not answer as MicroPython does: {error}") from error
