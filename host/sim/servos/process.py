"""Starts the emulator in a process of its own and talks to it: its port, its orders, its inertial sensor."""

import json
import os
import select
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from types import TracebackType
from typing import Any, Self

from ... import NAME
from ...imu.base import Imu, ImuError, ImuLate
from ...util.child import end_child
from ...util.errors import NOT_ACHIEVED, UserError

START_S = 60.0  # takes a second; longer on a busy machine (chosen)
ANSWER_S = 10.0  # an order outside of a control loop may wait for a busy machine
END_S = 2.0
IMU_S = 0.004  # a reading must not hold up a tick; the same patience as with a servo (host/bus/dynamixel/port.py)
GROUND_S = 1.0  # the robot lies there meanwhile, its joints off
MOST_OWED = 20  # late answers after which no more commands are sent, so that an unread pipe does not fill up
CHUNK = 4096


class Late(Exception):
    """No answer in time; it may still come."""


class Emulator:
    """Emulated servos behind a pseudo-terminal named ``port``; ends with the block, or with this process."""

    def __init__(self, *options: str) -> None:
        self._options = options
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()
        self._read = b""
        self._owed = 0  # answers that were given up and are still to come
        self.port = ""

    def start(self) -> None:
        """Start it and wait for the port's name; ModuleNotFoundError if the simulator is not installed."""
        if "bench" not in self._options:
            from sim2d import world  # noqa: F401
        command = [sys.executable, "-m", f"{NAME}.sim.servos", *self._options]
        # A session of its own: Ctrl-C in the terminal must not take the servos away before they are let go.
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0, start_new_session=True
        )
        try:
            self.port = self._line(time.monotonic() + START_S)["port"]
        except BaseException as error:  # Ctrl-C too
            self.stop()
            if isinstance(error, OSError | Late):
                raise UserError("the emulated servos did not start", NOT_ACHIEVED) from None
            raise

    @property
    def process(self) -> int:
        """Return the number of its process."""
        assert self._process is not None
        return self._process.pid

    def ask(self, do: str, patience_s: float = ANSWER_S, **details: Any) -> dict[str, Any]:
        """Give an order (see host/sim/servos/__main__.py) and return the answer; Late if it takes too long.

        UserError if it can't be done.
        """
        process = self._process
        assert process is not None
        assert process.stdin is not None
        end_s = time.monotonic() + patience_s
        with self._lock:
            try:
                while self._owed > MOST_OWED:
                    self._skip(end_s)
                process.stdin.write(json.dumps({"do": do, **details}).encode() + b"\n")
                self._owed += 1
                while self._owed > 1:
                    self._skip(end_s)
                answer = self._line(end_s)
                self._owed -= 1
            except OSError:
                raise UserError("the emulated servos are gone", NOT_ACHIEVED) from None
        if "error" in answer:
            raise UserError(f"the emulated servos can't {do}: {answer['error']}")
        return answer

    def _skip(self, end_s: float) -> None:
        """Throw away an answer that comes too late."""
        self._line(end_s)
        self._owed -= 1

    def _line(self, end_s: float) -> dict[str, Any]:
        """Return the next answer; Late if it does not come in time, OSError if none will."""
        assert self._process is not None
        assert self._process.stdout is not None
        out = self._process.stdout.fileno()
        while b"\n" not in self._read:
            ready, _, _ = select.select([out], [], [], max(0.0, end_s - time.monotonic()))
            if not ready:
                raise Late
            data = os.read(out, CHUNK)
            if not data:
                raise OSError("the other side has closed")
            self._read += data
        line, _, self._read = self._read.partition(b"\n")
        answer: dict[str, Any] = json.loads(line)
        return answer

    def stop(self) -> None:
        """End it; may be called twice."""
        process, self._process = self._process, None
        if process is not None:
            end_child(process, END_S)

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
        self.place: tuple[float, float, float, float] | None = None  # of a body in space

    def choose(self, name: str) -> None:
        """Put the robot down on another ground; a busy emulator does it a little later."""
        with suppress(Late):
            self.emulator.ask("ground", GROUND_S, name=name)

    def open(self) -> None:
        """See Imu."""

    def read(self) -> Sequence[int]:
        """See Imu."""
        try:
            answer = self.emulator.ask("imu", IMU_S)
            counts: list[int] = answer["counts"]
            self.place = tuple(answer["place"]) if "place" in answer else None
        except Late:
            raise ImuLate("the emulated IMU does not answer in time: this machine may be too busy") from None
        except UserError as error:
            raise ImuError(str(error)) from None
        return counts

    def close(self) -> None:
        """See Imu."""
