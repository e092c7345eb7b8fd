"""All command sources in one select(): scripts on a socket, servers' processes, the keyboard, a gamepad.

A script's connection is one client. A side is a process that speaks for many clients, the pages or Foxglove's viewers,
and puts each one's number beside its message. The hub hangs up on a client that sends a line that is not a message, or
too many lines, and counts it. It ignores messages beyond the limit, except stops.
"""

import json
import os
import select
import socket
import stat
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from math import inf
from pathlib import Path
from typing import Any, Protocol

from ..control.arbiter import Client
from ..control.messages import KEYS, LONGEST, BadMessage, Keys, Message, check, parse
from ..util.errors import UserError
from .lines import Gone, Lines
from .web.limits import Bucket
from .web.peer import may_open_sockets, peer_of

MOST_SCRIPTS = 8
MESSAGES_PER_S, BURST = 200.0, 200  # of a script: more than any loop's ticks
PATIENCE = 200  # messages beyond that before the hub hangs up on a script
CONNECTIONS_PER_S, CONNECTION_BURST = 4.0, 16
STOP = b'"stop"'
SIDE_LINE = 1024
Receiver = Callable[[Client, Message], bool]


class Input(Protocol):
    """A device that select() can wait for."""

    client: Client

    def fileno(self) -> int:
        """Return the file descriptor to wait for."""

    def messages(self) -> list[Message]:
        """Return its present messages. OSError if it is gone."""


@dataclass
class Script:
    """A script's connection, and how many messages it may still send."""

    client: Client
    lines: Lines
    messages: Bucket
    excess: int = 0


@dataclass
class Side:
    """A process that speaks for many clients of one source, pages or viewers."""

    source: str
    lines: Lines
    news: Callable[[dict[str, Any]], None]
    clients: set[Client] = field(default_factory=set)


class Hub:
    """Passes messages to ``receive`` and lost clients to ``drop``."""

    def __init__(
        self,
        receive: Receiver,
        drop: Callable[[Client], None],
        clock: Callable[[], float] = time.monotonic,
        keys: Keys = KEYS,
    ) -> None:
        self._receive, self._drop, self._clock, self._keys = receive, drop, clock, keys
        self.came_s = inf  # since when the present input may have been waiting; inf: there is none
        self._quiet_s: dict[object, float] = {}  # when a source was last seen without input
        self._connections = Bucket(CONNECTIONS_PER_S, CONNECTION_BURST, clock)
        self._friends = may_open_sockets()
        self._listener: socket.socket | None = None
        self._scripts: dict[Client, Script] = {}
        self._sides: dict[str, Side] = {}  # by the source of its clients
        self._inputs: list[Input] = []
        self._path: Path | None = None
        self._number = 0
        self.bad = self.limited = 0
        self.about: dict[str, Any] = {}  # what a script gets first

    def listen(self, where: str) -> None:
        """Let scripts connect to a Unix socket's path, or to a port number on 127.0.0.1."""
        try:
            if where.isdigit():
                self._listener = socket.create_server(("127.0.0.1", int(where)), backlog=MOST_SCRIPTS)
            else:
                self._listener = _on_path(Path(where))
        except (OSError, OverflowError) as error:
            raise UserError(f"--socket {where}: can't listen there: {error}") from None
        self._path = None if where.isdigit() else Path(where)
        self._listener.setblocking(False)

    def add_input(self, source: Input) -> None:
        """Wait for a keyboard or gamepad too."""
        self._inputs.append(source)

    def add_side(self, source: str, stream: socket.socket, news: Callable[[dict[str, Any]], None]) -> None:
        """Take our end of a process that speaks for many clients; its reports on itself go to ``news``."""
        self._sides[source] = Side(source, Lines(stream, SIDE_LINE), news)

    def has_side(self, source: str) -> bool:
        """False while there is no such process, or its connection is lost."""
        return source in self._sides

    def lose_side(self, source: str) -> None:
        """Hang up on such a process; all its clients are gone with it."""
        side = self._sides.pop(source, None)
        if side is not None:
            side.lines.close()
            for client in side.clients:
                self._drop(client)

    @property
    def scripts(self) -> int:
        """How many scripts are connected."""
        return len(self._scripts)

    def poll(self, timeout_s: float) -> None:
        """Wait up to ``timeout_s`` for anything and take it."""
        hear: dict[Any, Callable[[], None]] = {each: partial(self._hear_input, each) for each in self._inputs}
        if self._listener is not None:
            hear[self._listener] = self._accept
        hear |= {side.lines: partial(self._hear_side, side) for side in self._sides.values()}
        hear |= {script.lines: partial(self._hear_script, script) for script in self._scripts.values()}
        for each in self._look(list(hear), timeout_s):
            self.came_s = self._quiet_s[each]
            hear[each]()
        self.came_s = inf

    def _look(self, waiting: list[Any], timeout_s: float) -> list[Any]:
        """Return the sources with input, and keep since when it may have been waiting."""
        looked_s = self._clock()
        ready, _, _ = select.select(waiting, [], [], 0.0)
        before_s = {each: self._quiet_s.get(each, looked_s) if each in ready else looked_s for each in waiting}
        if not ready and timeout_s > 0:
            ready, _, _ = select.select(waiting, [], [], timeout_s)
            before_s = dict.fromkeys(waiting, self._clock())  # select() returned at once
        self._quiet_s = before_s
        return ready

    def tell(self, news: dict[str, Any]) -> None:
        """Send a status to all scripts and sides."""
        for client, script in list(self._scripts.items()):
            try:
                script.lines.send(news)
            except Gone:
                self._lose(client)
        for side in list(self._sides.values()):
            try:
                side.lines.send(news)
            except Gone:
                self.lose_side(side.source)

    def close(self) -> None:
        """Hang up on everybody and remove the socket's file."""
        if self._listener is not None:
            self._listener.close()
        connected: list[Side | Script] = [*self._sides.values(), *self._scripts.values()]
        for each in connected:
            each.lines.close()
        if self._path is not None:
            self._path.unlink(missing_ok=True)

    def _accept(self) -> None:
        assert self._listener is not None
        try:
            stream, _ = self._listener.accept()
        except OSError:
            return
        # Any user of this machine can reach a port, but only those who may drive can open the socket's file: check
        # both.
        welcome = self._path is not None or peer_of(stream) in self._friends
        if not welcome or len(self._scripts) >= MOST_SCRIPTS or not self._connections.take():
            stream.close()
            return
        self._number += 1
        client = Client("script", self._number)
        messages = Bucket(MESSAGES_PER_S, BURST, self._clock)
        script = self._scripts[client] = Script(client, Lines(stream, LONGEST), messages)
        if self.about:
            self._answer(script.lines, {"type": "hello", **self.about})

    def _hear_script(self, script: Script) -> None:
        if script.client not in self._scripts:
            return
        try:
            for line in _from_the_last_stop(script.lines.receive()):
                if script.messages.take():
                    self._take(script.client, parse(line, self._keys), script.lines)
                else:
                    self._skip(script, line)
        except BadMessage as error:
            self.bad += 1
            self._answer(script.lines, {"type": "error", "reason": str(error)})
            self._lose(script.client)
        except Gone:
            self._lose(script.client)

    def _skip(self, script: Script, line: bytes) -> None:
        """Skip a message beyond the limit, unless it is a stop; hang up on a script that goes on."""
        self.limited += 1
        script.excess += 1
        if STOP in line and (message := parse(line, self._keys))["type"] == "stop":
            self._receive(script.client, message)
        if script.excess >= PATIENCE:
            raise BadMessage(f"more than {MESSAGES_PER_S:.0f} messages a second")

    def _hear_side(self, side: Side) -> None:
        try:
            for line in side.lines.receive():
                try:
                    self._take_side(line, side)
                except (ValueError, KeyError, TypeError):  # must not cost the next line, which may be a stop
                    self.bad += 1
        except Gone:
            self.lose_side(side.source)

    def _take_side(self, line: bytes, side: Side) -> None:
        """Handle a client's message, the loss of a client, or news of the process itself."""
        value = json.loads(line)
        if not isinstance(value, dict):
            raise TypeError("no object")
        if "page" not in value:
            side.news(value)
            return
        client = Client(side.source, int(value["page"]))
        if value.get("gone"):
            side.clients.discard(client)
            self._drop(client)
        else:
            side.clients.add(client)
            self._take(client, check(value["message"], self._keys), side.lines)

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
            return  # its next receive() fails too, and drops the client

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
        self._scripts.pop(client).lines.close()
        self._drop(client)


def _from_the_last_stop(lines: Iterator[bytes]) -> Iterator[bytes]:
    """Put a stop before earlier messages of its sender that have not been handled yet."""
    kept, gone = list[bytes](), None
    try:
        for line in lines:
            if STOP in line:
                kept.clear()
            kept.append(line)
    except Gone as error:
        gone = error
    yield from kept
    if gone is not None:
        raise gone


def _on_path(path: Path) -> socket.socket:
    """Listen on a Unix socket that only this user may open; remove a dead one in its place."""
    if path.exists():
        if not stat.S_ISSOCK(path.stat().st_mode):
            raise OSError("a file of that name exists")
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
    raise OSError("another program listens there (another caramelo?)")
