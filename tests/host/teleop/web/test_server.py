"""The server from outside: headers, origins, pairing, bad and too many messages; the robot obeys none of it."""

import asyncio
import json
import re

import aiohttp
import pytest

from host.lab.teleop.noise import make_noise, memory_kB
from tests.host.control.rig import AHEAD

from .rig import Teleop


@pytest.fixture(scope="module")
def teleop(tmp_path_factory):
    with Teleop(tmp_path_factory.mktemp("web")) as running:
        yield running


def run(work):
    return asyncio.run(asyncio.wait_for(work, 60))


async def open_socket(session, teleop, origin=None):
    return await session.ws_connect(f"{teleop.url}/ws", origin=origin or teleop.url, headers={"Host": teleop.host})


def test_files_and_headers(teleop):
    async def look():
        async with aiohttp.ClientSession() as session:
            for path in ("/", "/app.js", "/style.css", "/view.js", "/plots.js", "/inputs.js", "/icon.svg"):
                async with session.get(teleop.url + path) as answer:
                    assert answer.status == 200, path
                    policy = answer.headers["Content-Security-Policy"]
                    assert "default-src 'none'" in policy
                    assert "script-src 'self'" in policy
                    assert "unsafe" not in policy
                    assert answer.headers["X-Content-Type-Options"] == "nosniff"
                    text = await answer.text()
                    assert not re.search(r"https?://(?!www\.w3\.org/2000/svg)", text), f"{path} asks outside"
            for path in ("/../host/teleop/web/server.py", "/%2e%2e/server.py", "/page", "/x"):
                async with session.get(teleop.url + path) as answer:
                    assert answer.status == 404
                    assert "Content-Security-Policy" in answer.headers

    run(look())


def test_the_code_is_in_no_status(teleop):
    status = teleop.status()
    assert status["web"] == teleop.url
    assert f"web page: {teleop.url}" in status["checks"]
    assert "code" not in json.dumps(status)


@pytest.mark.parametrize("headers", [{"Host": "evil.example"}, {"Host": "evil.example:80"}])
def test_a_foreign_name_gets_nothing(teleop, headers):
    async def look():
        async with aiohttp.ClientSession() as session, session.get(teleop.url, headers=headers) as answer:
            assert answer.status == 421

    run(look())


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1"])
def test_a_foreign_origin_gets_no_socket(teleop, origin):
    async def look():
        async with aiohttp.ClientSession() as session:
            with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
                await open_socket(session, teleop, origin)
            assert refused.value.status == 403
            async with session.get(f"{teleop.url}/ws") as answer:
                assert answer.status == 403, "no origin at all"

    run(look())


@pytest.mark.parametrize(
    "data",
    [
        "",
        "{",
        '{"type":"fly"}',
        "[" * 400,
        json.dumps({**AHEAD, "vx_m_s": 1e9}),
        json.dumps({**AHEAD, "vx_m_s": 10**300}),
        b"\x00\x01",
        json.dumps(AHEAD) + " " * 600,
    ],
    ids=range(8),
)
def test_a_bad_message_ends_the_connection(teleop, data):
    async def look():
        async with aiohttp.ClientSession() as session:
            socket = await open_socket(session, teleop)
            hello = await socket.receive_json()
            assert hello["type"] == "hello"
            await (socket.send_bytes(data) if isinstance(data, bytes) else socket.send_str(data))
            while (message := await socket.receive()).type is aiohttp.WSMsgType.TEXT:
                pass
            assert message.type in (aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSED, aiohttp.WSMsgType.CLOSING)

    run(look())
    assert teleop.status()["driver"] is None


def test_a_page_that_talks_without_end_is_hung_up_on(teleop):
    async def look():
        async with aiohttp.ClientSession() as session:
            socket = await open_socket(session, teleop)
            for _ in range(1000):
                await socket.send_json({"type": "ping", "t_ms": 0})
            while (message := await socket.receive()).type is aiohttp.WSMsgType.TEXT:
                pass
            return message.type

    try:
        closed = run(look()) is not aiohttp.WSMsgType.TEXT
    except ConnectionError:
        closed = True
    assert closed


def test_a_stop_is_never_held_back(teleop):
    async def look():
        async with aiohttp.ClientSession() as session:
            socket = await open_socket(session, teleop)
            for _ in range(20):
                await socket.send_json({"type": "stop"})
                await socket.send_json({"type": "reset"})
            await socket.send_json({"type": "stop"})
            await socket.send_json({"type": "ping", "t_ms": 1})
            while (await socket.receive_json())["type"] != "pong":
                pass
            await asyncio.to_thread(teleop.wait, lambda status: status["stop"] is not None)
            await socket.send_json({"type": "reset"})
            await socket.close()

    run(look())


def check_noise(teleop, messages, connections):
    """Make noise twice, so that all buffers have grown as far as they need, and return the second round's figures."""
    heard = teleop.status()["web_counts"].get("malformed", 0)

    def noise():
        make_noise(teleop.url, messages, connections)
        return teleop.wait(lambda status: status["web_counts"].get("malformed", 0) > heard + messages / 4)

    before = noise()
    heard, first_kB = before["web_counts"]["malformed"], memory_kB(teleop.process.pid)
    after = noise()
    assert after["state"] == "disarmed"
    assert after["driver"] is None
    assert after["obeyed"] == before["obeyed"]
    grown_kB = memory_kB(teleop.process.pid) - first_kB
    ticks, missed = (after["timing"][key] - before["timing"][key] for key in ("ticks", "missed"))
    counts = {key: after["web_counts"][key] - before["web_counts"][key] for key in after["web_counts"]}
    return {"ticks": ticks, "missed": missed, "grown_kB": grown_kB, **counts}


def test_noise_is_not_obeyed(teleop):
    figures = check_noise(teleop, 400, 40)
    assert figures["missed"] <= figures["ticks"] / 10
    assert figures["grown_kB"] < 8000


@pytest.mark.slow
def test_ten_thousand_bad_messages_and_two_hundred_connections(tmp_path):
    with Teleop(tmp_path) as teleop:
        figures = check_noise(teleop, 10_000, 200)
        print(figures)
        assert figures["missed"] == 0
        assert figures["grown_kB"] < 2000
