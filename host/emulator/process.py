"""Starts the emulator in a process of its own and talks to it: its port, its orders, its inertial sensor."""

import importlib
import json
import subprocess
import sys
import threading
from collections.abc import Sequence
from types import TracebackType
from typing import Any, Self

from ..errors import NOT_ACHIEVED, UserError
from ..imu.base import Imu, ImuError


class Emulator:
    """Emulated servos behind a pseudo-terminal named ``port``; ends with the block, or with this process."""

    def __init__(self, *options: str) -> None:
        self._options = options
        self._process: subprocess.Popen[str] | None = None
        self._lock = threading.Lock()
        self.port = ""

    def start(self) -> None:
        """Start it and wait for the port's name; ModuleNotFoundError if the simulator is not installed."""
        if "bench" not in self._options:
            importlib.import_module("sim2d.world")
        command = [sys.executable, "-m", "host.emulator", *self._options]
        # A session of its own: Ctrl-C in the terminal must not take the servos away before they are let go.
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True
        )
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise UserError(f"the emulated servos did not start (exit code {self._process.wait()})", NOT_ACHIEVED)
        self.port = json.loads(line)["port"]

    def ask(self, do: str, **details: Any) -> dict[str, Any]:
        """Give an order (see host/emulator/__main__.py) and return the answer; UserError if it can't."""
        process = self._process
        assert process is not None
        assert process.stdin is not None
        assert process.stdout is not None
        with self._lock:
            try:
                process.stdin.write(json.dumps({"do": do, **details}) + "\n")
                process.stdin.flush()
                line = process.stdout.readline()
            except (OSError, ValueError):
                line = ""
        if not line:
            raise UserError("the emulated servos are gone", NOT_ACHIEVED)
        answer: dict[str, Any] = json.loads(line)
        if "error" in answer:
            raise UserError(f"the emulated servos can't {do}: {answer['error']}")
        return answer

    def stop(self) -> None:
        """End it; may be called twice."""
        process, self._process = self._process, None
        if process is None:
            return
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.close()
        try:
            process.wait(2.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        process.stdout.close()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.stop()


class EmulatorImu(Imu):
    """The inertial sensor of the emulated robot."""

    kind = "emulated"

    def __init__(self, emulator: Emulator) -> None:
        self.emulator = emulator

    def open(self) -> None:
        """See Imu."""

    def read(self) -> Sequence[int]:
        """See Imu."""
        try:
            counts: list[int] = self.emulator.ask("imu")["counts"]
        except UserError as error:
            raise ImuError(str(error)) from None
        return counts

    def close(self) -> None:
        """See Imu."""
