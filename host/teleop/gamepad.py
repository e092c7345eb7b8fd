"""A gamepad at this machine (Linux, library evdev): the left stick walks, the right stick turns and pitches.

A pad reports only changes, so a held stick reports nothing. While the dead-man button (left shoulder) is held, the
last position is sent again and again; after its release nothing is sent, and the robot stops.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..control.arbiter import Client
from ..control.messages import Drive, Message
from ..robot.model import Robot
from ..util.errors import UserError
from .keyboard import Fastest

DEAD_ZONE = 0.08
# linux/input-event-codes.h
EV_KEY, EV_ABS = 1, 3
ABS_X, ABS_Y, ABS_RX, ABS_RY = 0, 1, 3, 4
BTN_SOUTH, BTN_EAST, BTN_NORTH, BTN_WEST, BTN_TL, BTN_SELECT, BTN_START = 304, 305, 307, 308, 310, 314, 315
BUTTONS: dict[int, Message] = {
    BTN_EAST: {"type": "stop"},
    BTN_SELECT: {"type": "reset"},
    BTN_START: {"type": "posture", "posture": "stand"},
    BTN_WEST: {"type": "posture", "posture": "sit"},
    BTN_NORTH: {"type": "posture", "posture": "rest"},
}


class Gamepad:
    """A pad as an input of the hub; ``device`` is an evdev.InputDevice or anything that reads like one.

    ``fastest`` returns the gait's top speeds, which a full stick commands: m/s forward and sideways, rad/s.
    """

    client = Client("gamepad")

    def __init__(self, robot: Robot, fastest: Fastest, device: Any) -> None:
        self._robot, self._fastest, self._device = robot, fastest, device
        self._ranges = {axis: _range(device, axis) for axis in (ABS_X, ABS_Y, ABS_RX, ABS_RY)}
        self._axes = dict.fromkeys(self._ranges, 0.0)
        self._held = False

    def fileno(self) -> int:
        """See hub.Input."""
        descriptor: int = self._device.fileno()
        return descriptor

    def messages(self) -> list[Message]:
        """See hub.Input."""
        said = []
        for event in self._device.read():
            if event.type == EV_KEY and event.code == BTN_TL:
                self._held = bool(event.value)
            elif event.type == EV_KEY and event.value == 1 and event.code in BUTTONS:
                said.append(BUTTONS[event.code])
            elif event.type == EV_ABS and event.code in self._axes:
                self._axes[event.code] = self._share(event.code, event.value)
        return said + self.repeat()

    def repeat(self) -> list[Message]:
        """Return the sticks' command while the dead-man button is held, else nothing."""
        if not self._held:
            return []
        pitch_rad, stick = self._robot.body_limits.angles_rad[1], self._axes
        ahead_m_s, aside_m_s, turning_rad_s = self._fastest()
        speeds = -stick[ABS_Y] * ahead_m_s, -stick[ABS_X] * aside_m_s, -stick[ABS_RX] * turning_rad_s
        return [Drive(*speeds, (0.0, 0.0, 0.0, 0.0, -stick[ABS_RY] * pitch_rad, 0.0)).message()]

    def _share(self, axis: int, value: int) -> float:
        """Return a stick's position, -1 .. 1, 0 near the middle."""
        low, high = self._ranges[axis]
        share = max(-1.0, min(1.0, (2 * value - low - high) / (high - low)))
        return 0.0 if abs(share) < DEAD_ZONE else share


def open_gamepad(robot: Robot, fastest: Fastest, path: str, opener: Callable[[str], Any] | None = None) -> Gamepad:
    """Return the pad at /dev/input/eventN, or the first one for "auto"."""
    if opener is None:
        import evdev

        opener = evdev.InputDevice
    for each in sorted(map(str, Path("/dev/input").glob("event*"))) if path == "auto" else [path]:
        try:
            device = opener(each)
        except PermissionError:
            raise UserError(f"{each}: no permission; run: sudo usermod -aG input $USER   and log in again") from None
        except OSError as error:
            raise UserError(f"--gamepad {each}: {error.strerror or error}") from None
        if BTN_SOUTH in device.capabilities().get(EV_KEY, []):
            return Gamepad(robot, fastest, device)
    raise UserError("--gamepad: no gamepad found: plug one in or pair one; ls /dev/input/event* shows the devices")


def _range(device: Any, axis: int) -> tuple[int, int]:
    info = device.absinfo(axis)
    if info.max <= info.min:
        raise UserError(f"--gamepad: the gamepad reports no range for its axis {axis}: use another gamepad")
    return info.min, info.max
