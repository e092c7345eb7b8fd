"""What strangers try: to fill the house, to sit in it for ever, to guess the code, to send what can't be read."""

import asyncio
import contextlib
import http.client
import json
import os
import random
import resource
import select
import socket
import threading
from itertools import pairwise

import aiohttp
import pytest

from host.lab.teleop.watched import free_port
from host.teleop.hub import Hub
from host.teleop.side import PAGE, SideProcess
from host.teleop.web.door import CONNECTIONS_PER_S, MOST, Door, listen
from host.teleop.web.server import STOP_EVERY_S, Page, Stops
from tests.waiting import wait_until

NOBODY = 65534
CODE = "314159"
SETUP = {"robot": "caramelo", "code": CODE, "about": {"robot": "caramelo"}, "counts_s": 0.05}
PATIENCE_S = 60


class House:
    """The web process with nobody but a listener on the loop's side."""

    def __init__(self, address):
        self.port = free_port()
        self.url, self.heard = f"http://127.0.0.1:{self.port}", []
        self.hub = Hub(lambda client, message: self.heard.append(message["type"]) or True, lambda client: None)
        self.web = SideProcess(PAGE, (address, self.port), SETUP)
        self.web.start(self.hub)
        self.web.wait(self.hub)
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._turn)
        self._thread.start()

    def _turn(self):
        while not self._done.is_set():
            self.hub.poll(0.05)

    def close(self):
        self._done.set()
        self._thread.join(PATIENCE_S)
        self.hub.close()
        self.web.close()

    def ask(self, method="GET", path="/", body=None, stranger=False, **headers):
        """Return status and body of an answer; as another user's, if asked for."""
        line = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE_S)
        with contextlib.closing(line):
            if stranger:
                os.seteuid(NOBODY)  # a socket belongs to the user who makes it
            try:
                line.sock = socket.socket()
            finally:
                os.seteuid(os.getuid())
            line.sock.settimeout(PATIENCE_S)
            line.sock.connect(("127.0.0.1", self.port))
            line.request(method, path, body, {"Origin": self.url, **headers})
            answer = line.getresponse()
            return answer.status, answer.read()

    def raw(self, data):
        """Send bytes, no faster than anybody may; return the first line of the answer, b"" if there is none."""
        self._done.wait(1.5 / CONNECTIONS_PER_S)
        with socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE_S) as line:
            line.sendall(data)
            line.shutdown(socket.SHUT_WR)
            try:
                return line.makefile("rb").readline()
            except ConnectionError:
                return b""

    def opens_a_page(self):
        """Return whether a page of this machine gets in now."""

        async def look():
            async with aiohttp.ClientSession() as web, web.ws_connect(f"{self.url}/ws", origin=self.url) as page:
                return (await page.receive_json())["type"] == "hello"

        try:
            return asyncio.run(look())
        except (aiohttp.ClientError, OSError):
            return False

    def counts(self):
        """Return counts that were sent after the call."""
        for _ in range(2):
            before = self.web.counts
            wait_until(lambda before=before: self.web.counts is not before, "the page's process counts")
        return self.web.counts


@pytest.fixture(scope="module")
def house():
    house = House("0.0.0.0")
    yield house
    house.close()


@pytest.fixture(scope="module")
def own():
    """A house that listens on this machine only."""
    house = House("127.0.0.1")
    yield house
    house.close()


@pytest.fixture
def many_files():
    """Let this process hold that many connections."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4096), hard))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def run(work):
    return asyncio.run(asyncio.wait_for(work, PATIENCE_S))


async def hears_pong(page):
    while (await page.receive_json())["type"] != "pong":
        pass


def test_idle_connections_keep_nobody_out(own, many_files):
    """Those that are one too many are closed; a page that is open stays, and another one gets in."""

    async def look():
        async with aiohttp.ClientSession() as session, session.ws_connect(f"{own.url}/ws", origin=own.url) as page:
            assert (await page.receive_json())["type"] == "hello"
            reading = asyncio.create_task(hears_pong(page))  # one that does not read does not answer its peer either
            idle = []
            for _ in range(1300):
                with contextlib.suppress(ConnectionResetError):  # closed before connect() told that it was open
                    idle.append(await asyncio.to_thread(socket.create_connection, ("127.0.0.1", own.port)))
            closed = select.poll()
            for each in idle:
                closed.register(each, select.POLLIN)
            await asyncio.to_thread(wait_until, lambda: len(closed.poll(0)) >= len(idle) - MOST, "they are closed")
            for each in idle:
                each.close()
            await asyncio.to_thread(wait_until, own.opens_a_page, "its peer may have a connection again")
            await page.send_json({"type": "ping", "t_ms": 1})
            await reading

    run(look())
    assert own.counts().trouble == ""


def test_a_slow_connection_has_an_end():
    """Headers, a body, or an answer that is not taken: none of them holds a connection for longer than allowed."""
    slow_head, slow_taker = b"GET / HTTP/1.1\r\nHost: x\r\nX-Slow: ", b"GET / HTTP/1.1\r\nHost: x\r\n\r\n"
    beginnings = [b"", slow_head, b"POST /pair HTTP/1.1\r\nHost: x\r\nContent-Length: 6\r\n\r\n1"]

    async def look():
        from aiohttp import web

        async def read(request):
            return web.Response(body=await request.read())

        async def much(request):
            return web.Response(body=bytes(50_000_000))

        app = web.Application()
        app.add_routes([web.post("/pair", read), web.get("/", much)])
        runner = web.AppRunner(app, access_log=None)
        await runner.setup()
        listener = listen("127.0.0.1", 0)
        address = listener.getsockname()
        door = Door(listener, runner.server, waiting_s=0.2)
        door.open()
        lines = [await asyncio.open_connection(*address) for _ in range(4)]
        for (_, writer), beginning in zip(lines, [*beginnings, slow_taker], strict=True):
            writer.write(beginning)
        for reader, _ in lines[:3]:
            with contextlib.suppress(ConnectionError):
                assert await reader.read() == b""
        leaves = lambda: all(guest.transport.is_closing() for guest in list(door._guests))  # noqa: E731
        await asyncio.to_thread(wait_until, leaves, "the last one is sent away")
        for _, writer in lines:
            writer.close()
        door.close()
        await runner.cleanup()

    run(look())


def heads(chance):
    """Yield requests that no browser sends."""
    own = b" HTTP/1.1\r\nHost: %(host)s\r\nOrigin: http://%(host)s\r\n"
    post, socket = b"POST /pair" + own, b"GET /ws" + own
    yield post + b"Content-Length: 3\r\n\r\n\xff\xfe\x9b"
    for kind in (b"text/plain; charset=nonsense", b"text/plain; charset=utf-7", b"\xff\xfe", b"a/b; charset=\x9b31m"):
        yield post + b"Content-Type: " + kind + b"\r\nContent-Length: 3\r\n\r\n\xff\xfe1"
    for coding in (b"gzip", b"deflate", b"br", b"nonsense"):
        yield post + b"Content-Encoding: " + coding + b"\r\nContent-Length: 6\r\n\r\n123456"
    yield post + b"Transfer-Encoding: chunked\r\n\r\nzz\r\n"
    yield post + b"Content-Length: 999999\r\n\r\nx"
    for name in (b"Host", b"Origin", b"Cookie", b"Sec-WebSocket-Key", b"Upgrade", b"Connection"):
        for value in (b"\xff\xfe", b"caramelo=\xff\x9b", b"\x9b31m", b"[", b"a:b:c", b"x" * 9000, b'caramelo="\\377'):
            yield socket + name + b": " + value + b"\r\n\r\n"
            yield b"GET /paired HTTP/1.1\r\n" + name + b": " + value + b"\r\n\r\n"
    yield b"GET / HTTP/1.0\r\n\r\n"
    for _ in range(40):
        yield bytes(chance.randrange(256) for _ in range(60)) + b"\r\n\r\n"


def test_what_can_not_be_read_is_refused_and_nothing_is_printed(house):
    for head in heads(random.Random(1)):
        answer = house.raw(head.replace(b"%(host)s", b"127.0.0.1:%d" % house.port))
        assert not answer.startswith(b"HTTP/1.1 5"), (head, answer)
    counts = house.counts()
    assert counts.trouble == ""
    assert counts.refusals["malformed"] > 40
    assert os.fstat(house.web._errors).st_size == 0, "it has written on its screen"
    assert house.ask(path="/paired") == (200, b'{"paired": false, "kept": false}')


UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
}


@pytest.mark.skipif(os.getuid() != 0, reason="only root can become somebody else")
def test_a_stranger_on_this_machine_needs_the_code(own):
    assert own.ask(path="/paired") == (200, b'{"paired": true, "kept": false}')
    assert own.ask(path="/paired", stranger=True) == (200, b'{"paired": false, "kept": false}')
    assert own.ask(path="/ws", stranger=True, **UPGRADE)[0] == 401
    assert own.ask("POST", "/pair", CODE, stranger=True)[0] == 200


@pytest.mark.skipif(os.getuid() != 0, reason="only root can become somebody else")
def test_wrong_guesses_of_one_keep_no_other_out(house):
    wrong = "000000" if CODE != "000000" else "000001"
    assert house.ask("POST", "/pair", wrong, stranger=True)[0] == 403
    assert house.ask("POST", "/pair", CODE, stranger=True)[0] == 403, "too soon after a wrong one"
    assert house.ask("POST", "/pair", CODE)[0] == 200


def test_beyond_this_machine_a_code_is_needed(house):
    async def look():
        async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as session:
            with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
                await session.ws_connect(f"{house.url}/ws", origin=house.url)
            assert refused.value.status == 401
            async with session.post(f"{house.url}/pair", data=CODE) as answer:
                assert answer.status == 403, "no origin"
            origin = {"Origin": house.url}
            async with session.post(f"{house.url}/pair", data=CODE, headers=origin) as answer:
                assert answer.status == 200
                assert "HttpOnly" in answer.headers["Set-Cookie"]
                assert "SameSite=Strict" in answer.headers["Set-Cookie"]
            socket = await session.ws_connect(f"{house.url}/ws", origin=house.url)
            assert (await socket.receive_json())["type"] == "hello"
            await socket.close()

    run(look())


class Told:
    """A page's socket; what is sent waits in a queue."""

    closed = False

    def __init__(self):
        self._sent = asyncio.Queue()
        self.send_str = self._sent.put

    async def next(self):
        return await asyncio.wait_for(self._sent.get(), PATIENCE_S)


def test_a_page_gets_no_status_before_it_has_seen_the_last_one_and_then_the_newest():
    """A page on a busy machine showed the robot of 8 s ago, and no longer knew that it drives."""

    async def look():
        told = Told()
        page = Page(1, "somebody", told, None)
        sending = asyncio.create_task(page.send_news())
        page.tell("status", "first")
        assert await told.next() == "first"
        page.tell("status", "second")
        page.tell("pong", "its pong")
        assert await told.next() == "its pong", "nothing else waits"
        page.tell("status", "third")
        assert page.see()
        assert await told.next() == "third"
        assert page.see()
        assert not page.see(), "it says so once"
        sending.cancel()

    run(look())


def test_a_flood_of_stops_is_one_stop_at_a_time_and_the_last_one_counts():
    passed = []

    async def look():
        loop = asyncio.get_running_loop()
        stops = Stops(lambda stop: passed.append((loop.time(), stop["n"])))
        for n in range(1000):
            stops.pull({"n": n})
        await asyncio.to_thread(wait_until, lambda: passed[-1][1] == 999, lambda: passed[-1])

    run(look())
    assert passed[0][1] == 0, "the first one goes at once"
    assert all(b[0] - a[0] >= STOP_EVERY_S * 0.99 for a, b in pairwise(passed))


def test_a_page_that_floods_reaches_the_loop_no_more_often_than_allowed(own):
    message = json.dumps({"type": "take"})
    own.heard.clear()

    async def look():
        async with aiohttp.ClientSession() as session:
            for _ in range(3):
                async with session.ws_connect(f"{own.url}/ws", origin=own.url) as page:
                    with contextlib.suppress(ConnectionError, aiohttp.ClientError):
                        for _ in range(3000):
                            await page.send_str(message)
                    while (await page.receive()).type is aiohttp.WSMsgType.TEXT:
                        pass

    run(look())
    before = own.counts().refusals["limited"]
    assert before > 300
    assert 60 <= own.heard.count("take") < 1000
