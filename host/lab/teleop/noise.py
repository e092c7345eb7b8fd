"""Messages of broken or hostile pages, many at once: the loop must obey none, and none may hold it up."""

import asyncio
import json
import random
from typing import Any

import aiohttp

from ...control.messages import LONGEST

AHEAD = {"type": "drive", "vx_m_s": 0.05, "vy_m_s": 0.0, "wz_rad_s": 0.0, "pose": [0.0] * 6}
PER_CONNECTION = 3  # the first ends the connection; what follows is on its way by then
LONGEST_S = 300.0


def bad_message(chance: random.Random, number: int) -> bytes | str:
    """Return something that is not a message."""
    kinds = (
        lambda: bytes(chance.randrange(256) for _ in range(chance.randrange(1, LONGEST))),
        lambda: "".join(chr(chance.randrange(32, 0x2FF)) for _ in range(chance.randrange(1, 100))),
        lambda: json.dumps({**AHEAD, chance.choice(list(AHEAD)): chance.choice([None, "x", [], 1e6, True])}),
        lambda: json.dumps({"type": chance.choice(["posture", "gait", "reset2", "STOP"]), "gait": number}),
        lambda: "x" * chance.randrange(LONGEST + 1, 5000),
        lambda: json.dumps(AHEAD)[: chance.randrange(1, 80)],
    )
    return chance.choice(kinds)()


def make_noise(url: str, messages: int, connections: int) -> None:
    """Send so many bad messages to the page at ``url`` over so many connections; returns when they are sent."""
    asyncio.run(asyncio.wait_for(_all(url, messages, connections), LONGEST_S))


async def _all(url: str, messages: int, connections: int) -> None:
    left = [messages]
    async with aiohttp.ClientSession(connector=aiohttp.TCPConnector(limit=0)) as session:
        await asyncio.gather(*(_one(session, url, left, random.Random(k)) for k in range(connections)))


async def _one(session: aiohttp.ClientSession, url: str, left: list[int], chance: random.Random) -> None:
    """Send until nothing is left, and connect again after each hang-up."""
    while left[0] > 0:
        try:
            socket = await session.ws_connect(f"{url}/ws", origin=url)
        except (aiohttp.ClientError, OSError):
            await asyncio.sleep(0.01)  # as many pages as there may be are open: try again
            continue
        for _ in range(PER_CONNECTION):
            left[0] -= 1
            try:
                await _send(socket, bad_message(chance, left[0]))
            except (ConnectionError, aiohttp.ClientError):
                break
        await socket.close()  # waits until the other side has closed as well


async def _send(socket: Any, data: bytes | str) -> None:
    await (socket.send_bytes(data) if isinstance(data, bytes) else socket.send_str(data))


def memory_kB(process: int) -> int:
    """Return the resident memory of a process and its children."""
    with open(f"/proc/{process}/task/{process}/children") as file:
        family = [process, *map(int, file.read().split())]
    total = 0
    for each in family:
        with open(f"/proc/{each}/statm") as file:
            total += int(file.read().split()[1]) * 4
    return total
