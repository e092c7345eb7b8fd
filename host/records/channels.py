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
    # Of caramelo identify only: one joint swept, all joints together. Angles are the servos' shafts'.
    "/sweep": {
        "joint": WHOLE,
        "sweep": TEXT,
        "goal_rad": NUMBER,
        "most": NUMBER,
        "sent_s": NUMBER,
        "asked_s": NUMBER,
        "answered_s": NUMBER,
        "position_rad": NUMBER,
        "load": NUMBER,
        "voltage_V": NUMBER,
    },
    "/stance": {
        "what": TEXT,
        "sent_s": NUMBER,
        "goal_rad": JOINT_NUMBERS,
        "most": NUMBER,
        "at_s": NUMBER,
        "position_rad": JOINT_NUMBERS,
        "load": JOINT_NUMBERS,
        "voltage_V": JOINT_NUMBERS,
    },
}


def _object(title: str, **fields: dict[str, Any]) -> dict[str, Any]:
    return {"type": "object", "title": title, "properties": fields}


def _list(of: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": of}


_TIME, _LASTS = (_object(title, sec=WHOLE, nsec=WHOLE) for title in ("time", "duration"))
_VECTOR = _object("foxglove.Vector3", x=NUMBER, y=NUMBER, z=NUMBER)
_TURN = _object("foxglove.Quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)
_POSE = _object("foxglove.Pose", position=_VECTOR, orientation=_TURN)
_COLOUR = _object("foxglove.Color", r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
_SOLID = {"pose": _POSE, "size": _VECTOR, "color": _COLOUR}
_TRANSFORM = _object(
    "foxglove.FrameTransform", timestamp=_TIME, parent_frame_id=TEXT, child_frame_id=TEXT, translation=_VECTOR,
    rotation=_TURN,
)  # fmt: skip
_ENTITY = _object(
    "foxglove.SceneEntity", timestamp=_TIME, frame_id=TEXT, id=TEXT, lifetime=_LASTS, frame_locked=YES,
    cubes=_list(_object("foxglove.CubePrimitive", **_SOLID)),
    spheres=_list(_object("foxglove.SpherePrimitive", **_SOLID)),
    cylinders=_list(_object("foxglove.CylinderPrimitive", **_SOLID, bottom_scale=NUMBER, top_scale=NUMBER)),
)  # fmt: skip
_JOINT = _object("foxglove.JointState", name=TEXT, position=NUMBER, velocity=NUMBER)

# Topic -> schema of the messages that viewers know by their titles: Foxglove's own, and ROS's for the URDF. What they
# hold is made in scene.py, and follows from the channels above.
DRAWN: dict[str, dict[str, Any]] = {
    "/tf": _object("foxglove.FrameTransforms", transforms=_list(_TRANSFORM)),
    "/odometry": _object(
        "foxglove.Odometry", timestamp=_TIME, frame_id=TEXT, body_frame_id=TEXT, pose=_POSE, linear_velocity=_VECTOR,
        angular_velocity=_VECTOR, pose_covariance=_many(NUMBER, 36),
    ),
    "/joint_states": _object("foxglove.JointStates", timestamp=_TIME, joints=_list(_JOINT)),
    "/scene": _object("foxglove.SceneUpdate", entities=_list(_ENTITY)),
    "/robot_description": _object("std_msgs/String", data=TEXT),
}


def schema(topic: str) -> dict[str, Any]:
    """Return a topic's JSON schema, whose title is the schema's name."""
    if topic in DRAWN:
        return DRAWN[topic]
    fields = CHANNELS[topic]
    return {"type": "object", "title": topic.lstrip("/"), "properties": fields, "required": list(fields)}
