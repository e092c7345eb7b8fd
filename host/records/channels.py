"""The channels of a record: topic, what it holds, and the JSON schema of its messages (docs/records.md)."""

from typing import Any

from shared.planner.command import COMMAND_SIZE

NUMBER: dict[str, Any] = {"type": "number"}
WHOLE: dict[str, Any] = {"type": "integer"}
TEXT: dict[str, Any] = {"type": "string"}
YES: dict[str, Any] = {"type": "boolean"}


def _many(of: dict[str, Any], count: int) -> dict[str, Any]:
    return {"type": "array", "items": of, "minItems": count, "maxItems": count}


JOINT_NUMBERS = _many(NUMBER, 12)

# Topic -> field -> schema. Every tick, but /state, /gait and /fault (on change), /health (once a second).
CHANNELS: dict[str, dict[str, dict[str, Any]]] = {
    "/command": {
        "driver": TEXT,
        "posture": TEXT,
        "mode": TEXT,
        "gait": TEXT,
        "vx_m_s": NUMBER,
        "vy_m_s": NUMBER,
        "wz_rad_s": NUMBER,
        "pose": _many(NUMBER, 6),
        "balance": YES,
        "stop": TEXT,
    },
    "/state": {"state": TEXT, "reason": TEXT},
    "/gait": {"walks": TEXT, "remark": TEXT},
    "/stability": {"margin_m": NUMBER},
    "/fault": {"cause": TEXT, "action": TEXT, "sentence": TEXT},
    "/attitude": {"known": YES, "roll_rad": NUMBER, "pitch_rad": NUMBER},
    "/joints": {"wanted_rad": JOINT_NUMBERS, "measured_rad": JOINT_NUMBERS, "speed_rad_s": JOINT_NUMBERS},
    "/load": {"load": JOINT_NUMBERS},
    "/health": {"temperature_C": JOINT_NUMBERS, "voltage_V": JOINT_NUMBERS, "bus_errors": WHOLE},
    "/timing": {"tick": WHOLE, "late_ms": NUMBER, "busy_ms": NUMBER, "missed": WHOLE},
    "/planner": {
        "tick": WHOLE,
        "command": _many(WHOLE, COMMAND_SIZE),
        "sensed": _many(WHOLE, 20),
        "joints": _many(WHOLE, 12),
        "flags": WHOLE,
    },
}


def schema(topic: str) -> dict[str, Any]:
    """Return a topic's JSON schema."""
    fields = CHANNELS[topic]
    return {"type": "object", "title": topic.lstrip("/"), "properties": fields, "required": list(fields)}
