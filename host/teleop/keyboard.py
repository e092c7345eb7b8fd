"""Keys of a terminal as messages. A terminal reports presses and repeats, never releases.

So a drive key acts while it repeats: each press is one command, and the dead-man ends the walk 300 ms after the last.
Body pose, gait and speed share change in steps and stay.
"""

import os
import re
from collections.abc import Callable
from dataclasses import dataclass, field

from ..control.arbiter import Client
from ..control.messages import Drive, Message
from ..robot.gait_names import gait_names
from ..robot.model import Robot

Fastest = Callable[[], tuple[float, float, float]]
POSE_STEPS = 10  # presses from the middle to the limit
LONGEST_READ = 256

# Key -> vx, vy, wz as shares of the gait's largest speeds.
DRIVE_KEYS = {
    "w": (1, 0, 0),
    "s": (-1, 0, 0),
    "a": (0, 0, 1),
    "d": (0, 0, -1),
    "q": (0, 1, 0),
    "e": (0, -1, 0),
    "z": (1, 0, 1),
    "c": (1, 0, -1),
}
# Key -> index in the pose (x, y, z, roll, pitch, yaw), direction. Pitch > 0 is nose down.
POSE_KEYS = {
    "up": (4, 1),
    "down": (4, -1),
    "left": (3, -1),
    "right": (3, 1),
    "u": (5, 1),
    "o": (5, -1),
    "i": (2, 1),
    "k": (2, -1),
    "j": (1, 1),
    "l": (1, -1),
    "n": (0, 1),
    "m": (0, -1),
}
POSTURE_KEYS = {"t": "stand", "g": "sit", "x": "rest"}
HELP = (
    ("space", "EMERGENCY STOP"),
    ("r", "reset the stop"),
    ("t g x", "stand up, sit, joints off"),
    ("w s", "forward, back"),
    ("a d", "turn left, right"),
    ("q e", "sideways left, right"),
    ("z c", "forward in a curve"),
    ("1 .. 9 0", "speed 10 .. 90, 100 %"),
    ("arrows", "pitch and roll"),
    ("i k", "body up, down"),
    ("j l n m", "body left, right, ahead, back"),
    ("u o h", "yaw left, right; level"),
    ("y b", "next gait, balance on/off"),
    ("Ctrl-C", "sit down and end"),
)
_KEY = re.compile(rb"\x1b\[[ABCD]|\x1bO[ABCD]|\x1b\[[0-9;]*.?|[\x00-\x7f]|[\x80-\xff]+")
_ARROWS = {b"A": "up", b"B": "down", b"C": "right", b"D": "left"}


def keys_of(data: bytes) -> list[str]:
    """Return the names of the keys in a terminal's input; other keys become ""."""
    names = []
    for part in _KEY.findall(data):
        if part.startswith((b"\x1b[", b"\x1bO")):
            names.append(_ARROWS.get(part[2:], "") if len(part) == 3 else "")
        else:
            names.append(part.decode("ascii", "replace").lower())
    return names


@dataclass
class Keys:
    """What the keys have set so far. ``fastest`` returns the gait's top speeds: m/s forward and sideways, rad/s."""

    robot: Robot
    gait: str
    fastest: Fastest
    share: float = 0.5
    balance: bool = True
    pose: list[float] = field(default_factory=lambda: [0.0] * 6)

    def message(self, key: str) -> Message | None:
        """Return a key's message, or None."""
        if key == " ":
            return {"type": "stop"}
        if key == "r":
            return {"type": "reset"}
        if key in POSTURE_KEYS:
            return {"type": "posture", "posture": POSTURE_KEYS[key]}
        if key == "y":
            names = gait_names(self.robot)
            self.gait = names[(names.index(self.gait) + 1) % len(names)]
            return {"type": "gait", "gait": self.gait}
        if key == "b":
            self.balance = not self.balance
            return {"type": "balance", "on": self.balance}
        return self._stick(key)

    def _stick(self, key: str) -> Message | None:
        """Return the stick command for a key of speed or pose."""
        if key in DRIVE_KEYS:
            return self._drive(*DRIVE_KEYS[key])
        if key in POSE_KEYS:
            (axis, direction), limits = POSE_KEYS[key], self.robot.body_limits
            limit = (limits.x_m, limits.y_m, limits.z_m, *limits.angles_rad)[axis]
            moved = self.pose[axis] + direction * limit / POSE_STEPS
            self.pose[axis] = max(-limit, min(limit, moved))
        elif key == "h":
            self.pose = [0.0] * 6
        elif key.isdecimal():
            self.share = (int(key) or 10) / 10
        else:
            return None
        return self._drive(0, 0, 0)

    def _drive(self, vx: float, vy: float, wz: float) -> Message:
        ahead_m_s, aside_m_s, turning_rad_s = (self.share * most for most in self.fastest())
        speeds = vx * ahead_m_s, vy * aside_m_s, wz * turning_rad_s
        return {**Drive(*speeds).message(), "pose": list(self.pose)}


class Keyboard:
    """A terminal's keys as an input of the hub."""

    client = Client("keyboard")

    def __init__(self, robot: Robot, fastest: Fastest, descriptor: int) -> None:
        self.keys = Keys(robot, robot.gait.default, fastest)
        self._descriptor = descriptor

    def fileno(self) -> int:
        """See hub.Input."""
        return self._descriptor

    def messages(self) -> list[Message]:
        """See hub.Input: of a burst only the last drive key counts, but all other keys count."""
        data = os.read(self._descriptor, LONGEST_READ)
        if not data:
            raise OSError("the terminal is gone")
        return [message for key in keys_of(data) if (message := self.keys.message(key)) is not None]
