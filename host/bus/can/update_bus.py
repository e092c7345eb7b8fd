"""The host's end of the bus while firmware goes over it: requests to joints, blocks to all, at a share of the bus.

All traffic, sent or heard, is counted in bits on the wire, with stuffing and intermission (load.py); the next frame
waits until the share allows it.
"""

import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from shared.record import unpack
from shared.wire import codec
from shared.wire import names as w
from shared.wire.framing import BLOCK_HEADER, BLOCK_HIGH, BLOCK_SLOT, frame_block, frame_node

from ...protocol.frames import new_frame
from ...util.errors import NOT_ACHIEVED, UserError
from .load import frame_bits
from .port import Port

SHARE = 0.66  # of the bus, so that it stays below 0.7 with what joints send by themselves
BURST_S = 0.001  # sent at once: a computer can't wait for just 0.1 ms (chosen)
ANSWER_S = 0.05  # a joint answers within a millisecond; adapters and computers take longer
TRIES = 10
FULL_S = 1.0  # a send buffer that takes nothing for this long belongs to a bus that does not work
BLOCK_BYTES = 6


@dataclass(frozen=True)
class Ask:
    """An update_request without its key."""

    command: int
    index: int = 0
    value: int = 0


@dataclass
class Heard:
    """A joint's last reports, and when it last sent anything."""

    node: int
    heard_s: float = float("-inf")
    answer: codec.UpdateAnswer | None = None  # to the last question
    last: codec.UpdateAnswer = field(default_factory=codec.UpdateAnswer)  # said at all
    heartbeat: codec.Heartbeat | None = None
    missing: set[int] = field(default_factory=set)


class UpdateBus:
    """Joints behind ``port`` during one update, which is known by ``key``, 0 .. 255."""

    def __init__(self, port: Port, key: int) -> None:
        self.port, self.key = port, key
        self.joints = {node: Heard(node) for node in range(1, 13)}
        self.bits = 0  # seen on the bus
        self._per_s = port.bitrate * SHARE
        self._free_s = port.now()
        self._in, self._out = new_frame(), new_frame()
        self._request = codec.UpdateRequest()

    def request(self, node: int, ask: Ask) -> None:
        """Send a request to a joint."""
        unpack(self._request, (ask.command, self.key, ask.index, ask.value & 0xFFFF, ask.value >> 16))
        codec.encode_update_request(self._out.words, self._request)
        self._send(w.UPDATE_REQUEST_ID + node, self._out.data.tobytes())

    def block(self, slot: int, number: int, data: bytes, header: bool = False) -> None:
        """Send six bytes of a slot's image, or of its header, to all joints that write this slot."""
        identifier = w.UPDATE_BLOCK_ID + BLOCK_SLOT * slot + BLOCK_HEADER * header + BLOCK_HIGH * (number >> 16)
        self._send(identifier, struct.pack("<H6s", number & 0xFFFF, data.ljust(BLOCK_BYTES, b"\xff")))

    def _send(self, identifier: int, data: bytes) -> None:
        port = self.port
        self.listen()
        if self._free_s > port.now() + BURST_S:
            port.wait_until(self._free_s)
            self.listen()
        end_s = port.now() + FULL_S
        while not port.send(identifier, data):
            if port.now() > end_s:
                why = port.trouble or "nothing can be sent: check the cable, both terminators and the joints' power"
                raise UserError(f"{port.name}: {why}", NOT_ACHIEVED)
            port.wait_until(port.now() + BURST_S)
            self.listen()
        self._count(identifier, data)

    def _count(self, identifier: int, data: bytes) -> None:
        bits = frame_bits(identifier, data)
        self.bits += bits
        self._free_s = max(self._free_s, self.port.now() - BURST_S) + bits / self._per_s

    def listen(self) -> None:
        """Read what has come."""
        while (frame := self.port.receive()) is not None:
            self._count(frame.identifier, frame.data)
            block, node = frame_block(frame.identifier), frame_node(frame.identifier)
            if node in self.joints:
                self._in.data[: len(frame.data)] = frame.data
                self._take(block, self.joints[node], len(frame.data), frame.time_s)

    def _take(self, block: int, joint: Heard, length: int, time_s: float) -> None:
        words = self._in.words
        if block == w.UPDATE_ANSWER_ID and length == w.UPDATE_ANSWER_LENGTH:
            answer = codec.UpdateAnswer()
            if codec.decode_update_answer(words, answer) == 0 and answer.key == self.key:
                joint.answer = joint.last = answer
                joint.heard_s = time_s
        elif block == w.UPDATE_MISSING_ID and length == w.UPDATE_MISSING_LENGTH:
            missing = codec.UpdateMissing()
            codec.decode_update_missing(words, missing)
            joint.missing |= {missing.first, missing.second, missing.third}
            joint.heard_s = time_s
        elif block == w.HEARTBEAT_ID and length == w.HEARTBEAT_LENGTH:
            heartbeat = codec.Heartbeat()
            codec.decode_heartbeat(words, heartbeat)  # its layout is the same in every firmware; meanings may differ
            joint.heartbeat, joint.heard_s = heartbeat, time_s

    def slow_down(self) -> None:
        """Use a tenth less of the bus from now on."""
        self._per_s *= 0.9

    def wait(self, seconds: float) -> None:
        """Listen for a time."""
        end_s = self.port.now() + seconds
        while self.port.now() < end_s:
            self.port.wait_until(self.port.now() + BURST_S)
            self.listen()

    def ask(
        self, asks: Mapping[int, Ask], wait_s: float = ANSWER_S, tries: int = TRIES
    ) -> dict[int, codec.UpdateAnswer]:
        """Ask joints, repeating for those that do not answer; return the answers by node."""
        found: dict[int, codec.UpdateAnswer] = {}
        for _ in range(tries):
            left = [node for node in asks if node not in found]
            if not left:
                break
            for node in left:
                self.joints[node].answer = None
                self.request(node, asks[node])
            self._await(asks, left, found, wait_s)
        return found

    def _await(
        self, asks: Mapping[int, Ask], left: Iterable[int], found: dict[int, codec.UpdateAnswer], wait_s: float
    ) -> None:
        end_s = self.port.now() + wait_s
        while self.port.now() < end_s and any(node not in found for node in left):
            self.port.wait_until(self.port.now() + BURST_S)
            self.listen()
            for node in left:
                answer = self.joints[node].answer
                if answer is not None and answer.command == asks[node].command and _is_of(answer, asks[node]):
                    found[node] = answer


def _is_of(answer: codec.UpdateAnswer, ask: Ask) -> bool:
    """Return whether a word of a header is the wanted one."""
    return ask.command != w.UPDATE_LOOK or answer.index == ask.index
