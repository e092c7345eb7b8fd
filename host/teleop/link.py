"""A server's process and the loop: lines of JSON objects over the socket that the process inherits."""

import asyncio
import json
import socket
from typing import Any

LONGEST_LINE = 1 << 16


class Link:
    """The loop's end of things."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader, self._writer = reader, writer

    async def receive(self) -> dict[str, Any] | None:
        """Return the next object, or None at the end."""
        try:
            line = await self._reader.readline()
        except (OSError, ValueError):
            return None
        return json.loads(line) if line else None

    def send(self, value: dict[str, Any]) -> None:
        """Send an object."""
        self._writer.write(json.dumps(value, separators=(",", ":")).encode() + b"\n")


async def open_link(descriptor: int) -> Link:
    """Return the link over an inherited socket."""
    stream = socket.socket(fileno=descriptor)
    reader, writer = await asyncio.open_connection(sock=stream, limit=LONGEST_LINE)
    return Link(reader, writer)
