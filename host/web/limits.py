"""A bucket of tokens: so many at once, so many a second."""

from collections.abc import Callable


class Bucket:
    """``take`` is true while there is a token."""

    def __init__(self, per_s: float, burst: int, clock: Callable[[], float]) -> None:
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
