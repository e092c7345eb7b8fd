"""Rate limits: a bucket of tokens, and one thing per peer for a bounded number of peers."""

import time
from collections import OrderedDict
from collections.abc import Callable
from typing import Generic, TypeVar

Kept = TypeVar("Kept")
MOST_PEERS = 1024
MESSAGES_PER_S, BURST = 60.0, 60  # of a page, or of one of Foxglove's viewers


class Bucket:
    """``take`` is true while there is a token: ``burst`` at once, ``rate`` a second."""

    def __init__(self, per_s: float, burst: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._per_s, self._burst, self._clock = per_s, burst, clock
        self._tokens, self._last_s = float(burst), clock()

    def take(self) -> bool:
        """Use a token, if there is one."""
        now_s = self._clock()
        self._tokens = min(self._burst, self._tokens + (now_s - self._last_s) * self._per_s)
        self._last_s = now_s
        if self._tokens < 1:
            return False
        self._tokens -= 1
        return True


class PerPeer(Generic[Kept]):
    """One thing per peer; beyond MOST_PEERS the peer that has been silent for longest is forgotten."""

    def __init__(self, make: Callable[[], Kept]) -> None:
        self._make, self._kept = make, OrderedDict[str, Kept]()

    def __getitem__(self, peer: str) -> Kept:
        """Return a peer's thing, made new for an unknown peer."""
        if peer not in self._kept:
            self._kept[peer] = self._make()
            if len(self._kept) > MOST_PEERS:
                self._kept.popitem(last=False)
        self._kept.move_to_end(peer)
        return self._kept[peer]
