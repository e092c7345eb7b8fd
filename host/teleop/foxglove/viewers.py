"""Messages of Foxglove's viewers: those of docs/teleop.md or a speed, once they have sent the pairing code.

A viewer is a connection. None of its messages counts before it has paired, because any web page that a browser on this
machine shows could also connect. Limits are those of the page's messages.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ...control.messages import BadMessage, Drive, Message, check, decode
from ..web.access import Pairing
from ..web.limits import BURST, MESSAGES_PER_S, Bucket

COMMAND, SPEED = "/command", "/cmd_vel"
PEER = "foxglove"  # all viewers count as one peer: a new connection gets no new guesses


@dataclass
class Viewer:
    """One connection."""

    messages: Bucket
    paired: bool = False


class Viewers:
    """All connections.

    ``forward`` passes a message with its viewer's number to the loop; ``tell`` sends a note to all viewers.
    """

    def __init__(
        self,
        code: str,
        forward: Callable[[dict[str, Any]], None],
        tell: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._pairing, self._forward, self._tell, self._clock = Pairing(code, (), clock), forward, tell, clock
        self.known: dict[int, Viewer] = {}
        self.malformed = self.limited = self.refused = 0

    def join(self, number: int) -> None:
        """A viewer wants to publish."""
        self.known.setdefault(number, Viewer(Bucket(MESSAGES_PER_S, BURST, self._clock)))

    def leave(self, number: int) -> None:
        """A viewer is gone."""
        if self.known.pop(number, None) is not None:
            self._forward({"page": number, "gone": True})

    def take(self, number: int, topic: str, data: bytes) -> None:
        """Take a message that a viewer has published."""
        self.join(number)
        viewer = self.known[number]
        if not viewer.messages.take() and b'"stop"' not in data:
            self.limited += 1
            return
        try:
            message = _message(topic, data)
        except BadMessage as error:
            self.malformed += 1
            self._tell(f"viewer {number}: {topic}: {error}")
            return
        if message["type"] == "pair":
            self._pair(number, viewer, message["code"])
        elif viewer.paired:
            self._forward({"page": number, "message": message})
        else:
            self.refused += 1
            self._tell(f'viewer {number} is not paired: publish {{"type": "pair", "code": "..."}} on {COMMAND} first')

    def _pair(self, number: int, viewer: Viewer, code: str) -> None:
        viewer.paired = viewer.paired or self._pairing.pair(code, PEER) is not None
        self.refused += not viewer.paired
        told = "paired" if viewer.paired else "wrong code, or too many guesses: wait a moment"
        self._tell(f"viewer {number}: {told}")


def _message(topic: str, data: bytes) -> Message:
    """Return the published data as a message of the loop or a pairing; BadMessage if they are neither."""
    if topic not in (COMMAND, SPEED):
        raise BadMessage(f"allowed: {COMMAND} and {SPEED}")
    value = decode(data)
    if not isinstance(value, dict):
        raise BadMessage("not a JSON object")
    if topic == SPEED:
        return _speed(value)
    return _pairing(value) if value.get("type") == "pair" else check(value)


def _pairing(value: dict[str, Any]) -> Message:
    if set(value) != {"type", "code"} or not isinstance(value["code"], str):
        raise BadMessage('pair: allowed: {"type": "pair", "code": "six digits"}')
    return value


def _speed(value: dict[str, Any]) -> Message:
    """Return a twist (ROS geometry_msgs/Twist as JSON) as a stick command with a level body."""
    try:
        linear, angular = value["linear"], value["angular"]
        speeds = linear["x"], linear["y"], angular["z"]
    except (KeyError, TypeError):
        raise BadMessage("allowed: linear.x, linear.y in m/s and angular.z in rad/s") from None
    names = ("vx_m_s", "vy_m_s", "wz_rad_s")
    return check({**Drive().message(), **dict(zip(names, speeds, strict=True))})
