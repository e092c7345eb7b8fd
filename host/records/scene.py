"""The robot for viewers, as messages of Foxglove's standard schemas: its links' places and shapes.

Frames: ``odom`` is where the robot stood up, level, z = 0 on the ground; ``base_link`` the body. The others are the
URDF's (host/robot/shapes.py), so that a viewer may take either. Lengths in m, angles as quaternions, to 1e-5.
"""

from collections.abc import Sequence
from math import cos, pi, sin
from typing import Any

from ..control.odometry import Odometry
from ..robot.kinematics_si import Vector
from ..robot.model import Robot
from ..robot.shapes import COLOURS, ROOT_LINK, Frame, Shape, frames, shapes
from ..robot.urdf import urdf
from ..robot.view import View

WORLD = "odom"
DIGITS = 5
Turn = tuple[float, float, float, float]  # quaternion x, y, z, w
Messages = dict[str, dict[str, Any]]  # by topic
_TOLD = (0, 1, 5)  # the known ones of x, y, z and the turns about them
_STILL: Turn = (0.0, 0.0, 0.0, 1.0)
_LISTS = {"box": "cubes", "cylinder": "cylinders", "sphere": "spheres"}


class Scene:
    """One robot's messages."""

    def __init__(self, robot: Robot) -> None:
        self._view, self._frames, self._shapes = View(robot), list(frames(robot)), list(shapes(robot))
        self._joints = [frame.name + "_joint" for frame in self._frames if frame.joint is not None]
        self._foot_m = robot.geometry.foot_radius_m
        self._description = {"data": urdf(robot)}

    def parts(self, time_ns: int) -> Messages:
        """Return the robot's shapes and its URDF, which do not change."""
        links = dict.fromkeys(shape.link for shape in self._shapes)
        entities = [_entity(link, [each for each in self._shapes if each.link == link], time_ns) for link in links]
        return {"/scene": {"entities": entities}, "/robot_description": self._description}

    def places(
        self,
        time_ns: int,
        joints_rad: Sequence[float],
        attitude_rad: Sequence[float] | None,
        at: Odometry,
        speed_rad_s: Sequence[float] | None = None,
    ) -> Messages:
        """Return where the body and its links are.

        ``attitude_rad``: roll and pitch, None if not known.
        """
        roll_rad, pitch_rad = attitude_rad or (0.0, 0.0)
        ground_m = self._view.points(joints_rad, roll_rad, pitch_rad, 0)["ground_m"]
        place = (at.x_m, at.y_m, self._foot_m - ground_m)
        turn = _product(_about(2, at.yaw_rad), _product(_about(0, roll_rad), _about(1, pitch_rad)))
        stamp = _time(time_ns)
        transforms = [_transform(stamp, WORLD, ROOT_LINK, place, turn)]
        transforms += [_link(stamp, frame, joints_rad) for frame in self._frames]
        return {
            "/tf": {"transforms": transforms},
            "/odometry": _odometry(stamp, at, _pose(place, turn)),
            "/joint_states": {"timestamp": stamp, "joints": self._states(joints_rad, speed_rad_s)},
        }

    def _states(self, joints_rad: Sequence[float], speed_rad_s: Sequence[float] | None) -> list[dict[str, Any]]:
        states: list[dict[str, Any]] = [
            {"name": name, "position": round(angle, DIGITS)}
            for name, angle in zip(self._joints, joints_rad, strict=True)
        ]
        for state, speed in zip(states, speed_rad_s or (), strict=False):
            state["velocity"] = round(speed, DIGITS)
        return states


def _link(stamp: dict[str, int], frame: Frame, joints_rad: Sequence[float]) -> dict[str, Any]:
    turn = _STILL if frame.joint is None else _about(frame.axis, joints_rad[frame.joint])
    return _transform(stamp, frame.parent, frame.name, frame.at_m, turn)


def _transform(stamp: dict[str, int], parent: str, child: str, at_m: Vector, turn: Turn) -> dict[str, Any]:
    names = {"parent_frame_id": parent, "child_frame_id": child}
    return {"timestamp": stamp, **names, "translation": _vector(at_m), "rotation": _quaternion(turn)}


def _odometry(stamp: dict[str, int], at: Odometry, pose: dict[str, Any]) -> dict[str, Any]:
    """Return the body's place and motion; in the 6 x 6 covariances, only x, y and the turn about z are known."""
    covariance = [0.0] * 36
    for i, row in enumerate(_TOLD):
        for j, column in enumerate(_TOLD):
            covariance[6 * row + column] = at.covariance[3 * i + j]
    about = {"timestamp": stamp, "frame_id": WORLD, "body_frame_id": ROOT_LINK, "pose": pose}
    speeds = {"linear_velocity": _vector((at.vx_m_s, at.vy_m_s, 0.0))}
    speeds |= {"angular_velocity": _vector((0.0, 0.0, at.wz_rad_s))}
    return {**about, **speeds, "pose_covariance": covariance}


def _entity(link: str, found: Sequence[Shape], time_ns: int) -> dict[str, Any]:
    """Return a link's shapes; they stay until others come, and move with their frame."""
    solids: dict[str, list[dict[str, Any]]] = {name: [] for name in _LISTS.values()}
    for shape in found:
        solid: dict[str, Any] = {"pose": _pose(shape.at_m, _about(0, pi / 2) if shape.across else _STILL)}
        solid |= {"size": _vector(_size(shape)), "color": dict(zip("rgba", COLOURS[shape.colour], strict=True))}
        if shape.kind == "cylinder":
            solid |= {"bottom_scale": 1.0, "top_scale": 1.0}
        solids[_LISTS[shape.kind]].append(solid)
    forever = {"sec": 0, "nsec": 0}
    about = {"timestamp": _time(time_ns), "frame_id": link, "id": link, "lifetime": forever, "frame_locked": True}
    return {**about, **solids}


def _size(shape: Shape) -> Vector:
    """Return the edges of the box that a shape fills."""
    if shape.kind == "box":
        x, y, z = shape.size_m
        return x, y, z
    wide_m = 2 * shape.size_m[0]
    return wide_m, wide_m, shape.size_m[1] if shape.kind == "cylinder" else wide_m


def _pose(at_m: Vector, turn: Turn) -> dict[str, Any]:
    return {"position": _vector(at_m), "orientation": _quaternion(turn)}


def _vector(values: Vector) -> dict[str, float]:
    return {name: round(value, DIGITS) for name, value in zip("xyz", values, strict=True)}


def _quaternion(turn: Turn) -> dict[str, float]:
    return {name: round(value, DIGITS) for name, value in zip("xyzw", turn, strict=True)}


def _time(time_ns: int) -> dict[str, int]:
    return {"sec": time_ns // 1_000_000_000, "nsec": time_ns % 1_000_000_000}


def _about(axis: int, angle_rad: float) -> Turn:
    """Return the turn about x, y or z."""
    s = sin(angle_rad / 2)
    return s * (axis == 0), s * (axis == 1), s * (axis == 2), cos(angle_rad / 2)


def _product(a: Turn, b: Turn) -> Turn:
    """Return the turn that does b first, then a (Hamilton's product)."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )
