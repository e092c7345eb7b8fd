"""A port that is no device: dynamixel-sdk writes into an emulated bus in this process and reads its answers.

Time is whatever ``clock`` says, so a minute of walking takes as long as it needs, and no longer.
"""

from collections.abc import Callable

from .bus import EmulatedBus


class LoopbackPort:
    """The part of PortHandler's interface that the SDK's packets use."""

    is_real = False

    def __init__(self, bus: EmulatedBus, clock: Callable[[], float]) -> None:
        self.bus, self._clock = bus, clock
        self.port_name = "emulated"
        self.is_using = False
        self.patience_ms = 0.0
        self._baud = bus.baud
        self._waiting = bytearray()

    def open(self) -> None:
        """Nothing to open."""

    def closePort(self) -> None:
        """Nothing to close."""

    def clearPort(self) -> None:
        """Forget unread answers; the SDK calls this before each packet, so the line was also silent."""
        self._waiting.clear()
        self.bus.idle()

    def setBaudRate(self, baud: int) -> bool:
        """Talk at another rate."""
        self._baud = baud
        return True

    def getBaudRate(self) -> int:
        """Return the rate."""
        return self._baud

    def writePort(self, packet: list[int]) -> int:
        """Give a packet to the servos and keep their answers."""
        for answer in self.bus.receive(bytes(packet), self._clock(), self._baud):
            self._waiting += answer
        return len(packet)

    def readPort(self, length: int) -> bytes:
        """Return up to ``length`` bytes."""
        data = bytes(self._waiting[:length])
        del self._waiting[:length]
        return data

    def setPacketTimeout(self, packet_length: int) -> None:
        """Answers are there at once or never."""

    def setPacketTimeoutMillis(self, msec: float) -> None:
        """Answers are there at once or never."""

    def allow(self, length: int, more_ms: float, most: int) -> None:
        """Answers are there at once or never."""

    def allow_more(self, length: int) -> None:
        """Answers are there at once or never."""

    def isPacketTimeout(self) -> bool:
        """True once all that came has been taken."""
        return not self._waiting
