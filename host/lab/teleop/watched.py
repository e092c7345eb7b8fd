"""A `caramelo teleop` in a process of its own, and a script that watches it: for measurements and tests."""

import contextlib
import json
import os
import pty
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from ... import NAME
from ...util.child import end_child
from ...util.errors import NOT_ACHIEVED, UserError

PATIENCE_S = 120.0  # a busy machine may take this long for something due within a second
CHUNK = 1 << 16

Status = dict[str, Any]


def free_port() -> int:
    """Return a port on which nobody listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


class Watched:
    """The command with the page, a script connected; ``keys`` types into its terminal, if it has one."""

    def __init__(
        self,
        folder: Path,
        *options: str,
        sim: Sequence[str] = ("--sim", "--in", "plane"),
        host: str = "127.0.0.1",
        terminal: bool = False,
    ) -> None:
        self.port, self._path = free_port(), str(folder / "teleop.sock")
        self.url, self.host = f"http://127.0.0.1:{self.port}", f"127.0.0.1:{self.port}"
        self._terminal = self._open_terminal() if terminal else None
        command = [sys.executable, "-m", f"{NAME}.cli", "teleop", *sim, "--web", "--listen", f"{host}:{self.port}"]
        command += ["--socket", self._path, *options, *([] if terminal else ["--json"])]
        if self._terminal is None:
            self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        else:
            theirs = self._terminal[1]
            self.process = subprocess.Popen(
                command, stdin=theirs, stdout=theirs, stderr=theirs, text=True, start_new_session=True
            )
        self.script, self._buffer = self._connect(), b""
        self.status()

    @staticmethod
    def _open_terminal() -> tuple[int, int]:
        """Return both ends of a terminal; what is painted is read and thrown away."""
        ours, theirs = pty.openpty()

        def read() -> None:
            with contextlib.suppress(OSError):
                while os.read(ours, CHUNK):
                    continue

        threading.Thread(target=read, name="terminal", daemon=True).start()
        return ours, theirs

    def keys(self, text: str) -> None:
        """Type."""
        assert self._terminal is not None
        os.write(self._terminal[0], text.encode())

    def _connect(self) -> socket.socket:
        end_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < end_s and self.process.poll() is None:
            script = socket.socket(socket.AF_UNIX)
            try:
                script.connect(self._path)
            except OSError:
                script.close()
                time.sleep(0.05)
            else:
                return script
        self.__exit__(None, None, None)
        raise UserError("caramelo teleop did not start: start it by itself to see its error", NOT_ACHIEVED)

    def say(self, **message: Any) -> None:
        """Send a message as the script."""
        self.script.sendall(json.dumps(message).encode() + b"\n")

    def status(self) -> Status:
        """Return a status younger than the call, and throw away older ones. Both use the same clock."""
        asked_s = time.monotonic()
        self.script.settimeout(PATIENCE_S)
        while True:
            while b"\n" not in self._buffer:
                data = self.script.recv(CHUNK)
                if not data:
                    raise UserError("caramelo teleop has ended", NOT_ACHIEVED)
                self._buffer += data
            line, _, self._buffer = self._buffer.partition(b"\n")
            value: Status = json.loads(line)
            if value["type"] == "status" and value["time_s"] >= asked_s:
                return value

    def wait(self, found: Callable[[Status], Any], seconds: float = PATIENCE_S) -> Status:
        """Return the first status for which ``found`` is true; UserError if none comes."""
        end_s = time.monotonic() + seconds
        while time.monotonic() < end_s:
            status = self.status()
            if found(status):
                return status
        said = "; ".join(str(status[key]) for key in ("state", "reason", "remark") if status[key])
        raise UserError(f"not within {seconds} s: {said}", NOT_ACHIEVED)

    def stand(self, ask: Callable[[str], Any], found: Callable[[Status], Any], seconds: float = PATIENCE_S) -> Status:
        """Have ``ask`` "stand" until ``found``, and "reset" after a fault; return the status, UserError as ``wait``.

        On a machine that is busy for a moment emulated servos fall silent, which is a fault of the bus.
        """

        def again(status: Status) -> Any:
            if status["state"] == "fault":
                ask("reset")
            if status["state"] in ("fault", "disarmed"):
                ask("stand")
            return found(status)

        return self.wait(again, seconds)

    def stop(self) -> dict[str, Any]:
        """End it by SIGTERM and return its figures."""
        self.script.close()
        self.process.send_signal(signal.SIGTERM)
        stdout = self.process.stdout
        text = stdout.read() if stdout is not None else "{}"
        self.process.wait(PATIENCE_S)
        figures: dict[str, Any] = json.loads(text)
        return figures

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self.process.poll() is None:
            with contextlib.suppress(Exception):
                self.stop()
        end_child(self.process, 0.0)
        for descriptor in self._terminal or ():
            os.close(descriptor)
        self._terminal = None
