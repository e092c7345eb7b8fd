"""The page's server: files, pairing, one websocket per page. Passes on checked messages only, and fans out the status.

It holds no state of the robot: the loop decides who drives. A page that sends anything but a message, too much or
too often, is hung up on.
"""

import asyncio
import json
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from aiohttp import WSCloseCode, WSMsgType, web

from ..teleop.messages import LONGEST, BadMessage, parse
from .access import Names, Pairing
from .limits import Bucket

PAGE = Path(__file__).with_name("page")
TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
MOST_PAGES = 16
MESSAGES_PER_S, BURST = 60.0, 60
STOPS_PER_S, STOP_BURST = 10.0, 5
PATIENCE = 200  # messages beyond the limit before a page is hung up on
HEARTBEAT_S = 5.0
COOKIE = "caramelo"
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
    """One open page: its socket, its number, and the newest status that it has not been sent."""

    def __init__(self, number: int, socket: web.WebSocketResponse, clock: Callable[[], float]) -> None:
        self.number, self.socket = number, socket
        self.messages = Bucket(MESSAGES_PER_S, BURST, clock)
        self.stops = Bucket(STOPS_PER_S, STOP_BURST, clock)
        self.excess = 0
        self._news: dict[str, str] = {}
        self._wake = asyncio.Event()

    def tell(self, kind: str, text: str) -> None:
        """Keep the newest of each kind; a slow page misses the older ones."""
        self._news[kind] = text
        self._wake.set()

    async def send_news(self) -> None:
        """Send what is new until the page is gone."""
        while not self.socket.closed:
            await self._wake.wait()
            self._wake.clear()
            news, self._news = self._news, {}
            for text in news.values():
                await self.socket.send_str(text)


class Server:
    """All pages. ``forward`` hands a message with its page's number to the loop."""

    def __init__(
        self,
        forward: Callable[[dict[str, Any]], None],
        pairing: Pairing,
        names: Names,
        about: dict[str, Any],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._forward, self._pairing, self._names, self._about = forward, pairing, names, about
        self._clock, self._number = clock, 0
        self.pages: dict[int, Page] = {}
        self.malformed = self.limited = self.refused = 0

    def app(self) -> web.Application:
        """Return the application."""
        app = web.Application(middlewares=[self._guard()], client_max_size=LONGEST)
        for path in sorted(PAGE.iterdir()):
            app.router.add_get("/" if path.name == "index.html" else f"/{path.name}", _file(path))
        app.router.add_get("/paired", self._paired)
        app.router.add_post("/pair", self._pair)
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
            """Refuse foreign names; set the headers on every answer, errors too."""
            try:
                if not self._names.host_ok(request.host):
                    raise web.HTTPMisdirectedRequest(text="unknown host name\n")
                response = await handler(request)
            except web.HTTPException as error:
                error.headers.update(HEADERS)
                raise
            if not response.prepared:
                response.headers.update(HEADERS)
            return response

        return guard

    def _is_paired(self, request: web.Request) -> bool:
        return self._pairing.allows(request.cookies.get(COOKIE))

    def _check_origin(self, request: web.Request) -> None:
        if not self._names.origin_ok(request.headers.get("Origin"), request.host):
            self.refused += 1
            raise web.HTTPForbidden(text="foreign origin\n")

    async def _paired(self, request: web.Request) -> web.Response:
        return web.json_response({"paired": self._is_paired(request)})

    async def _pair(self, request: web.Request) -> web.Response:
        self._check_origin(request)
        code = (await request.text()).strip()
        token = self._pairing.pair(code)
        if token is None:
            raise web.HTTPForbidden(text="wrong code, or too many guesses: wait a moment\n")
        response = web.Response(text="paired\n")
        response.set_cookie(COOKIE, token, httponly=True, samesite="Strict")
        return response

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        self._check_origin(request)
        if not self._is_paired(request):
            self.refused += 1
            raise web.HTTPUnauthorized(text="not paired\n")
        if len(self.pages) >= MOST_PAGES:
            self.refused += 1
            raise web.HTTPServiceUnavailable(text=f"{MOST_PAGES} pages are open already\n")
        socket = web.WebSocketResponse(max_msg_size=LONGEST, heartbeat=HEARTBEAT_S, compress=False)
        self._number += 1
        page = Page(self._number, socket, self._clock)
        self.pages[page.number] = page
        try:
            await socket.prepare(request)
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
        """Pass on a message; False for what is none, and for the last straw of too many."""
        try:
            message = parse(text)
        except BadMessage:
            return False
        is_stop = message["type"] == "stop"
        in_time = (page.stops if is_stop else page.messages).take()
        if in_time or is_stop:  # a stop is never held back, but counts
            self._forward({"page": page.number, "message": message})
        if not in_time:
            self.limited += 1
            page.excess += 1
        return page.excess < PATIENCE


def _file(path: Path) -> Handler:
    """Return a handler for one of the page's files, read once: there is no way to ask for any other."""
    content, kind = path.read_bytes(), TYPES[path.suffix]

    async def answer(request: web.Request) -> web.Response:
        return web.Response(body=content, content_type=kind, charset="utf-8")

    return answer
