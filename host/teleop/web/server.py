"""The page's server: files, pairing, one websocket per page. Passes on only checked messages, and sends the status.

It holds no state of the robot: the loop decides who drives. The server hangs up on a page that sends anything but a
message, too much or too often. Limits are per page and per peer, and nothing beyond them reaches the loop.
"""

import asyncio
import json
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from aiohttp import WSCloseCode, WSMsgType, web

from ...control.messages import JOINT_KEYS, KEYS, LONGEST, BadMessage, parse
from .access import Names, Pairing
from .door import Door
from .limits import BURST, MESSAGES_PER_S, Bucket, PerPeer
from .trouble import THEIRS

PAGE = Path(__file__).with_name("page")
PAGES = {"index.html": KEYS, "joints.html": JOINT_KEYS}  # the messages that each page may send
TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
MOST_PAGES, MOST_PAGES_EACH = 16, 8  # in all, and per peer
PEER_PER_S, PEER_BURST = 120.0, 120  # for all pages of a peer
STOPS_PER_S, STOP_BURST = 10.0, 5
STOP_EVERY_S = 0.01  # stops closer together than this, from any pages, count as one
PATIENCE = 200  # messages beyond the limit before the server hangs up on a page
HEARTBEAT_S = 5.0
# A page says so of each status; only then it gets the next one. What waits in the system's buffers can't be replaced by
# something newer: a page slower than the robot's 20 a second fell behind by a second every few seconds.
SEEN = '{"type":"seen"}'
COOKIE = "caramelo"
KEPT_S = 365 * 24 * 3600  # a browser keeps its pairing
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class Page:
    """One open page: its socket, its number, its peer and token, and the newest status not yet sent to it."""

    def __init__(self, number: int, peer: str, socket: web.WebSocketResponse, token: str | None) -> None:
        self.number, self.peer, self.socket, self.token = number, peer, socket, token
        self.messages = Bucket(MESSAGES_PER_S, BURST)
        self.stops = Bucket(STOPS_PER_S, STOP_BURST)
        self.excess = 0
        self._news: dict[str, str] = {}
        self._seen = True  # the last status
        self._wake = asyncio.Event()

    def tell(self, kind: str, text: str) -> None:
        """Keep the newest of each kind; a slow page misses the older ones."""
        self._news[kind] = text
        self._wake.set()

    def see(self) -> bool:
        """Note that the page has seen the last status; False if it has said so already."""
        news, self._seen = not self._seen, True
        self._wake.set()
        return news

    async def send_news(self) -> None:
        """Send what is new until the page is gone."""
        while not self.socket.closed:
            await self._wake.wait()
            self._wake.clear()
            for kind in [kind for kind in self._news if kind != "status" or self._seen]:
                self._seen = self._seen and kind != "status"
                await self.socket.send_str(self._news.pop(kind))


class Stops:
    """Passes on stops at once; of those that follow within STOP_EVERY_S, the last one goes at its end."""

    def __init__(self, forward: Callable[[dict[str, Any]], None]) -> None:
        self._forward, self._next_s = forward, 0.0
        self._waiting: dict[str, Any] | None = None

    def pull(self, stop: dict[str, Any]) -> None:
        """Pass on a stop."""
        loop = asyncio.get_running_loop()
        if self._waiting is None and loop.time() < self._next_s:
            loop.call_at(self._next_s, self._send)
        waited, self._waiting = self._waiting, stop
        if waited is None and loop.time() >= self._next_s:
            self._send()

    def _send(self) -> None:
        stop, self._waiting = self._waiting, None
        self._next_s = asyncio.get_running_loop().time() + STOP_EVERY_S
        if stop is not None:
            self._forward(stop)


class Server:
    """All pages. ``forward`` passes a message with its page's number to the loop; ``first``: the PAGE to serve.

    ``door`` is set before it opens.
    """

    door: Door

    def __init__(
        self,
        forward: Callable[[dict[str, Any]], None],
        pairing: Pairing,
        names: Names,
        about: dict[str, Any],
        first: str,
    ) -> None:
        self._forward, self._pairing, self._names, self._about = forward, pairing, names, about
        self._first, self._keys = first, PAGES[first]
        self._number, self._stops = 0, Stops(forward)
        self._peers = PerPeer(lambda: Bucket(PEER_PER_S, PEER_BURST))
        self.pages: dict[int, Page] = {}
        self.malformed = self.limited = self.refused = 0

    def app(self) -> web.Application:
        """Return the application."""
        app = web.Application(middlewares=[self._guard()], client_max_size=LONGEST)
        for path in sorted(path for path in PAGE.iterdir() if path.name not in PAGES):
            app.router.add_get(f"/{path.name}", _file(path))
        app.router.add_get("/", _file(PAGE / self._first))
        app.router.add_get("/paired", self._paired)
        app.router.add_post("/pair", self._pair)
        app.router.add_post("/unpair", self._unpair)
        app.router.add_get("/ws", self._socket)
        return app

    def publish(self, status: dict[str, Any]) -> None:
        """Send a status, a pong or a refusal to the pages concerned."""
        number = status.get("page")
        text = json.dumps(status, separators=(",", ":"))
        if number is None:
            for page in self.pages.values():
                page.tell(status["type"], text)
        elif number in self.pages:
            self.pages[number].tell(status["type"], text)

    def _guard(self) -> Any:
        @web.middleware
        async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
            """Refuse foreign names; set the headers on every answer, also on errors. One answer per connection."""
            try:
                if not self._names.host_ok(request.headers.get("Host")):
                    raise web.HTTPMisdirectedRequest(text="unknown host name\n")
                response = await handler(request)
            except THEIRS:
                self.malformed += 1
                response = web.Response(status=400, text="this request can't be read\n")
            except web.HTTPException as error:
                error.headers.update(HEADERS)
                error.force_close()
                raise
            if not response.prepared:
                response.headers.update(HEADERS)
                response.force_close()
            return response

        return guard

    def _peer(self, request: web.Request) -> str:
        return self.door.peer(request.transport)

    def _is_paired(self, request: web.Request) -> bool:
        return self._pairing.allows(request.cookies.get(COOKIE), self._peer(request))

    def _check_origin(self, request: web.Request) -> None:
        if not self._names.origin_ok(request.headers.get("Origin"), request.headers.get("Host")):
            self.refused += 1
            raise web.HTTPForbidden(text="foreign origin\n")

    def _check_room(self, peer: str) -> None:
        own = sum(page.peer == peer for page in self.pages.values())
        if own >= MOST_PAGES_EACH or len(self.pages) >= MOST_PAGES:
            self.refused += 1
            raise web.HTTPServiceUnavailable(
                text=f"{len(self.pages)} of {MOST_PAGES} pages are open, {own} of {MOST_PAGES_EACH} of yours\n"
            )

    async def _paired(self, request: web.Request) -> web.Response:
        kept = self._pairing.allows(request.cookies.get(COOKIE), "")  # by its token, which the browser can give back
        return web.json_response({"paired": self._is_paired(request), "kept": kept})

    async def _pair(self, request: web.Request) -> web.Response:
        self._check_origin(request)
        code = (await request.read()).decode("ascii").strip()
        token = self._pairing.pair(code, self._peer(request))
        if token is None:
            raise web.HTTPForbidden(text="wrong code, or too many guesses: wait a moment\n")
        response = web.Response(text="paired\n")
        response.set_cookie(COOKIE, token, httponly=True, samesite="Strict", max_age=KEPT_S)
        return response

    async def _unpair(self, request: web.Request) -> web.Response:
        self._check_origin(request)
        token = request.cookies.get(COOKIE)
        if token is not None:
            self._pairing.paired.forget(token)
            await self.hang_up_revoked()
        response = web.Response(text="unpaired\n")
        response.del_cookie(COOKIE)
        return response

    async def hang_up_revoked(self) -> None:
        """Hang up on pages whose browsers are no longer paired."""
        for page in list(self.pages.values()):
            if not self._pairing.allows(page.token, page.peer):
                await page.socket.close(code=WSCloseCode.POLICY_VIOLATION, message=b"not paired any more")

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        self._check_origin(request)
        if not self._is_paired(request):
            self.refused += 1
            raise web.HTTPUnauthorized(text="not paired\n")
        peer = self._peer(request)
        self._check_room(peer)
        socket = web.WebSocketResponse(max_msg_size=LONGEST, heartbeat=HEARTBEAT_S, compress=False)
        self._number += 1
        page = Page(self._number, peer, socket, request.cookies.get(COOKIE))
        self.pages[page.number] = page
        try:
            await socket.prepare(request)
            self.door.stay(request.transport)
            await self._serve(page)
        finally:
            del self.pages[page.number]
            self._forward({"page": page.number, "gone": True})
        return socket

    async def _serve(self, page: Page) -> None:
        """Listen to a page until it is gone or breaks the rules."""
        page.tell("hello", json.dumps({"type": "hello", "page": page.number, **self._about}))
        sender = asyncio.create_task(page.send_news())
        try:
            async for message in page.socket:
                if message.type is not WSMsgType.TEXT or not self._take(page, message.data):
                    self.malformed += 1
                    await page.socket.close(code=WSCloseCode.POLICY_VIOLATION, message=b"not a message, or too many")
                    return
        finally:
            sender.cancel()

    def _take(self, page: Page, text: str) -> bool:
        """Pass on a message; False if it is not a message, or far beyond the limit."""
        if text == SEEN:
            return page.see()
        try:
            message = parse(text, self._keys)
        except BadMessage:
            return False
        if message["type"] == "stop":  # never held back, but counted
            in_time = page.stops.take()
            self._stops.pull({"page": page.number, "message": message})
        else:
            in_time = page.messages.take()
            if in_time and self._peers[page.peer].take():
                self._forward({"page": page.number, "message": message})
            elif in_time:
                self.limited += 1
        if not in_time:
            self.limited += 1
            page.excess += 1
        return page.excess < PATIENCE


def _file(path: Path) -> Handler:
    """Return a handler for one of the page's files, read once; no other file can be requested."""
    content, kind = path.read_bytes(), TYPES[path.suffix]

    async def answer(request: web.Request) -> web.Response:
        return web.Response(body=content, content_type=kind, charset="utf-8")

    return answer
