"""The codec's checks of a value: whether it is within its range, and what it is when limited to it."""

from ..runtime import hot


@hot
def limit_but(value: int, low: int, high: int, special: int) -> int:
    """Return ``value`` limited to ``low .. high`` unless it is ``special``. Exact."""
    if value == special:
        return value
    if value < low:
        return low
    if value > high:
        return high
    return value


@hot
def differs(a: int, b: int) -> int:
    """Return 1 if the two differ, else 0."""
    if a == b:
        return 0
    return 1


@hot
def outside(value: int, low: int, high: int, special: int) -> int:
    """Return 1 if ``value`` is neither ``special`` nor within ``low .. high``, else 0."""
    if value == special:
        return 0
    if value < low or value > high:
        return 1
    return 0
