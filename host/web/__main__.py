"""The web process: python -m host.web FD. Talks to the loop over a socket that it inherits; ends when that does.

The first line from the loop is the set-up, the first line back says where the page is, or why it can't be.
"""

import asyncio
import json
import socket
import sys
import time
from typing import Any

from aiohttp import web

from ..robot_file import load_robot
from ..teleop.priority import give_back
from ..teleop.telemetry import about
from .access import Names, Pairing
from .server import Server
from .view import View

LONGEST_LINE = 1 << 16
COUNTS_S = 1.0
NICER = 5  # than a loop that nobody lifted above the others (chosen)


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


async def serve(link: Link, setup: dict[str, Any]) -> None:
    """Serve the page until the loop is gone."""
    robot = load_robot(setup["robot"])
    view = View(robot)
    names = Names(setup["listen"], setup["port"])
    server = Server(link.send, Pairing(setup["code"], time.monotonic), names, about(robot))
    runner = web.AppRunner(server.app(), access_log=None, handle_signals=False, shutdown_timeout=0.5)
    await runner.setup()
    site = web.TCPSite(runner, setup["listen"], setup["port"], backlog=64)
    try:
        await site.start()
    except OSError as error:
        link.send({"type": "web", "error": f"--listen {setup['listen']}:{setup['port']}: {error.strerror or error}"})
        return
    link.send({"type": "web", "url": site.name})
    counting = asyncio.create_task(_count(server, link))
    while (news := await link.receive()) is not None:
        if news["type"] == "status" and server.pages:
            roll_rad, pitch_rad = news["attitude_rad"] or (0.0, 0.0)
            news["view"] = view.points(news["joints_rad"], roll_rad, pitch_rad, news["swinging"])
        server.publish(news)
    counting.cancel()
    await runner.cleanup()


async def _count(server: Server, link: Link) -> None:
    """Tell the loop once a second how many pages there are and what was refused."""
    while True:
        await asyncio.sleep(COUNTS_S)
        counts = {"malformed": server.malformed, "limited": server.limited, "refused": server.refused}
        link.send({"type": "web", "pages": len(server.pages), **counts})


async def main(descriptor: int) -> None:
    """Connect to the loop and serve."""
    stream = socket.socket(fileno=descriptor)
    reader, writer = await asyncio.open_connection(sock=stream, limit=LONGEST_LINE)
    link = Link(reader, writer)
    setup = await link.receive()
    if setup is not None:
        await serve(link, setup)


if __name__ == "__main__":
    give_back(NICER)
    asyncio.run(main(int(sys.argv[1])))
