"""A board that is none: the unix VM's prompt behind a pseudo-terminal, for the code that talks to a serial port."""

import os
import pty
import select
import subprocess
import sys
import threading
import tty
from pathlib import Path

from tests.waiting import PATIENCE_S


class UnixVmBoard:
    """The unix VM at two pipes, whose bytes are carried to a pseudo-terminal and back: ``port`` is its serial port.

    A terminal at the VM itself would throw away what has come when the prompt begins, and turn Ctrl-C into a signal,
    by which this VM leaves whatever it does, with locks taken: it may hang for ever then.
    """

    def __init__(self) -> None:
        self._heard, self._to_board = os.pipe()
        self._board, self._says = os.pipe()
        self._outside, self._outer = pty.openpty()
        tty.setraw(self._outer)
        self.port = os.ttyname(self._outer)
        self._ends = [self._heard, self._to_board, self._board, self._says, self._outside, self._outer]
        self._closing = False
        self._process: subprocess.Popen | None = None
        self._relay = threading.Thread(target=self._carry, daemon=True)

    def __exit__(self, *_: object) -> None:
        self._closing = True
        self._relay.join(PATIENCE_S)
        if self._process:
            self._process.kill()
            self._process.wait(PATIENCE_S)
        for end in self._ends:
            os.close(end)

    def _start_vm(self, arguments: list[str], folder: Path) -> None:
        command = [sys.executable, "-m", "micropython_unix", *arguments]
        ends = {"stdin": self._heard, "stdout": self._says, "stderr": self._says}
        self._process = subprocess.Popen(command, cwd=folder, start_new_session=True, **ends)

    def _carry(self) -> None:
        """Carry bytes both ways until the board is put away, or ends by itself."""
        while not self._closing and self._goes_on():
            ends = [self._board, self._outside] if self._listens() else [self._board]
            for end in select.select(ends, [], [], 0.02)[0]:
                os.write(self._outside if end == self._board else self._to_board, self._read(end))

    def _goes_on(self) -> bool:
        return True

    def _listens(self) -> bool:
        """Return whether it takes what comes from outside; else it stays in the line."""
        return True

    def _read(self, end: int) -> bytes:
        return os.read(end, 4096)


class PretendBoard(UnixVmBoard):
    """Use as a context. ``silent`` boards never answer."""

    def __init__(self, folder: Path, silent: bool = False) -> None:
        super().__init__()
        if not silent:
            self._start_vm(["-i", "-X", "heapsize=8M"], folder)

    def __enter__(self) -> "PretendBoard":
        self._relay.start()
        return self
