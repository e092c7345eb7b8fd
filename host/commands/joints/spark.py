"""One-line curves for the terminal: a value's last seconds, from its least to its largest."""

from collections import deque
from collections.abc import Sequence

BARS = "▁▂▃▄▅▆▇█"
KEPT = 40  # values, one per refresh


def spark(values: Sequence[float | None], least_span: float) -> str:
    """Return one bar per value, a space where it is unknown; a span below ``least_span`` does not fill the height."""
    known = [value for value in values if value is not None]
    if not known:
        return ""
    low, high = min(known), max(known)
    span = max(high - low, least_span)
    return "".join(" " if v is None else BARS[min(len(BARS) - 1, int((v - low) / span * len(BARS)))] for v in values)


class Curves:
    """The last values of many things by name."""

    def __init__(self, least_span: float) -> None:
        self._least_span = least_span
        self._kept: dict[str, deque[float | None]] = {}

    def add(self, name: str, value: float | None) -> str:
        """Take a value and return its curve."""
        curve = self._kept.setdefault(name, deque(maxlen=KEPT))
        curve.append(value)
        return spark(list(curve), self._least_span)
