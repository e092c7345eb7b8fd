"""One interface to a CAN bus as the host sees it: send without waiting, receive what has come, wait until a time.

Times are monotonic seconds, of the machine or of the simulation; nothing here reads the wall clock.
"""

from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass
from typing import NamedTuple, Self

BITRATE = 1_000_000  # unless a robot file says otherwise


class Received(NamedTuple):
    """A frame, and when it came."""

    time_s: float
    identifier: int
    data: bytes


@dataclass
class PortCounters:
    """Counts of frames: what was ``unreadable`` is none, ``full`` found no room in the send buffer.

    ``bus_off`` is how often the node was off.
    """

    sent: int = 0
    received: int = 0
    unreadable: int = 0
    full: int = 0
    bus_off: int = 0

    def as_dict(self) -> dict[str, int]:
        """Return plain values for JSON."""
        return asdict(self)


class Port(ABC):
    """A node on a CAN bus. Use it as a context manager."""

    name = "abstract"
    bitrate = BITRATE

    def __init__(self) -> None:
        self.counters = PortCounters()

    @abstractmethod
    def send(self, identifier: int, data: bytes) -> bool:
        """Put a frame into the send buffer; False, and counted, if there is no room or the node is bus-off."""

    def send_first(self, identifier: int, data: bytes) -> bool:
        """Send a frame before all that wait; those are thrown away as far as the adapter allows."""
        return self.send(identifier, data)

    @abstractmethod
    def receive(self) -> Received | None:
        """Return the oldest frame that has come, or None; does not wait, and checks only a few frames."""

    @abstractmethod
    def now(self) -> float:
        """Return the time, s."""

    @abstractmethod
    def wait_until(self, time_s: float) -> None:
        """Wait until a time; return at once if it is over."""

    @property
    def trouble(self) -> str:
        """Return a sentence on what is wrong with the bus now, with what to do, or ""."""
        return ""

    def close(self) -> None:
        """Leave the bus; may be called twice."""
        return

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
