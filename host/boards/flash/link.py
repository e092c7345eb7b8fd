"""A board's prompt on a serial port, with mpremote's transport. Every wait is bounded, every failure a sentence."""

import contextlib
import errno
import fcntl
import os
import struct
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

from ...util.errors import NOT_ACHIEVED, UserError
from ..runtimes.base import MARK

READ_TIMEOUT_S = 2.0
PROMPT_TIMEOUT_S = 2.0
STEP_TIMEOUT_S = 20.0  # erasing the flash of a STM32F405 takes up to 2 s a sector (datasheet, table 40)
BACK_TIMEOUT_S = 15.0  # from a reset until USB is there again
PROMPT = b"\n>>> "  # MicroPython's: nothing of the firmware runs any more
CTRL_C = b"\x03"
INTERRUPTS = 12  # firmware/start_gait.py wants ten in a row


Shape = TypeVar("Shape")


class BoardError(UserError):
    """The board failed during an operation, as opposed to wrong use."""

    def __init__(self, sentence: str) -> None:
        super().__init__(sentence, NOT_ACHIEVED)


class BoardScriptError(BoardError):
    """A script raised an exception on the board."""


class BoardLink:
    """One board; ``port`` is its device. Use as a context, or call close()."""

    def __init__(self, port: str) -> None:
        self.port = port
        self._link: Any = None

    def __enter__(self) -> "BoardLink":
        try:
            self.interrupt()
        except KeyboardInterrupt:
            self.leave_running()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def open(self) -> None:
        """Open the port; UserError says why it can't be opened and what to do."""
        from mpremote.transport import TransportError
        from mpremote.transport_serial import SerialTransport

        if self._link is not None:
            return
        check_port(self.port)
        try:
            self._link = SerialTransport(self.port, timeout=READ_TIMEOUT_S)
            self._link.serial.write_timeout = STEP_TIMEOUT_S
        except (TransportError, OSError, ValueError) as error:
            raise UserError(f"{self.port}: {_refusal(self.port, error)}") from error

    def interrupt(self) -> None:
        """Open the port if needed, stop the program on the board and get its prompt."""
        from mpremote.transport import TransportError

        self.open()
        with self._failures(), contextlib.redirect_stdout(None):  # it prints bytes that it did not understand
            try:
                self._link.enter_raw_repl(soft_reset=False, timeout_overall=PROMPT_TIMEOUT_S)
            except TransportError:
                self._link.serial.write(CTRL_C * INTERRUPTS)
                self._link.read_until(1, PROMPT, timeout_overall=PROMPT_TIMEOUT_S)  # what comes before may be lost
                self._link.enter_raw_repl(soft_reset=False, timeout_overall=PROMPT_TIMEOUT_S)

    def run(self, script: str, timeout_s: float = STEP_TIMEOUT_S) -> str:
        """Run a script on the board and return what it printed; BoardScriptError if it raised an exception."""
        with self._failures():
            output, error = self._link.exec_raw(script, timeout=timeout_s)
        if error:
            lines = error.decode("utf-8", "replace").strip().splitlines()
            words = lines[-1] if lines else "that something went wrong, but not what"
            raise BoardScriptError(f"{self.port}: the board says {words}")
        return str(output.decode("utf-8", "replace"))

    def ask(self, script: str, shape: type[Shape], timeout_s: float = STEP_TIMEOUT_S) -> Shape:
        """Run a script that answers with one marked line of JSON, and return it; BoardError if it has another shape.

        ``shape``: a class or type as pydantic takes it (answers.py).
        """
        from pydantic import TypeAdapter, ValidationError

        for line in self.run(script, timeout_s).splitlines():
            if line.startswith(MARK):
                try:
                    return TypeAdapter(shape).validate_json(line[len(MARK) :], strict=True)
                except ValidationError as error:
                    raise _unreadable(self.port, error.errors(include_url=False)[0]) from None
        raise BoardError(f"{self.port}: no answer from the board: reset it and try again")

    def reset(self) -> None:
        """Reset the board and close the port; the board's application starts."""
        with contextlib.suppress(BoardError):  # it may be gone before it has taken the whole line
            with self._failures():
                self._link.exec_raw_no_follow("import machine\nmachine.reset()")
            time.sleep(0.1)
        self.close()

    def leave_running(self) -> None:
        """Start the board's application again, if the board still answers."""
        with contextlib.suppress(UserError):
            self.interrupt()
            self.reset()

    def listen(self, seconds: float, take: Callable[[bytes], bool] = lambda data: False) -> None:
        """Read the board's output for this long, or until ``take`` returns True."""
        self.open()
        end = time.monotonic() + seconds
        with self._failures():
            while time.monotonic() < end:
                waiting = self._link.serial.inWaiting()
                if waiting and take(self._link.serial.read(waiting)):
                    return
                time.sleep(0.02)

    def send(self, data: bytes) -> None:
        """Send bytes as they are."""
        with self._failures():
            self._link.serial.write(data)

    def wait_until_back(self) -> None:
        """Open the port again after a reset; its device may be gone for some seconds."""
        end = time.monotonic() + BACK_TIMEOUT_S
        while True:
            try:
                self.open()
                return
            except UserError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.1)

    def close(self) -> None:
        """Close the port without any other step."""
        link, self._link = self._link, None
        if link is not None:
            with contextlib.suppress(OSError):  # the board may be gone
                _unlock(link.serial)
                link.close()

    @contextlib.contextmanager
    def _failures(self) -> Iterator[None]:
        """Turn the errors of a serial line into one sentence."""
        import serial
        from mpremote.transport import TransportError

        try:
            yield
        except (serial.SerialException, OSError) as error:
            self.close()
            raise BoardError(f"{self.port}: the connection broke: check the cable and try again") from error
        except (TransportError, struct.error) as error:
            self.close()
            raise BoardError(
                f"{self.port}: the board does not answer like MicroPython: check that this is its port. "
                f"Reset it and try again; for a board without MicroPython see docs/flashing.md"
            ) from error


@contextlib.contextmanager
def stopped(port: str) -> Iterator[BoardLink]:
    """Stop a board's application for the block, and start it again however the block ends, also on Ctrl-C."""
    with BoardLink(port) as link:
        try:
            yield link
        finally:
            link.leave_running()


def _unreadable(port: str, first: Mapping[str, Any]) -> BoardError:
    """Return what is wrong with an answer; ``first`` is pydantic's first complaint."""
    place = ".".join(str(part) for part in first["loc"]) or "all of it"
    return BoardError(f"{port}: the board's answer can't be read: {place}: {first['msg']}: reset it and try again; "
                      f"if that does not help, install its MicroPython again (docs/flashing.md)"[:400])


def check_port(port: str) -> None:
    """UserError if there is no such device or it may not be used."""
    if "://" in port:
        return
    if not os.path.exists(port):
        raise UserError(f"{port}: no such port: {_ports()}")
    if not os.access(port, os.R_OK | os.W_OK):
        raise UserError(f"{port}: no permission: run sudo usermod -aG dialout $USER, then log in again")


def _refusal(port: str, error: BaseException) -> str:
    """Return why an existing port could not be opened; mpremote does not say."""
    import serial

    try:
        serial.Serial(port, exclusive=True).close()
    except serial.SerialException as cause:
        if cause.errno in (errno.EAGAIN, errno.EWOULDBLOCK, errno.EBUSY) or "lock" in str(cause):
            return "another program uses it: close it (a terminal, an editor, another caramelo), then try again"
        if cause.errno in (errno.EACCES, errno.EPERM):
            return "no permission: run sudo usermod -aG dialout $USER, then log in again"
        error = cause
    return f"can't be opened ({error}): check that it is the board's serial port, and plug the board in again"


def _unlock(port: Any) -> None:
    """Release the port's lock now: closing alone leaves it to a child process that was forked a moment ago."""
    if isinstance(getattr(port, "fd", None), int):
        fcntl.flock(port.fd, fcntl.LOCK_UN)


def found_ports() -> list[str]:
    """Return the USB serial ports of this machine."""
    from serial.tools.list_ports import comports

    return sorted(entry.device for entry in comports() if entry.vid is not None)


def _ports() -> str:
    """Return what to plug in, or which ports there are."""
    found = found_ports()
    return f"there are {', '.join(found)}" if found else "plug the board in: this machine has no USB serial port"
