"""One message of a driver: a JSON object with exactly these keys, checked before anything acts on it.

The page, scripts and the loop use the same messages (docs/teleop.md). Anything that is not exactly one is refused:
unknown or missing keys, wrong types, numbers beyond their range, more than LONGEST bytes.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

LONGEST = 512
POSTURES = ("stand", "sit", "rest")
# Far more than any robot can do: the planner applies the robot's own limits. Only nonsense is refused here.
LARGEST_SPEED = 10.0
LARGEST_POSE = 2.0
LATEST_MS = 1e14
LONGEST_NAME = 30
LARGEST_STEP_DEG, LONGEST_STEP_S = 20.0, 5.0

Message = dict[str, Any]


class BadMessage(ValueError):
    """Why a message is refused, in a few words."""


@dataclass(frozen=True)
class Drive:
    """The sticks' command: speeds in m/s and rad/s, body pose x, y, z in m and roll, pitch, yaw in rad."""

    vx_m_s: float = 0.0
    vy_m_s: float = 0.0
    wz_rad_s: float = 0.0
    pose: tuple[float, float, float, float, float, float] = (0.0,) * 6

    @property
    def moves(self) -> bool:
        """True if it commands a walk."""
        return bool(self.vx_m_s or self.vy_m_s or self.wz_rad_s)

    def message(self) -> Message:
        """Return the message with this command."""
        speeds = {"vx_m_s": self.vx_m_s, "vy_m_s": self.vy_m_s, "wz_rad_s": self.wz_rad_s}
        return {"type": "drive", **speeds, "pose": list(self.pose)}

    @classmethod
    def of(cls, message: Message) -> "Drive":
        """Return the sticks of a checked message."""
        pose = tuple(float(value) for value in message["pose"])
        return cls(float(message["vx_m_s"]), float(message["vy_m_s"]), float(message["wz_rad_s"]), pose)  # type: ignore[arg-type]


def _is_number(largest: float) -> Callable[[Any], bool]:
    def check(value: Any) -> bool:
        return type(value) in (int, float) and -largest <= value <= largest

    return check


def _is_pose(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 6 and all(map(_is_number(LARGEST_POSE), value))


_SPEED = _is_number(LARGEST_SPEED)
_TIME = _is_number(LATEST_MS)
# Type of message -> key -> check.
Keys = dict[str, dict[str, Callable[[Any], bool]]]
KEYS: Keys = {
    "drive": {"vx_m_s": _SPEED, "vy_m_s": _SPEED, "wz_rad_s": _SPEED, "pose": _is_pose},
    "posture": {"posture": lambda value: value in POSTURES and isinstance(value, str)},
    "gait": {"gait": lambda value: isinstance(value, str) and len(value) <= LONGEST_NAME},
    "balance": {"on": lambda value: isinstance(value, bool)},
    "ground": {"ground": lambda value: isinstance(value, str) and len(value) <= LONGEST_NAME},
    "take": {},
    "release": {},
    "stop": {},
    "reset": {},
    "ping": {"t_ms": _TIME},
}


def _is_node(value: Any) -> bool:
    return type(value) is int and 1 <= value <= 12


# For the joints' page (host/teleop/joint_page.py); a step is one of the motor's angle.
JOINT_KEYS: Keys = {
    "joint": {"node": _is_node},
    "parameter": {
        "node": _is_node,
        "name": lambda value: isinstance(value, str) and len(value) <= LONGEST_NAME,
        "value": _is_number(2.0**30),
    },
    "keep": {"node": _is_node},
    "arm": {"on": lambda value: isinstance(value, bool)},
    "step": {"node": _is_node, "deg": _is_number(LARGEST_STEP_DEG), "seconds": _is_number(LONGEST_STEP_S)},
    "clear": {},
    "stop": {},
    "ping": {"t_ms": _TIME},
}
# Optional: when it happened, by the sender's clock.
OPTIONAL = {"drive": {"t_ms": _TIME}, "stop": {"t_ms": _TIME}}


def parse(text: str | bytes, all_keys: Keys = KEYS) -> Message:
    """Return a checked message, or raise BadMessage."""
    return check(decode(text), all_keys)


def decode(text: str | bytes) -> Any:
    """Return the value of some JSON that is no longer than a message, or raise BadMessage."""
    if len(text) > LONGEST:
        raise BadMessage(f"{len(text)} bytes, allowed at most {LONGEST}")
    try:
        return json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError):
        raise BadMessage("not JSON") from None


def check(value: Any, all_keys: Keys = KEYS) -> Message:
    """Return ``value`` if it is a message, or raise BadMessage."""
    kind = value.get("type") if isinstance(value, dict) else None
    if not isinstance(kind, str) or kind not in all_keys:
        raise BadMessage(f"not an object with a type of {', '.join(all_keys)}")
    keys = all_keys[kind]
    allowed = {**keys, **OPTIONAL.get(kind, {})}
    for key in value.keys() - {"type"}:
        if key not in allowed:
            raise BadMessage(f"{kind}: unknown key")
        if not allowed[key](value[key]):
            raise BadMessage(f"{kind}: {key} is wrong or out of range")
    for key in keys:
        if key not in value:
            raise BadMessage(f"{kind}: {key} is missing")
    return value  # type: ignore[no-any-return]


def _no_constant(name: str) -> float:
    raise ValueError(name)
