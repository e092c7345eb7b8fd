"""A server's process and the loop: lines of JSON objects over the socket that the process inherits."""

import asyncio
import json
import socket
from collections.abc import Awaitable, Callable
from typing import Any

LONGEST_LINE = 1 << 16


class Link:
    """The connection to the loop."""

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


async def converse(descriptor: int, serve: Callable[[Link, dict[str, Any]], Awaitable[None]]) -> None:
    """Serve over an inherited socket; the first line is the set-up."""
    stream = socket.socket(fileno=descriptor)
    link = Link(*await asyncio.open_connection(sock=stream, limit=LONGEST_LINE))
    setup = await link.receive()
    if setup is not None:
        await serve(link, setup)
