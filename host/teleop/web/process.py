"""The web process: talks to the loop over an inherited socket, and ends with it.

The loop's first line is the set-up; the first line back says that the page is served, or why it can't be.
"""

import asyncio
import time
from pathlib import Path
from typing import Any

from aiohttp import web

from ...robot.file import load_robot
from ...robot.view import View
from ..link import Link
from .access import Names, Pairing, is_loopback
from .door import Door, listen
from .paired import Paired
from .peer import may_open_sockets
from .server import Server
from .trouble import Trouble

COUNTS_S = 1.0  # between two reports to the loop, unless the set-up says otherwise


async def serve(link: Link, setup: dict[str, Any]) -> None:
    """Serve the page until the loop is gone."""
    robot = load_robot(setup["robot"])
    view = View(robot)
    names = Names(setup["listen"], setup["port"])
    # The code is for users who could not open the scripts' socket on this machine either.
    friends = may_open_sockets() if is_loopback(setup["listen"]) else frozenset[str]()
    paired = Paired(Path(setup["paired"]) if setup.get("paired") else None)
    pairing = Pairing(setup["code"], friends, time.monotonic, paired)
    server = Server(link.send, pairing, names, setup["about"], setup.get("first", "index.html"))
    trouble = Trouble()
    runner = web.AppRunner(server.app(), access_log=None, handle_signals=False, shutdown_timeout=0.5)
    await runner.setup()
    assert runner.server is not None
    try:
        server.door = Door(listen(setup["listen"], setup["port"]), runner.server)
    except OSError as error:
        link.send({"type": "web", "error": f"--listen {setup['listen']}:{setup['port']}: {error.strerror or error}"})
        return
    server.door.open()
    link.send({"type": "web", "listens": True})
    every_s = setup.get("counts_s", COUNTS_S)
    counting = asyncio.create_task(_count(server, trouble, paired, link, every_s))
    while (news := await link.receive()) is not None:
        if "joints_rad" in news and server.pages:
            roll_rad, pitch_rad = news["attitude_rad"] or (0.0, 0.0)
            news["view"] = view.points(news["joints_rad"], roll_rad, pitch_rad, news["swinging"])
        server.publish(news)
    counting.cancel()
    server.door.close()
    await runner.cleanup()


async def _count(server: Server, trouble: Trouble, paired: Paired, link: Link, every_s: float) -> None:
    """Report to the loop again and again how many pages there are, what was refused and what went wrong."""
    while True:
        await asyncio.sleep(every_s)
        await server.hang_up_revoked()
        counts = {"malformed": server.malformed + trouble.malformed, "limited": server.limited}
        counts["refused"] = server.refused + server.door.turned_away
        link.send({"type": "web", "pages": len(server.pages), **counts, "trouble": trouble.sentence or paired.trouble})
