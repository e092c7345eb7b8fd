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


class PretendBoard:
    """Use as a context; ``port`` is what a program opens as its serial port. ``silent`` boards never answer."""

    def __init__(self, folder: Path, silent: bool = False) -> None:
        self._board, inner = pty.openpty()
        self._outside, outer = pty.openpty()
        tty.setraw(inner)
        tty.setraw(outer)
        self.port = os.ttyname(outer)
        self._held = [inner, outer]
        self._running = True
        self._process = None
        if not silent:
            command = [sys.executable, "-m", "micropython_unix", "-i", "-X", "heapsize=8M"]
            self._process = subprocess.Popen(
                command, stdin=inner, stdout=inner, stderr=inner, cwd=folder, start_new_session=True
            )
        self._relay = threading.Thread(target=self._carry, daemon=True)

    def __enter__(self) -> "PretendBoard":
        self._relay.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._running = False
        self._relay.join(PATIENCE_S)
        if self._process:
            self._process.kill()
            self._process.wait(PATIENCE_S)
        for end in (self._board, self._outside, *self._held):
            os.close(end)

    def _carry(self) -> None:
        """Carry bytes both ways until the board is put away."""
        other = {self._board: self._outside, self._outside: self._board}
        while self._running:
            for end in select.select(list(other), [], [], 0.05)[0]:
                os.write(other[end], os.read(end, 4096))
