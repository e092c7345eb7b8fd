"""All command sources in one select(): scripts on a socket, the web process, the keyboard, a gamepad.

A script's connection is one client. The web process has one connection for all its pages and puts each page's number
beside the message. Whoever sends a line that is no message is hung up on and counted.
"""

import json
import os
import select
import socket
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from ..errors import UserError
from .arbiter import Client
from .lines import Gone, Lines
from .messages import LONGEST, BadMessage, Message, check, parse

MOST_SCRIPTS = 8
WEB_LINE = 1024
Receiver = Callable[[Client, Message], bool]


class Input(Protocol):
    """A device that select() can wait for."""

    client: Client

    def fileno(self) -> int:
        """What to wait for."""

    def messages(self) -> list[Message]:
        """What it says now. OSError if it is gone."""


class Hub:
    """Hands messages to ``receive`` and lost clients to ``drop``."""

    def __init__(self, receive: Receiver, drop: Callable[[Client], None]) -> None:
        self._receive, self._drop = receive, drop
        self._listener: socket.socket | None = None
        self._scripts: dict[Client, Lines] = {}
        self._web: Lines | None = None
        self._pages: set[Client] = set()
        self._inputs: list[Input] = []
        self._path: Path | None = None
        self._number = 0
        self.bad = 0
        self.web_news: Callable[[dict[str, Any]], None] = lambda news: None

    def listen(self, where: str) -> None:
        """Let scripts connect to a Unix socket's path, or to a port number on 127.0.0.1."""
        try:
            self._listener = _on_port(int(where)) if where.isdigit() else _on_path(Path(where))
        except (OSError, OverflowError) as error:
            raise UserError(f"--socket {where}: can't listen there: {error}") from None
        self._path = None if where.isdigit() else Path(where)
        self._listener.setblocking(False)

    def add_input(self, source: Input) -> None:
        """Wait for a keyboard or gamepad too."""
        self._inputs.append(source)

    def add_web(self, stream: socket.socket) -> None:
        """Take the web process's end."""
        self._web = Lines(stream, WEB_LINE)

    @property
    def scripts(self) -> int:
        """How many scripts are connected."""
        return len(self._scripts)

    def poll(self, timeout_s: float) -> None:
        """Wait up to ``timeout_s`` for anything and take it."""
        waiting = [each for each in (self._listener, self._web, *self._scripts.values(), *self._inputs) if each]
        ready, _, _ = select.select(waiting, [], [], timeout_s)
        for each in ready:
            if each is self._listener:
                self._accept()
            elif each is self._web:
                self._hear_web(self._web)
            elif isinstance(each, Lines):
                self._hear_script(each)
            else:
                self._hear_input(each)

    def tell(self, news: dict[str, Any]) -> None:
        """Send all scripts and the web process what goes on."""
        for client, lines in list(self._scripts.items()):
            try:
                lines.send(news)
            except Gone:
                self._lose(client)
        if self._web is not None:
            try:
                self._web.send(news)
            except Gone:
                self._lose_web()

    def close(self) -> None:
        """Hang up on everybody and remove the socket's file."""
        for each in (self._listener, self._web, *self._scripts.values()):
            if each is not None:
                each.close()
        if self._path is not None:
            self._path.unlink(missing_ok=True)

    def _accept(self) -> None:
        assert self._listener is not None
        try:
            stream, _ = self._listener.accept()
        except OSError:
            return
        if len(self._scripts) >= MOST_SCRIPTS:
            stream.close()
            return
        self._number += 1
        self._scripts[Client("script", self._number)] = Lines(stream, LONGEST)

    def _hear_script(self, lines: Lines) -> None:
        client = next((each for each, its in self._scripts.items() if its is lines), None)
        if client is None:
            return
        try:
            for line in lines.receive():
                self._take(client, parse(line), lines)
        except BadMessage as error:
            self.bad += 1
            self._answer(lines, {"type": "error", "reason": str(error)})
            self._lose(client)
        except Gone:
            self._lose(client)

    def _hear_web(self, lines: Lines) -> None:
        try:
            for line in lines.receive():
                self._try_web(line, lines)
        except Gone:
            self._lose_web()

    def _try_web(self, line: bytes, lines: Lines) -> None:
        """A bad line must not cost the next one, which may be a stop."""
        try:
            self._take_web(line, lines)
        except (ValueError, KeyError, TypeError):
            self.bad += 1

    def _take_web(self, line: bytes, lines: Lines) -> None:
        """A page's message, a page that is gone, or news of the web process itself."""
        value = json.loads(line)
        if not isinstance(value, dict):
            raise TypeError("no object")
        if "page" not in value:
            self.web_news(value)
            return
        client = Client("web", int(value["page"]))
        if value.get("gone"):
            self._pages.discard(client)
            self._drop(client)
        else:
            self._pages.add(client)
            self._take(client, check(value["message"]), lines)

    def _take(self, client: Client, message: Message, lines: Lines) -> None:
        if message["type"] == "ping":
            self._answer(lines, {"type": "pong", "page": client.number, "t_ms": message["t_ms"]})
        elif not self._receive(client, message):
            self._answer(lines, {"type": "refused", "page": client.number, "message": message["type"]})

    @staticmethod
    def _answer(lines: Lines, value: dict[str, Any]) -> None:
        try:
            lines.send(value)
        except Gone:
            return  # its next receive() says so too, and that is where a client is dropped

    def _hear_input(self, source: Any) -> None:
        try:
            messages = source.messages()
        except OSError:
            self._inputs.remove(source)
            self._drop(source.client)
            return
        for message in messages:
            self._receive(source.client, message)

    def _lose(self, client: Client) -> None:
        self._scripts.pop(client).close()
        self._drop(client)

    def _lose_web(self) -> None:
        """The web process is gone, and all its pages with it."""
        if self._web is not None:
            self._web.close()
            self._web = None
        for client in self._pages:
            self._drop(client)
        self._pages.clear()


def _on_port(port: int) -> socket.socket:
    return socket.create_server(("127.0.0.1", port), backlog=MOST_SCRIPTS)


def _on_path(path: Path) -> socket.socket:
    """Listen on a Unix socket that only this user may open; a dead one in its place is removed."""
    if path.exists():
        if not stat.S_ISSOCK(path.stat().st_mode):
            raise OSError("there is a file of that name")
        _refuse_living(path)
        path.unlink()
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    before = os.umask(0o177)
    try:
        listener.bind(str(path))
    finally:
        os.umask(before)
    listener.listen(MOST_SCRIPTS)
    return listener


def _refuse_living(path: Path) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        try:
            probe.connect(str(path))
        except OSError:
            return
    raise OSError("another program listens there: is another caramelo running?")
