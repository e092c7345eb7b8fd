"""Limits connections: a few per peer, some in all, seconds each, unless the connection becomes a page.

A new connection is always accepted; in return the oldest one that is not a page is closed, first one of the same peer.
So nobody can block the server with idle connections, or with headers or bodies that never end.
"""

import asyncio
import socket
import struct
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from .limits import Bucket, PerPeer
from .peer import peer_of

WAITING_S = 10.0  # whole time of a connection that is not a page: headers, body, answer
MOST_EACH, MOST = 16, 128  # connections that are not pages; a browser opens six
CONNECTIONS_PER_S, CONNECTION_BURST = 50.0, 100  # per peer; opening the page takes eight
AT_ONCE = 32  # connections to accept before other work gets its turn
PAUSE_S = 0.2
BACKLOG = 128


@dataclass(eq=False)
class Guest:
    """One connection. ``end`` closes it at its deadline."""

    peer: str
    transport: asyncio.Transport
    end: asyncio.TimerHandle


class Door:
    """Accepts connections and passes them to protocols that ``serve`` makes."""

    def __init__(
        self, listener: socket.socket, serve: Callable[[], asyncio.Protocol], waiting_s: float = WAITING_S
    ) -> None:
        listener.setblocking(False)
        self._listener, self._serve, self._loop = listener, serve, asyncio.get_running_loop()
        self._waiting_s = waiting_s
        self._guests: list[Guest] = []  # oldest first
        self._peers: dict[asyncio.BaseTransport, str] = {}  # also of pages
        self._comings = PerPeer(lambda: Bucket(CONNECTIONS_PER_S, CONNECTION_BURST))
        self._tasks: set[asyncio.Task[None]] = set()
        self.turned_away = 0

    def open(self) -> None:
        """Start accepting."""
        self._loop.add_reader(self._listener, self._accept)

    def close(self) -> None:
        """Accept no more, and close connections that are not pages."""
        self._loop.remove_reader(self._listener)
        self._listener.close()
        for guest in list(self._guests):
            self._send_away(guest)

    def peer(self, transport: asyncio.BaseTransport | None) -> str:
        """Return the peer at the other end."""
        return self._peers.get(transport, "unknown") if transport is not None else "unknown"

    def stay(self, transport: asyncio.BaseTransport | None) -> None:
        """Let a connection stay: it has become a page, which is counted elsewhere."""
        for guest in self._guests:
            if guest.transport is transport:
                guest.end.cancel()
                self._guests.remove(guest)
                return

    def _accept(self) -> None:
        for _ in range(AT_ONCE):
            try:
                stream, _ = self._listener.accept()
            except (BlockingIOError, ConnectionError):
                return
            except OSError:  # no descriptors left: trying again at once would not help
                self._loop.remove_reader(self._listener)
                self._loop.call_later(PAUSE_S, self.open)
                return
            self._receive(stream)

    def _receive(self, stream: socket.socket) -> None:
        peer = peer_of(stream)
        if not self._comings[peer].take():
            self.turned_away += 1
            _reset(stream)
            return
        task = self._loop.create_task(self._let_in(stream, peer))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _let_in(self, stream: socket.socket, peer: str) -> None:
        self._make_room(peer)
        with suppress(OSError):  # it is gone already
            transport, _ = await self._loop.connect_accepted_socket(self._serve, stream)
            self._peers[transport] = peer
            guest = Guest(peer, transport, self._loop.call_later(self._waiting_s, transport.abort))
            self._guests.append(guest)

    def _make_room(self, peer: str) -> None:
        """End the oldest connection of the peer, or of all, if the limit is reached."""
        self._guests = [guest for guest in self._guests if not self._is_over(guest)]
        self._peers = {each: its for each, its in self._peers.items() if not each.is_closing()}
        own = [guest for guest in self._guests if guest.peer == peer]
        if len(own) >= MOST_EACH:
            self._send_away(own[0])
        elif len(self._guests) >= MOST:
            counts = Counter(guest.peer for guest in self._guests)
            self._send_away(max(self._guests, key=lambda guest: counts[guest.peer]))

    @staticmethod
    def _is_over(guest: Guest) -> bool:
        if guest.transport.is_closing():
            guest.end.cancel()
            return True
        return False

    def _send_away(self, guest: Guest) -> None:
        self.turned_away += 1
        guest.end.cancel()
        guest.transport.abort()
        self._guests.remove(guest)


def _reset(stream: socket.socket) -> None:
    """Close without waiting for anything."""
    with suppress(OSError):
        stream.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    stream.close()


def listen(address: str, port: int) -> socket.socket:
    """Return a listener; OSError if there can't be one."""
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    return socket.create_server((address, port), family=family, backlog=BACKLOG)
