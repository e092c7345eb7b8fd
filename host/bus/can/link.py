"""The host's end of the joints' bus: sends set-points and SYNC, receives all that the joints send, counts losses.

Nothing waits for an answer: SYNC makes the joints take their set-points at once and reply; the next cycle first reads
what came since the last. A joint without a reply by then is ``lost``; a reply that comes a cycle too late
turns that into ``late``. Values are the wire's integers (docs/can-protocol.md).
"""

from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf

from shared.record import pack, unpack
from shared.wire import codec
from shared.wire import names as w
from shared.wire.framing import NODES, frame_block, frame_node

from ...protocol.frames import kinds, new_frame
from .port import Port

GROUPS = NODES // 4
# Frames to read at once: more than the shortest that fit into a cycle of 200 Hz on two full buses, in less than half of
# it.
RECEIVE_MOST = 256
HEARTBEAT_S = 1.0  # five heartbeats
RECEIVE_S = 0.002


@dataclass
class JointView:
    """One joint's last reports, raw, and how many were missing."""

    node: int
    reply: codec.Reply = field(default_factory=codec.Reply)
    status: codec.SlowStatus = field(default_factory=codec.SlowStatus)
    heartbeat: codec.Heartbeat = field(default_factory=codec.Heartbeat)
    fault: codec.Fault = field(default_factory=codec.Fault)
    reply_s: float = -inf
    status_s: float = -inf
    heartbeat_s: float = -inf
    fault_s: float = -inf
    replies: int = 0
    lost: int = 0
    late: int = 0
    bad: int = 0
    answered: bool = True

    @property
    def state(self) -> int:
        """Return STATE_* of the last heartbeat."""
        return self.heartbeat.state

    @property
    def state_words(self) -> str:
        """Return the state's name."""
        signals = kinds()[w.HEARTBEAT_ID + self.node].message.signals
        return dict(next(s for s in signals if s.name == "state").choices)[self.state].replace("_", " ")

    @property
    def enabled(self) -> bool:
        """Return whether the joint obeys set-points."""
        return self.state == w.STATE_OPERATION_ENABLED


@dataclass(frozen=True)
class Response:
    """An answer to a request."""

    node: int
    command: int
    sequence: int
    result: int
    index: int
    value: int


# What a joint reports: the length, and where in its view it goes
_REPORTS: dict[int, tuple[int, Callable[..., int], str]] = {
    w.REPLY_ID: (w.REPLY_LENGTH, codec.decode_reply, "reply"),
    w.SLOW_STATUS_ID: (w.SLOW_STATUS_LENGTH, codec.decode_slow_status, "status"),
    w.HEARTBEAT_ID: (w.HEARTBEAT_LENGTH, codec.decode_heartbeat, "heartbeat"),
    w.FAULT_ID: (w.FAULT_LENGTH, codec.decode_fault, "fault"),
}


class JointLink:
    """Nodes 1 .. 12 behind one port; ``session`` 1 .. 255 is this host's."""

    def __init__(self, port: Port, session: int, nodes: Sequence[int] = tuple(range(1, NODES + 1))) -> None:
        self.port, self.session, self.nodes = port, session, tuple(nodes)
        self.views = {node: JointView(node) for node in range(NODES + 1)}
        self.responses: list[Response] = []
        self.e_stops = 0
        self.syncs = 0
        self.floods = 0  # how often more had come than is read at once
        self._in, self._out = new_frame(), new_frame()
        self._slots = array("i", [w.NO_CHANGE] * 4)
        self._sync = codec.Sync()
        self._sync.session = session
        self._answer = codec.ServiceResponse()
        self._counting = False
        self._sequence = 37 * session & 0xFF  # another host's last request must not look like this one's first
        self._request = codec.ServiceRequest()

    def alive(self) -> list[int]:
        """Return the nodes that have sent a heartbeat lately."""
        now_s = self.port.now()
        return [node for node in self.nodes if now_s - self.views[node].heartbeat_s <= HEARTBEAT_S]

    def request(self, node: int, command: int, index: int = 0, value: int = 0, again: bool = False) -> int:
        """Send a request to a node, 0 for all, and return its sequence number; ``again`` reuses the last number."""
        if not again:
            self._sequence = (self._sequence + 1) & 0xFF
        unpack(self._request, (command, self._sequence, self.session, index, value))
        codec.encode_service_request(self._out.words, self._request)
        self.port.send(w.SERVICE_REQUEST_ID + node, self._out.data.tobytes())
        return self._sequence

    def send_setpoints(self, identifier: int, values: Sequence[int]) -> None:
        """Send one kind of set-point: twelve raw values, NO_CHANGE for no new one."""
        for group in range(GROUPS):
            for slot in range(4):
                self._slots[slot] = values[4 * group + slot]
            codec.encode_group(self._out.words, self._slots)
            self.port.send(identifier + 8 * group, self._out.data.tobytes())

    def sync(self) -> None:
        """Finish the last cycle's counts and send SYNC."""
        for node in self.nodes if self._counting else ():
            view = self.views[node]
            if not view.answered:
                view.lost += 1
        self._sync.counter = self.syncs & 0xFF
        codec.encode_sync(self._out.words, self._sync)
        self._counting = self.port.send(w.SYNC_ID, self._out.data[: w.SYNC_LENGTH].tobytes())
        self.syncs += 1
        for node in self.nodes:
            self.views[node].answered = False

    def emergency_stop(self) -> bool:
        """Send the frame that takes every joint's torque away, before all others; False if the adapter takes none."""
        return self.port.send_first(w.E_STOP_ID, b"")

    def receive(self) -> None:
        """Read what has come, up to a limit, so that a flood can't delay the cycle."""
        end_s = self.port.now() + RECEIVE_S
        for _ in range(RECEIVE_MOST):
            frame = self.port.receive()
            if frame is None:
                return
            self._take(frame.time_s, frame.identifier, frame.data)
            if self.port.now() > end_s:
                break
        self.floods += 1

    def _take(self, time_s: float, identifier: int, data: bytes) -> None:
        block, node = frame_block(identifier), frame_node(identifier)
        if identifier == w.E_STOP_ID:
            self.e_stops += 1
            return
        if node < 0 or block < 0 or len(data) > 8:
            return
        self._in.data[: len(data)] = data
        if block in _REPORTS:
            self._take_report(self.views[node], block, time_s, len(data))
        elif block == w.SERVICE_RESPONSE_ID:
            self._take_response(node, len(data))

    def _take_report(self, view: JointView, block: int, time_s: float, length: int) -> None:
        needed, decode, name = _REPORTS[block]
        if length < needed or decode(self._in.words, getattr(view, name)):
            view.bad += 1
            return
        setattr(view, f"{name}_s", time_s)
        if block == w.REPLY_ID:
            self._count_reply(view)

    def _count_reply(self, view: JointView) -> None:
        view.replies += 1
        if view.answered and view.lost:
            view.lost -= 1
            view.late += 1
        view.answered = True

    def _take_response(self, node: int, length: int) -> None:
        if length >= w.SERVICE_RESPONSE_LENGTH and not codec.decode_service_response(self._in.words, self._answer):
            self.responses.append(Response(node, *pack(self._answer)))
