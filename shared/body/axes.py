"""Records with axes: x forward, y left, z up, turns about them (ROS REP 103). In lu and brad unless otherwise named."""

from ..record import Axes, field, record
from ..runtime import const

POSE_AXES = const(6)
TWIST_AXES = const(3)


@record
class Spot(Axes):
    """A place on the ground, a way along it, or a speed."""

    x: int = field("lu", "forward")
    y: int = field("lu", "left")


@record
class Point(Axes):
    """A place, a way to one, or a direction."""

    x: int = field("lu", "forward")
    y: int = field("lu", "left")
    z: int = field("lu", "up")


@record
class Tilt(Axes):
    """How a body leans."""

    roll: int = field("brad", "about x")
    pitch: int = field("brad", "about y: nose down")


@record
class Turn(Axes):
    """How far a body turns about each axis."""

    x: int = field("2^-18 rad", "about x")
    y: int = field("2^-18 rad", "about y: nose down")
    z: int = field("2^-18 rad", "about z: to the left")


@record
class Pose(Axes):
    """Where a body is in a frame. The order of its rotations is that of pose.py."""

    x: int = field("lu", "forward")
    y: int = field("lu", "left")
    z: int = field("lu", "up")
    roll: int = field("brad", "about x")
    pitch: int = field("brad", "about y: nose down")
    yaw: int = field("brad", "about z: to the left")


@record
class Twist(Axes):
    """How fast a body goes over the ground, in its own frame."""

    vx: int = field("lf / tick", "forward")
    vy: int = field("lf / tick", "left")
    wz: int = field("yaw18 / tick", "turning to the left")
