"""One connection that carries a JSON object per line, both ways, without ever blocking the loop."""

import json
import socket
from collections.abc import Iterator
from typing import Any

LONGEST_BACKLOG = 1 << 16  # bytes that a slow reader may leave unread before further news are dropped
CHUNK = 1 << 11  # bytes read at once, so that a flood of lines can't hold up a tick


class Gone(Exception):
    """The other side has closed the connection or broken its rules."""


class Lines:
    """A non-blocking stream socket; ``longest`` is the most bytes of a line."""

    def __init__(self, stream: socket.socket, longest: int) -> None:
        stream.setblocking(False)
        self.socket, self._longest = stream, longest
        self._read, self._unsent = bytearray(), bytearray()
        self.dropped = 0

    def fileno(self) -> int:
        """Let select() wait for it."""
        return self.socket.fileno()

    def receive(self) -> Iterator[bytes]:
        """Yield the complete lines; Gone if the other side is gone, or sends a line that is too long."""
        try:
            data = self.socket.recv(CHUNK)
        except BlockingIOError:
            return
        except OSError as error:
            raise Gone from error
        if not data:
            raise Gone
        self._read += data
        *lines, rest = self._read.split(b"\n")
        self._read = bytearray(rest)
        yield from (bytes(line) for line in lines)
        if len(rest) > self._longest:
            raise Gone

    def send(self, value: dict[str, Any]) -> None:
        """Send an object, what the other side does not take now with the next one; Gone if the other side is gone.

        While it leaves too much unread, objects are dropped.
        """
        if len(self._unsent) > LONGEST_BACKLOG:
            self.dropped += 1
        else:
            self._unsent += json.dumps(value, separators=(",", ":")).encode() + b"\n"
        try:
            while self._unsent:
                del self._unsent[: self.socket.send(self._unsent)]
        except BlockingIOError:
            return
        except OSError as error:
            raise Gone from error

    def close(self) -> None:
        """Hang up."""
        self.socket.close()
