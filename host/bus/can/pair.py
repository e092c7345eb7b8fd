"""Two buses behind one port: the front legs' joints on the first, the rear legs' on the second.

Frames to one joint go to its bus, frames to all go to both. The host passes an emergency stop on: when it hears one on
one bus, it sends it on the other before it reads anything else.
"""

from shared.wire import names as w
from shared.wire.framing import frame_block, frame_node, setpoint_group

from .port import Port, Received

REAR = 7  # first node of the second bus: 1 + 3 x leg + joint, legs FR, FL, RR, RL


def bus_of(node: int) -> int:
    """Return the bus, 0 or 1, of a node 1 .. 12."""
    return int(node >= REAR)


def buses_for(identifier: int) -> tuple[int, ...]:
    """Return the buses that a frame of the host concerns; groups of four set-points can span both."""
    block = frame_block(identifier)
    if block == w.SETPOINT_POSITION_ID:
        first = 4 * setpoint_group(identifier) + 1
        return tuple(sorted({bus_of(first), bus_of(first + 3)}))
    node = frame_node(identifier)
    if block in (w.E_STOP_ID, w.SYNC_ID, w.UPDATE_BLOCK_ID) or node < 1:
        return (0, 1)
    return (bus_of(node),)


class PairPort(Port):
    """Two ports of one machine, combined; both count together."""

    def __init__(self, front: Port, rear: Port) -> None:
        super().__init__()
        self.ports = (front, rear)
        self.name, self.bitrate = f"{front.name} and {rear.name}", front.bitrate
        front.counters = rear.counters = self.counters
        self._next = 0

    def send(self, identifier: int, data: bytes) -> bool:
        """See Port: True if every bus it concerns has taken it."""
        sent = [self.ports[bus].send(identifier, data) for bus in buses_for(identifier)]
        return all(sent)

    def send_first(self, identifier: int, data: bytes) -> bool:
        """See Port: True if every bus it concerns has taken it."""
        sent = [self.ports[bus].send_first(identifier, data) for bus in buses_for(identifier)]
        return all(sent)

    def receive(self) -> Received | None:
        """See Port: from both buses in turn."""
        for _ in self.ports:
            bus, self._next = self._next, 1 - self._next
            frame = self.ports[bus].receive()
            if frame is not None:
                if frame.identifier == w.E_STOP_ID:
                    self.ports[1 - bus].send_first(w.E_STOP_ID, b"")
                return frame
        return None

    @property
    def trouble(self) -> str:
        """See Port."""
        return "; ".join(filter(None, (port.trouble for port in self.ports)))

    def now(self) -> float:
        """See Port: one clock."""
        return self.ports[0].now()

    def wait_until(self, time_s: float) -> None:
        """See Port."""
        self.ports[0].wait_until(time_s)

    def close(self) -> None:
        """See Port."""
        for port in self.ports:
            port.close()
