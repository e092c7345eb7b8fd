"""Time in cycles of the 168 MHz core clock: what is due when, in order, and never a cycle looked at for nothing."""

import heapq
from collections.abc import Callable

CORE_HZ = 168_000_000


def cycles_of_ns(nanoseconds: float) -> float:
    """Return the core cycles (168 MHz) that a time in nanoseconds lasts."""
    return nanoseconds * 0.168


class Due:
    """Something to come; ``cancel`` makes it never happen. Without ``act`` it is nothing."""

    __slots__ = ("act",)

    def __init__(self, act: Callable[[], None] | None = None) -> None:
        self.act = act

    def cancel(self) -> None:
        self.act = None


class Timeline:
    """The clock and the queue of what is due. Things due in the same cycle happen in the order they were asked for."""

    def __init__(self) -> None:
        self.now = 0
        self._queue: list[tuple[int, int, Due]] = []
        self._count = 0

    def at(self, when: int, act: Callable[[], None]) -> Due:
        """Have ``act`` called in cycle ``when`` (in the next step of time if that is past)."""
        due = Due(act)
        self._count += 1
        heapq.heappush(self._queue, (max(when, self.now), self._count, due))
        return due

    def next_due(self) -> int | None:
        """Return the cycle of the next thing due; None if nothing is."""
        while self._queue and self._queue[0][2].act is None:
            heapq.heappop(self._queue)
        return self._queue[0][0] if self._queue else None

    def advance(self, cycles: int) -> None:
        """Let time pass and do what falls due, the last cycle included."""
        end, queue = self.now + cycles, self._queue
        while queue and queue[0][0] <= end:
            when, _, due = heapq.heappop(queue)
            if due.act is not None:
                self.now = when
                due.act()
        self.now = max(self.now, end)
