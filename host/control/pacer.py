"""A fixed rate: when the next tick is due, how late each one was, which missed its deadline.

Due times are start + n / rate, so lateness does not add up. A tick misses its deadline if its goals are not on the
bus before the next tick is due; ticks skipped because of that are misses too.
"""

from collections import deque
from typing import Any

KEPT = 6000  # ticks with their lateness: two minutes at 50 Hz


class Pacer:
    """Counts ticks. Times are monotonic seconds from the caller."""

    def __init__(self, rate_hz: int, now_s: float) -> None:
        self.period_s = 1 / rate_hz
        self._start_s, self._n = now_s, 0
        self.ticks = self.missed = 0
        self.late_s: deque[float] = deque(maxlen=KEPT)
        self.busy_s: deque[float] = deque(maxlen=KEPT)
        self._began_s = now_s

    @property
    def due_s(self) -> float:
        """When the next tick is due."""
        return self._start_s + self._n * self.period_s

    def begin(self, now_s: float) -> None:
        """Begin a tick."""
        self._began_s = now_s
        self.late_s.append(now_s - self.due_s)

    def end(self, now_s: float) -> int:
        """End a tick; skip ticks that can't be made up, and return the count of missed deadlines."""
        self.busy_s.append(now_s - self._began_s)
        self.ticks += 1
        self._n += 1
        behind = int((now_s - self.due_s) / self.period_s + 1) if now_s > self.due_s else 0
        self._n += behind
        self.missed += behind
        return behind

    def summary(self) -> dict[str, Any]:
        """Return counts, and lateness and work per tick in ms."""
        return {
            "ticks": self.ticks,
            "missed": self.missed,
            "late_ms": quantiles_ms(self.late_s),
            "busy_ms": quantiles_ms(self.busy_s),
        }


def figures_ms(seconds: "deque[float] | list[float]") -> dict[str, float]:
    """Return the number of times, and their quantiles in ms."""
    return {"count": len(seconds), **quantiles_ms(seconds)}


def quantiles_ms(seconds: "deque[float] | list[float]") -> dict[str, float]:
    """Return median, 99th percentile and largest of some times, ms; zeros for none."""
    ordered = sorted(seconds) or [0.0]
    at = len(ordered) - 1
    return {
        "p50": round(1000 * ordered[at // 2], 3),
        "p99": round(1000 * ordered[-(-at * 99 // 100)], 3),
        "max": round(1000 * ordered[-1], 3),
    }
