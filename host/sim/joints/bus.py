"""A classic CAN bus in simulated time: arbitration by identifier, frames of their exact length, loss on request.

Times are microseconds. A node has a send buffer; a frame that has no room in it is refused. When the bus is idle
the lowest identifier of all waiting frames goes first (ISO 11898-1), and reaches all other nodes at its end.
"""

import random
from collections import deque
from collections.abc import Callable
from functools import lru_cache

from ...bus.can.load import BITRATE, frame_bits

MAILBOXES = 64  # frames in a node's send buffer (a Linux interface's is 10 to 1000; a board's queue 64)

Deliver = Callable[[int, int, bytes], None]  # time in us, identifier, data

bits_of = lru_cache(maxsize=65536)(frame_bits)


class Node:
    """A node's end of the bus; ``deliver`` is called with every frame of the others that it does not lose."""

    def __init__(self, bus: "SimBus", deliver: Deliver, room: int) -> None:
        self._bus, self.deliver, self._most = bus, deliver, room
        self.waiting: deque[tuple[int, bytes]] = deque()
        self.loss = 0.0  # share of frames that this node does not hear
        self.connected = True

    def send(self, identifier: int, data: bytes) -> bool:
        """Queue a frame; False if there is no room for it or the node is not connected."""
        if not self.connected or self.room() <= 0:
            return False
        self.waiting.append((identifier, data))
        return True

    def room(self) -> int:
        """Return how many frames still find room."""
        return self._most - len(self.waiting)

    def take_lowest(self) -> tuple[int, bytes]:
        """Take the waiting frame that wins; of equal identifiers the oldest."""
        lowest = min(self.waiting, key=_identifier)
        self.waiting.remove(lowest)
        return lowest

    @property
    def lowest(self) -> int:
        """Return the identifier with which the node takes part in arbitration."""
        return min(self.waiting, key=_identifier)[0]


class SimBus:
    """The wire. ``advance`` lets frames go by; ``sent`` and ``bits`` count them."""

    def __init__(self, bitrate: int = BITRATE, seed: int = 0) -> None:
        self.bitrate = bitrate
        self.now_us = 0.0
        self.sent = 0
        self.bits = 0
        self.log: Callable[[float, int, bytes], None] | None = None
        self._random = random.Random(seed)
        self._nodes: list[Node] = []
        self._flying: tuple[float, Node, int, bytes] | None = None  # end, sender, frame

    def attach(self, deliver: Deliver, room: int = MAILBOXES) -> Node:
        """Return a new node."""
        node = Node(self, deliver, room)
        self._nodes.append(node)
        return node

    def advance(self, to_us: float) -> None:
        """Go on to a time, frame by frame; nodes may send from within ``deliver``."""
        while True:
            if self._flying is None and not self._start():
                break
            assert self._flying is not None
            if self._flying[0] > to_us:
                break
            self._finish()
        self.now_us = max(self.now_us, to_us)

    def _start(self) -> bool:
        ready = [node for node in self._nodes if node.waiting]
        if not ready:
            return False
        winner = min(ready, key=lambda node: node.lowest)
        identifier, data = winner.take_lowest()
        bits = bits_of(identifier, data)
        self.sent += 1
        self.bits += bits
        self._flying = (self.now_us + bits * 1e6 / self.bitrate, winner, identifier, data)
        return True

    def _finish(self) -> None:
        assert self._flying is not None
        self.now_us, sender, identifier, data = self._flying
        self._flying = None
        if self.log is not None:
            self.log(self.now_us, identifier, data)
        for node in self._nodes:
            if node is not sender and node.connected and not (node.loss and self._random.random() < node.loss):
                node.deliver(int(self.now_us), identifier, data)


def _identifier(frame: tuple[int, bytes]) -> int:
    return frame[0]
